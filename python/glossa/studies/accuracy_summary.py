"""What an accuracy study says: worst errors, the choices that pay, the presets, and what leaving effects out saves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from glossa.checks import one_of, positive_number
from glossa.errors import InputError
from glossa.studies.accuracy_choices import KINDS, MOVEMENT, POSTURE, WHOLE
from glossa.studies.accuracy_runs import COUNTS
from glossa.tolerances import ACCURACIES

MEASURES = ("nodes", "largest", "force", "formant")
"""Errors of :func:`worst`."""

COSTS = ("wall_seconds", "cpu_seconds")
"""Times of :func:`worst`."""

_PRESETS = {POSTURE: "preset", MOVEMENT: "adaptive"}


def worst(result: xr.Dataset) -> xr.Dataset:
    """Errors and costs of each choice over all its vowels.

    Args:
        result: of :func:`glossa.studies.accuracy_study`.

    Returns:
        Over ``choice``, with its coordinates: the largest error ``nodes`` (of the six) and ``largest`` (of all) in m,
        ``force`` in N, ``formant`` in Hz; the mean ``wall_seconds``, ``cpu_seconds``, ``iterations``,
        ``factorisations``, ``residuals``, ``steps``; ``failed``, how many of its vowels have none, and then NaN.

    Raises:
        InputError: another study.
    """
    check_accuracy(result)
    asked = result["asked"]
    missing = asked & ~(np.isfinite(result["cpu_seconds"]))
    failed = missing.sum("vowel")
    errors = {
        "nodes": result["node_error"].max("node"),
        "largest": result["largest_error"],
        "force": result["force_error"].max("muscle"),
        "formant": result["formant_error"].max("formant"),
    }
    units = dict(zip(MEASURES, ("m", "m", "N", "Hz"), strict=True))
    found: dict[str, Any] = {}
    for name, values in errors.items():
        unknown = (asked & ~np.isfinite(values)).any("vowel")
        found[name] = values.max("vowel").where(~unknown).assign_attrs(units=units[name])
    for name in (*COSTS, *COUNTS):
        mean = result[name].mean("vowel").where(failed == 0)
        found[name] = mean.assign_attrs(units="s") if name in COSTS else mean
    return xr.Dataset({**found, "failed": failed}, attrs=result.attrs)


def pareto(result: xr.Dataset, measure: str = "nodes", cost: str = "wall_seconds") -> xr.DataArray:
    """Which choices pay: none measured against the same is at most as far off and at most as dear, and better in one.

    What leaving effects out does is no error, so none of these is marked.

    Args:
        result: of :func:`glossa.studies.accuracy_study`.
        measure: "nodes", "largest", "force" or "formant".
        cost: "wall_seconds" or "cpu_seconds".

    Returns:
        Flags over ``choice``.

    Raises:
        InputError: another study, or an unknown measure or cost.
    """
    table = worst(result)
    errors = table[one_of(measure, MEASURES, "measure")].to_numpy()
    seconds = table[one_of(cost, COSTS, "cost")].to_numpy()
    marked = np.zeros(len(errors), dtype=bool)
    groups = table["kind"].to_series() + "/" + table["against"].to_series()
    for group in groups.unique():
        if not group.endswith(f"/{WHOLE}"):
            places = np.flatnonzero(groups.to_numpy() == group)
            marked[places] = _front(errors[places], seconds[places])
    return xr.DataArray(marked, dims="choice", coords=table.coords, name="pareto")


def _front(errors: NDArray[np.float64], seconds: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Those of which no other is at most as large in both and smaller in one."""
    known = np.isfinite(errors) & np.isfinite(seconds)
    better = (errors[:, None] <= errors) & (seconds[:, None] <= seconds)
    better &= (errors[:, None] < errors) | (seconds[:, None] < seconds)
    return np.asarray(known & ~(better & known[:, None]).any(axis=0))


def presets(result: xr.Dataset) -> pd.DataFrame:
    """Measured error and cost of ``accuracy="draft"``, ``"standard"`` and ``"reference"``.

    Errors are those of the solve: of an equilibrium against the same mesh, of a movement against short steps.

    Returns:
        Rows by kind ("posture", "movement") and accuracy; columns ``nodes_mm``, ``largest_mm``, ``force_N``,
        ``formant_Hz`` (largest over vowels), ``wall_s``, ``cpu_s``, ``iterations``, ``factorisations``, ``steps``
        (means over vowels).

    Raises:
        InputError: another study.
    """
    table = _plain(worst(result))
    rows = [
        table[(table["kind"] == kind) & (table["family"] == family) & (table["label"] == accuracy)]
        for kind, family in _PRESETS.items()
        for accuracy in ACCURACIES
    ]
    return pd.concat(rows).rename(columns={"label": "accuracy"}).set_index(["kind", "accuracy"])[list(_COLUMNS)]


def savings(result: xr.Dataset) -> pd.DataFrame:
    """What leaving each effect out changes, and what it saves.

    Returns:
        Rows by kind and effect, the first of each kind with all effects; columns as in :func:`presets`, changes in
        place of errors, and ``saved``: share of the processor time that leaving it out saves (negative: it costs).

    Raises:
        InputError: another study.
    """
    table = _plain(worst(result))
    table = table[table["against"] == WHOLE].rename(columns={"label": "effect"}).set_index(["kind", "effect"])
    whole = table["cpu_s"].xs("all", level="effect").to_dict()
    base = np.array([whole[kind] for kind in table.index.get_level_values("kind")], dtype=float)
    return table[list(_COLUMNS)].assign(saved=1.0 - table["cpu_s"].to_numpy(dtype=float) / base)


def cheapest(
    result: xr.Dataset,
    kind: str = MOVEMENT,
    *,
    nodes: float = math.inf,
    largest: float = math.inf,
    force: float = math.inf,
    formant: float = math.inf,
    cost: str = "wall_seconds",
) -> str | None:
    """The quickest choice of the solve that keeps within what is tolerated.

    Args:
        result: of :func:`glossa.studies.accuracy_study`.
        kind: "posture" or "movement".
        nodes: tolerated error at the six midsagittal nodes, m.
        largest: of all nodes, m.
        force: of muscles, N.
        formant: of formants, Hz.
        cost: "wall_seconds" or "cpu_seconds".

    Returns:
        Family and label, as "adaptive, standard"; None where no choice keeps within.

    Raises:
        InputError: another study, an unknown kind or cost, or a tolerance that is not positive.
    """
    limits = {"nodes": nodes, "largest": largest, "force": force, "formant": formant}
    table = worst(result)
    good = (table["kind"] == one_of(kind, KINDS, "kind")) & table["against"].isin(["solve", "steps"])
    for name, limit in limits.items():
        if limit != math.inf:
            good &= table[name] <= positive_number(limit, name)
    seconds = table[one_of(cost, COSTS, "cost")].where(good)
    if not bool(np.isfinite(seconds).any()):
        return None
    best = table.isel(choice=int(seconds.argmin("choice")))
    return f"{best['family'].item()}, {best['label'].item()}"


_COLUMNS = {
    "nodes_mm": ("nodes", 1e3),
    "largest_mm": ("largest", 1e3),
    "force_N": ("force", 1.0),
    "formant_Hz": ("formant", 1.0),
    "wall_s": ("wall_seconds", 1.0),
    "cpu_s": ("cpu_seconds", 1.0),
    "iterations": ("iterations", 1.0),
    "factorisations": ("factorisations", 1.0),
    "steps": ("steps", 1.0),
}


def _plain(table: xr.Dataset) -> pd.DataFrame:
    """In the units of tables."""
    words = {name: table[name].to_numpy() for name in ("kind", "family", "label", "against")}
    return pd.DataFrame(words | {name: table[own].to_numpy() * scale for name, (own, scale) in _COLUMNS.items()})


def check_accuracy(result: Any) -> None:
    """Refuse what is not the result of an accuracy study.

    Raises:
        InputError: that.
    """
    if not isinstance(result, xr.Dataset) or result.attrs.get("study") != "accuracy":
        raise InputError("this needs the result of glossa.studies.accuracy_study")
