"""What a sensitivity study says, beside section IV: ranges, agreement with Table VI, ellipses, saturation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import pandas as pd
import xarray as xr

from glossa import paper
from glossa.anatomy.arrays import FloatArray
from glossa.errors import InputError
from glossa.studies.dispersion import SIGMAS, Ellipse, dispersion_ellipse

LEAST_CHANGE = 5.0
"""Change of a formant in Table VI from which its sign counts, Hz: nearer to zero it is rounding as much as effect."""

PANELS: Mapping[str, tuple[str, ...] | None] = MappingProxyType(
    {"all": None, "GGp": ("GGp",), "GGa": ("GGa",), "Sty": ("Sty",)}
)
"""Panels (a) to (d) of fig. 11 and the muscles whose runs they show; None: every muscle."""

JUST_NOTICEABLE = 0.05
"""Share of a formant whose change listeners notice: 3 to 5 % (Flanagan 1955, J. Acoust. Soc. Am. 27:613)."""

TABLE_VOWEL = "i"
"""Of Table VI."""

_FORMANTS = (1, 2, 3)
_AXES = {"major": "mm", "minor": "mm", "semi_major": "mm", "semi_minor": "mm", "angle": "degrees"}


def sensitivity_summary(study: xr.Dataset, sigmas: float = SIGMAS) -> xr.Dataset:
    """Numbers of section IV from a study of :func:`glossa.studies.sensitivity`, the paper's beside them.

    Returns:
        Over ``formant`` (F1 to F3): ``range``, Hz, largest minus smallest value over the runs, as the paper's 103, 250
        and 283 Hz are of Table VI. Of runs that Table VI has, too (/i/ only, else NaN and 0): ``correlation`` of the
        changes, ``slope`` (ours per Hz of theirs), ``rms`` of the differences, Hz, ``compared``, and of those in which
        the paper's change is at least 5 Hz, ``large``, how many have the same sign, ``same_sign``.
        Over ``panel`` (of fig. 11) and ``node``: ``major``, ``minor`` (whole axes), ``semi_major``, ``semi_minor``, mm,
        ``angle``, degrees, of the ellipses of ``sigmas`` standard deviations, ``centre (…, plane)``, mm, ``inside``,
        the share of samples inside, and ``samples``. NaN where there are too few or degenerate samples.
        For GGa: ``saturation_range``, Hz, of F1 over its changes, ``saturation_monotone``, whether F1 never falls as
        the muscle grows stronger, and ``saturation_refuted``: the range is more than 5 % of the vowel's F1, so that
        changes of this command are heard. NaN and False without runs of GGa.
        ``runs``, ``failed``; ``coverage``: share of a normal law within the ellipses.
        ``paper_range``, ``paper_major``, ``paper_minor``, ``paper_angle``, ``paper_saturation_range``: NaN but for /i/.

    Raises:
        InputError: not such a study, or ``sigmas`` that are not positive.
    """
    if study.attrs.get("study") != "sensitivity":
        raise InputError("a summary needs the result of glossa.studies.sensitivity")
    study = study.transpose("muscle", "change", ...)
    asked = study["asked"].to_numpy()
    bad = asked & ~(study["converged"].to_numpy() & np.isfinite(study["formants"].to_numpy()[..., :3]).all(axis=-1))
    result = xr.Dataset(
        {
            **_formants(study, asked),
            **_ellipses(study, sigmas),
            **_saturation(study),
            "runs": int(asked.sum()),
            "failed": int(bad.sum()),
            "coverage": -math.expm1(-0.5 * sigmas**2),
        },
        coords={
            "formant": list(_FORMANTS),
            "panel": list(PANELS),
            "node": study["node"].to_numpy(),
            "plane": ["x", "z"],
        },
        attrs={**study.attrs, "sigmas": float(sigmas)},
    )
    return result.assign(_published(study))


def compared_changes(study: xr.Dataset) -> pd.DataFrame:
    """Changes of F1 to F3 against the vowel itself, ours and the paper's, Hz, of the runs that Table VI has, too.

    Index ``(muscle, change_percent)``; columns ``F1``, ``F2``, ``F3`` and ``paper_F1``, ``paper_F2``, ``paper_F3``.
    Empty for other vowels than /i/.
    """
    columns = [f"{who}F{n}" for who in ("", "paper_") for n in _FORMANTS]
    published = paper.sensitivity_i()
    own = paper.formants_simulated()
    theirs = published - [own[f"F{n}_Hz"][TABLE_VOWEL] for n in _FORMANTS]
    runs = [(muscle, change) for muscle, change in published.index.to_list() if _asked(study, muscle, change)]
    if study.attrs["vowel"] != TABLE_VOWEL or not runs:
        return pd.DataFrame(columns=columns, index=published.index[:0], dtype=float)
    ours = study["formants"] - study["vowel_formants"]
    rows = np.array([ours.sel(muscle=muscle, change=change).to_numpy()[:3] for muscle, change in runs])
    index = pd.MultiIndex.from_tuples(runs, names=published.index.names)
    return pd.DataFrame(np.hstack([rows, theirs.loc[runs].to_numpy(dtype=float)]), columns=columns, index=index)


def _asked(study: xr.Dataset, muscle: str, change: float) -> bool:
    asked = study["asked"]
    known = muscle in asked["muscle"] and change in asked["change"]
    return known and bool(asked.sel(muscle=muscle, change=change))


def _formants(study: xr.Dataset, asked: FloatArray) -> dict[str, object]:
    values = study["formants"].to_numpy()[asked][:, :3]
    spans = [np.ptp(column[np.isfinite(column)]) if np.isfinite(column).any() else math.nan for column in values.T]
    table = compared_changes(study)
    agreement = [_agreement(table[f"F{n}"].to_numpy(), table[f"paper_F{n}"].to_numpy()) for n in _FORMANTS]
    names = ("correlation", "slope", "rms", "compared", "large", "same_sign")
    return {
        "range": (("formant",), np.array(spans), {"units": "Hz"}),
        **{
            name: (("formant",), np.array(column))
            for name, column in zip(names, zip(*agreement, strict=True), strict=True)
        },
    }


def _agreement(ours: FloatArray, theirs: FloatArray) -> tuple[float, float, float, int, int, int]:
    """Correlation, slope, rms, runs compared, large changes of the paper, and how many have its sign."""
    large = np.abs(theirs) >= LEAST_CHANGE
    same = int((np.sign(ours[large]) == np.sign(theirs[large])).sum())
    known = np.isfinite(ours)
    a, b = ours[known], theirs[known]
    if len(a) < 3 or not np.ptp(a) or not np.ptp(b):
        return math.nan, math.nan, math.nan, len(a), int(large.sum()), same
    slope = float(np.polyfit(b, a, 1)[0])
    return float(np.corrcoef(a, b)[0, 1]), slope, float(np.sqrt(((a - b) ** 2).mean())), len(a), int(large.sum()), same


def dispersion_of(study: xr.Dataset, panel: str, node: str, sigmas: float = SIGMAS) -> Ellipse:
    """Ellipse, in mm, of one node over the converged runs of one panel of :data:`PANELS`.

    Raises:
        InputError: an unknown panel, or as :func:`glossa.studies.dispersion_ellipse`.
    """
    return dispersion_ellipse(scatter(study, panel, node), sigmas)


def scatter(study: xr.Dataset, panel: str, node: str) -> FloatArray:
    """(runs, 2) positions, x and z in mm, of one node in the converged runs of one panel.

    Raises:
        InputError: an unknown panel.
    """
    if panel not in PANELS:
        raise InputError(f"panel must be one of {', '.join(PANELS)}, got {panel!r}")
    muscles = PANELS[panel]
    study = study.transpose("muscle", "change", ...)
    known = study["muscle"].values.tolist()
    shown = study if muscles is None else study.sel(muscle=[muscle for muscle in muscles if muscle in known])
    places = shown["nodes"].sel(node=node, axis=["x", "z"]).to_numpy()
    return np.asarray(places[(shown["asked"] & shown["converged"]).to_numpy()] * 1e3)


def _ellipses(study: xr.Dataset, sigmas: float) -> dict[str, object]:
    nodes = study["node"].values.tolist()
    shape = (len(PANELS), len(nodes))
    numbers = {name: np.full(shape, math.nan) for name in (*_AXES, "inside")}
    centre, samples = np.full((*shape, 2), math.nan), np.zeros(shape, dtype=int)
    for place in np.ndindex(shape):
        points = scatter(study, list(PANELS)[place[0]], nodes[place[1]])
        samples[place] = len(points)
        try:
            ellipse = dispersion_ellipse(points, sigmas)
        except InputError:  # too few or degenerate: no ellipse, told by NaN
            continue
        centre[place] = ellipse.centre
        for name, values in numbers.items():
            values[place] = getattr(ellipse, name)
    dims = ("panel", "node")
    return {
        **{name: (dims, values, {"units": _AXES.get(name, "1")}) for name, values in numbers.items()},
        "centre": ((*dims, "plane"), centre, {"units": "mm"}),
        "samples": (dims, samples),
    }


def _saturation(study: xr.Dataset) -> dict[str, object]:
    f1 = study["formants"].sel(formant=1)
    curve = f1.sel(muscle="GGa").to_numpy() if "GGa" in study["muscle"] else np.full(0, math.nan)
    curve = curve[np.isfinite(curve)]
    if len(curve) < 2:
        return {
            "saturation_range": ((), math.nan, {"units": "Hz"}),
            "saturation_monotone": False,
            "saturation_refuted": False,
        }
    span = float(np.ptp(curve))
    return {
        "saturation_range": ((), span, {"units": "Hz"}),
        "saturation_monotone": bool((np.diff(curve) <= 0.5).all()),  # Table VI is rounded to 1 Hz
        "saturation_refuted": span > JUST_NOTICEABLE * float(study["vowel_formants"][0]),
    }


def _published(study: xr.Dataset) -> dict[str, object]:
    table = paper.dispersion()
    ours = study.attrs["vowel"] == TABLE_VOWEL
    spans = np.ptp(paper.sensitivity_i().to_numpy(dtype=float), axis=0)
    of_gga = paper.sensitivity_i().xs("GGa", level="muscle")["F1_Hz"].to_numpy(dtype=float)
    gap = 1.0 if ours else math.nan
    rows = table.reindex(study["node"].values.tolist())
    return {
        "paper_range": (("formant",), spans * gap, {"units": "Hz"}),
        "paper_saturation_range": ((), float(np.ptp(of_gga)) * gap, {"units": "Hz"}),
        "paper_major": (("node",), rows["major_mm"].to_numpy(dtype=float) * gap, {"units": "mm"}),
        "paper_minor": (("node",), rows["minor_mm"].to_numpy(dtype=float) * gap, {"units": "mm"}),
        "paper_angle": (("node",), rows["angle_deg"].to_numpy(dtype=float) * gap, {"units": "degrees"}),
    }
