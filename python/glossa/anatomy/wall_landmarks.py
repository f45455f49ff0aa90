"""The landmark table of the walls and the hyoid bone around the built-in tongue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, float_array, frozen
from glossa.checks import positive_number
from glossa.errors import InputError

_COLUMNS = {
    "outer": ("x", "z", "direction", "half_width", "depth", "exponent", "end"),
    "larynx_front": ("z", "x", "exponent"),
    "mandible": ("z", "rise", "x", "step", "half_width", "y90", "y108"),
    "hyoid": ("x", "y", "z", "level_radius", "upright_radius"),
}
_POSITIVE = {"half_width", "depth", "exponent", "end", "step", "y90", "y108", "level_radius", "upright_radius"}
_FEWEST_ROWS = 4  # a cubic spline needs as many

Table = Mapping[str, FloatArray]


@dataclass(frozen=True, eq=False, kw_only=True)
class WallLandmarks:
    """The table, lengths in mm and angles in degrees as in the file (its comments say what each column means).

    Attributes:
        outer: column -> (n,) of the sweep palate, velum, rear wall.
        starts: (3,) rows of ``outer`` where hard palate, soft palate and pharynx begin.
        larynx_front: column -> (n,) of the front of the laryngeal tube, downwards.
        mandible: column -> (n,) of the lower jaw, from below over the crest to the outside.
        mandible_end, rise_length: parameter at which its rows end (at most 4); run of ``rise``, mm.
        hyoid: column -> (n,) of the bone, from the midline to the tip of the horn.
        density, spring_stiffness: kg/m3, N/m.
        springs: name -> (2, 3) point on the bone, fixed point, side y > 0.
    """

    outer: Table
    starts: tuple[int, int, int]
    larynx_front: Table
    mandible: Table
    mandible_end: float
    rise_length: float
    hyoid: Table
    density: float
    spring_stiffness: float
    springs: Mapping[str, FloatArray]


def wall_landmarks(table: Mapping[str, Any]) -> WallLandmarks:
    """The landmarks in a table laid out as data/landmarks/reference_walls.toml.

    Raises:
        InputError: wrong lengths, values that are not finite or, where they must be, not positive; the message names
            table and row.
        KeyError, TypeError, AttributeError: missing or malformed entries.
    """
    tables = {name: _table(name, table[name]) for name in _COLUMNS}
    bone, jaw = table["hyoid"], table["mandible"]
    end = positive_number(jaw["end"], "mandible end")
    if end > 4.0:
        raise InputError(f"mandible end must be at most 4, the parameter of the last point of a row, got {end!r}")
    return WallLandmarks(
        **tables,
        starts=_starts(table["outer"], len(tables["outer"]["x"])),
        mandible_end=end,
        rise_length=positive_number(jaw["rise_length"], "mandible rise_length"),
        density=positive_number(bone["density"], "hyoid density"),
        spring_stiffness=positive_number(bone["spring_stiffness"], "hyoid spring_stiffness"),
        springs={name: _spring(name, ends) for name, ends in bone["springs"].items()},
    )


def _table(name: str, entry: dict[str, Any]) -> dict[str, FloatArray]:
    columns = _COLUMNS[name]
    if tuple(entry["columns"]) != columns:
        raise InputError(f"{name}: columns must be {list(columns)}, got {entry['columns']}")
    for number, row in enumerate(entry["rows"]):
        if len(row) != len(columns):
            raise InputError(
                f"{name}: row {number} has {len(row)} values, expected {len(columns)}: {', '.join(columns)}"
            )
    values = float_array(entry["rows"], f"{name} rows", len(columns))
    if len(values) < _FEWEST_ROWS:
        raise InputError(f"{name}: {len(values)} rows, at least {_FEWEST_ROWS} are needed")
    for column in sorted(_POSITIVE.intersection(columns)):
        bad = np.flatnonzero(values[:, columns.index(column)] <= 0.0)
        if len(bad):
            raise InputError(
                f"{name}: {column} must be positive, row {bad[0]} has {values[bad[0], columns.index(column)]}"
            )
    _check_progress(name, {column: values[:, k] for k, column in enumerate(columns)})
    return {column: frozen(values[:, k].copy()) for k, column in enumerate(columns)}


def _check_progress(name: str, table: dict[str, FloatArray]) -> None:
    """Neighbouring rows stand apart; the larynx's front goes down, the hyoid starts in the midplane and leaves it."""
    place = [table[axis] for axis in ("x", "y", "z") if axis in table]
    same = np.flatnonzero(np.all([np.diff(axis) == 0.0 for axis in place], axis=0))
    if len(same):
        raise InputError(f"{name}: rows {same[0]} and {same[0] + 1} are at the same place")
    if name == "larynx_front" and (np.diff(table["z"]) >= 0.0).any():
        raise InputError(f"{name}: z must fall from row to row")
    if name == "hyoid" and (table["y"][0] != 0.0 or (table["y"][1:] <= 0.0).any()):
        raise InputError(f"{name}: the first row must have y = 0 and the others y > 0")


def _starts(outer: dict[str, Any], rows: int) -> tuple[int, int, int]:
    hard, soft, rear = (outer[wall] for wall in ("hard_palate", "soft_palate", "pharynx"))
    if not all(type(start) is int for start in (hard, soft, rear)) or not 0 <= hard < soft < rear < rows - 1:
        raise InputError(
            f"outer: hard_palate, soft_palate and pharynx must name ascending rows 0..{rows - 2}, "
            f"got {[hard, soft, rear]}"
        )
    return hard, soft, rear


def _spring(name: str, ends: Any) -> FloatArray:
    points = float_array(ends, f"hyoid spring {name}", 3)
    if points.shape != (2, 3) or (points[:, 1] <= 0.0).any() or (points[0] == points[1]).all():
        raise InputError(f"hyoid spring {name}: expected two different points [x, y, z] with y > 0, got {ends}")
    return points
