"""What the resolution of the built-in speaker is worth: vowels at r = 1, 2, 3, their changes, and what is left.

Cells have the size h = 1/r. A quantity that converges as f(h) = f(0) + C h^p is known from three resolutions: p from
the ratio of its two changes, f(0) by extrapolation, and with it the error of each resolution (Richardson; Roache 1994,
J. Fluids Eng. 116:405, for steps of any ratio). Where changes grow or turn round no order is observed, and the change
to the finest resolution stands for the error.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.landmarks import COLUMNS, LAYERS, RAYS
from glossa.anatomy.reference_block import Block
from glossa.anatomy.speaker import Speaker
from glossa.checks import whole_number
from glossa.errors import InputError
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.acoustics import formant_table, vowel_tracts
from glossa.studies.vowels import posture_table, vowels

log = logging.getLogger(__name__)

ORDERS = (0.1, 8.0)
"""Between which an observed order is looked for."""

_MOST = 12  # of the resolution: 1.3 million hexahedra


def resolution_study(
    resolutions: Sequence[int] = (1, 2, 3),
    names: Sequence[str] = ("i", "ə", "u", "a"),
    *,
    landmarks: Any = None,
    progress: Callable[[str], None] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Vowels of the built-in speaker at several resolutions.

    Args:
        resolutions: two or more, rising.
        names: vowels of Table III.
        landmarks: as for :meth:`glossa.Speaker.reference`.
        progress: called with a line of text before each resolution.
        options: of :class:`glossa.Scene`; ``mirror`` is True unless given.

    Returns:
        Over ``resolution``, ``vowel``, ``point`` (tip, dorsum), ``axis`` (x, z), ``muscle`` and ``formant``:
        ``displacement`` mm, ``forces`` N, ``formants`` Hz, ``elements``, ``iterations``, ``seconds``; and
        ``change_rms``, ``change_max``, mm, of the positions that all resolutions share, against the next coarser one
        (NaN for the coarsest). NaN where a vowel has not converged or has no tract.

    Raises:
        InputError: bad resolutions or vowels.
    """
    levels = [whole_number(r, "resolution", 1, _MOST) for r in resolutions]
    if len(levels) < 2 or sorted(set(levels)) != levels:
        raise InputError(f"resolutions must be two or more, rising, got {list(resolutions)}")
    found = []
    for r in levels:
        if progress is not None:
            progress(f"resolution {r}")
        speaker = Speaker.reference(r, landmarks)
        postures = vowels(Scene(speaker, **({"mirror": True} | options)), names)
        found.append(_measured(r, speaker, postures))
    result = xr.concat([measured for measured, _ in found], dim="resolution", combine_attrs="drop")
    shared = [positions for _, positions in found]
    for name, norm in (("change_rms", _rms), ("change_max", _largest)):
        rows = [np.full(len(names), math.nan)]
        rows += [np.array([norm(b - a) for a, b in zip(*pair, strict=True)]) for pair in pairwise(shared)]
        result[name] = (("resolution", "vowel"), np.array(rows) * 1e3, {"units": "mm"})
    return result


def _measured(r: int, speaker: Speaker, postures: Mapping[str, Posture]) -> tuple[xr.Dataset, list[FloatArray]]:
    """Numbers of one resolution, and the positions of the nodes of resolution 1, m, by vowel."""
    names = list(postures)
    tracts, reasons = vowel_tracts(postures)
    for name, reason in reasons.items():
        log.warning("resolution %d, vowel %s: %s", r, name, reason)
    nothing = np.full((len(names), 4), math.nan)
    found = formant_table(tracts).frequency.reindex(tract=names).to_numpy() if tracts else nothing
    table = posture_table(postures).rename(posture="vowel")
    dataset = table[["displacement", "forces", "iterations", "seconds"]].drop_attrs(deep=False)
    dataset["formants"] = (("vowel", "formant"), found, {"units": "Hz"})
    dataset["elements"] = len(speaker.hexahedra)
    dataset = dataset.assign_coords(resolution=r, formant=np.arange(1, 5))
    good = table.converged.to_numpy()
    shared = shared_nodes(r)
    return dataset, [
        p.positions[shared] if ok else p.positions[shared] * math.nan
        for p, ok in zip(postures.values(), good, strict=True)
    ]


def shared_nodes(resolution: int) -> IntArray:
    """(1071,) numbers, at ``resolution``, of the nodes of resolution 1, in the order of resolution 1."""
    i, j, k = np.meshgrid(np.arange(RAYS + 1), np.arange(LAYERS + 1), np.arange(-COLUMNS, COLUMNS + 1), indexing="ij")
    return np.asarray(Block(resolution).node(*(index.ravel() * resolution for index in (i, j, k))))


def _rms(change: FloatArray) -> float:
    return float(np.sqrt((change**2).sum(axis=1).mean()))


def _largest(change: FloatArray) -> float:
    return float(np.sqrt((change**2).sum(axis=1)).max())


def observed_order(resolutions: Sequence[int], first: float, second: float) -> float:
    """Order p of C h^p from the sizes of the changes r1 -> r2 and r2 -> r3; NaN where they do not fall as a power does.

    Args:
        resolutions: three, rising.
        first: size of the first change, in any unit.
        second: size of the second change.
    """
    a, b, c = (1.0 / r for r in resolutions)
    if not (first > 0.0 and second > 0.0):
        return math.nan

    def excess(p: float) -> float:
        return float((a**p - b**p) / (b**p - c**p) - first / second)

    low, high = ORDERS
    return math.nan if excess(low) * excess(high) > 0.0 else float(brentq(excess, low, high))


def error_bars(study: xr.Dataset, quantity: str) -> xr.Dataset:
    """Extrapolated values and errors of "displacement", "forces" or "formants" of a study at three resolutions.

    Returns:
        ``limit``: the extrapolated value, that of the finest resolution where no order is observed; ``order``, NaN
        there; ``error (resolution, ...)``: distance from the limit, and for the finest resolution without an order the
        distance from the next coarser one.

    Raises:
        InputError: not three resolutions, or an unknown quantity.
    """
    levels = [int(r) for r in study.resolution]
    if len(levels) != 3:
        raise InputError(f"error bars need three resolutions, got {levels}")
    if quantity not in ("displacement", "forces", "formants"):
        raise InputError(f"quantity must be displacement, forces or formants, got {quantity!r}")
    values = study[quantity].transpose("resolution", ...)
    first, second = (values[k + 1] - values[k] for k in (0, 1))
    _, b, c = (1.0 / r for r in levels)
    order, ahead = np.full(first.shape, math.nan), np.zeros(first.shape)
    for place in np.ndindex(first.shape):
        one, two = float(first.to_numpy()[place]), float(second.to_numpy()[place])
        if one * two > 0.0:
            order[place] = p = observed_order(levels, abs(one), abs(two))
            if math.isfinite(p):
                ahead[place] = two * c**p / (b**p - c**p)
    limit = values[2].drop_vars("resolution") + ahead
    error = np.abs(values - limit)
    error[2] = np.where(np.isfinite(order), error[2], np.abs(second))
    return xr.Dataset({"limit": limit, "order": (limit.dims, order), "error": error})
