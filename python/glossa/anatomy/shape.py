"""Shape parameters of the built-in speaker: named ways to change its landmarks together.

Landmarks are linear in them: an entry of a landmark table counts as table + sum of value * weights. Names, meanings,
weights, values and limits stand in data/landmarks/reference_shape.toml.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, frozen
from glossa.anatomy.landmark_tables import (
    FILES,
    Tables,
    add_to_entry,
    built_in_tables,
    entries,
    read_toml,
    weights_shape,
)
from glossa.checks import finite_number, positive_number
from glossa.data_files import data_path
from glossa.errors import InputError

_FILE = "landmarks/reference_shape.toml"
_HEAD = {"format": "glossa-shape", "version": 1}
_KEYS = ("meaning", "unit", "limits", "value", "step", *FILES)


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapeParameter:
    """One way to change a speaker's landmarks.

    Attributes:
        name: as in files.
        meaning: what it does to the anatomy.
        unit: of ``limits`` and ``value``.
        limits: least and largest total value.
        value: of the built-in speaker.
        step: change with which the calibration takes differences; None: it leaves the parameter alone.
        tongue, walls: weights by entry of the landmark tables, mm (degrees for angles) for a value of 1.
    """

    name: str
    meaning: str
    unit: str
    limits: tuple[float, float]
    value: float
    step: float | None
    tongue: Mapping[str, FloatArray]
    walls: Mapping[str, FloatArray]

    @property
    def room(self) -> tuple[float, float]:
        """Least and largest amount that may be added to the built-in value."""
        low, high = self.limits
        return low - self.value, high - self.value

    def add_to(self, part: str, tables: Tables, value: float) -> None:
        """Change the landmark tables of a part, "tongue" or "walls", in place.

        Raises:
            InputError: the tables have another number of rows than the built-in ones.
        """
        for entry, weights in getattr(self, part).items():
            shape = weights_shape(tables, entry)
            if shape != weights.shape:
                raise InputError(
                    f"shape parameter {self.name} has weights for {len(weights)} values of {entry}, and there are "
                    f"{shape[0]}: keep the number of rows, or set {self.name} = {-self.value:g} in [shape], which "
                    f"switches it off"
                )
            add_to_entry(tables, entry, value * weights)


def shape_parameters(path: Path | None = None) -> dict[str, ShapeParameter]:
    """The parameters of a file, by name; None takes those of the built-in speaker.

    Raises:
        InputError: no such file, no TOML, unknown entries, weights of a wrong shape, or values outside of the limits;
            the message names file, parameter and entry.
    """
    path = data_path(_FILE) if path is None else path
    content = read_toml(path)
    known = {part: built_in_tables(part) for part in FILES}
    try:
        for key, wanted in _HEAD.items():
            if content.get(key) != wanted:
                raise InputError(f"{key} must be {wanted!r}, got {content.get(key)!r}")
        return {name: _parameter(name, entry, known) for name, entry in content.items() if name not in (*_HEAD, "name")}
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _parameter(name: str, entry: Any, known: Mapping[str, Tables]) -> ShapeParameter:
    if not isinstance(entry, dict):
        raise InputError(f"{name}: a shape parameter must be a table, got {entry!r}")
    for key in entry:
        if key not in _KEYS:
            raise InputError(f"{name}: unknown entry {key!r}; known are {', '.join(_KEYS)}")
    for key in ("meaning", "unit"):
        if not isinstance(entry.get(key), str):
            raise InputError(f"{name}: {key} must be a text, got {entry.get(key)!r}")
    limits = entry.get("limits")
    if not isinstance(limits, list) or len(limits) != 2:
        raise InputError(f"{name}: limits must be [least, largest], got {limits!r}")
    low, high = (finite_number(limit, f"{name}: limits") for limit in limits)
    value = finite_number(entry.get("value"), f"{name}: value")
    if not low <= value <= high:
        raise InputError(f"{name}: limits must be ascending and hold the value {value:g}, got {limits}")
    step = None if "step" not in entry else positive_number(entry["step"], f"{name}: step")
    weights = {part: _weights(f"{name}: {part}", entry.get(part, {}), known[part]) for part in FILES}
    return ShapeParameter(
        name=name,
        meaning=entry["meaning"],
        unit=entry["unit"],
        limits=(low, high),
        value=value,
        step=step,
        **weights,
    )


def _weights(what: str, given: Any, tables: Tables) -> dict[str, FloatArray]:
    if not isinstance(given, dict):
        raise InputError(f"{what} must be a table, got {given!r}")
    known = entries(tables)
    result = {}
    for entry, values in given.items():
        if entry not in known:
            raise InputError(f"{what}: unknown entry {entry!r}; known are {', '.join(known)}")
        shape = weights_shape(tables, entry)
        try:
            weights = np.array(values, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{what}: {entry} must hold numbers") from None
        if weights.shape != shape or not np.isfinite(weights).all():
            raise InputError(f"{what}: {entry} must hold finite numbers of shape {shape}, got shape {weights.shape}")
        result[entry] = frozen(weights)
    return result
