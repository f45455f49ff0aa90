"""What one point of a study asks for, and how it is written down."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np

from glossa.checks import finite_number
from glossa.errors import InputError
from glossa.motor.commands import MotorCommands
from glossa.tract import Lips
from glossa.tract.lips import as_lips


@dataclass(frozen=True, kw_only=True)
class Point:
    """One equilibrium, and the sound of it where lips are given.

    Attributes:
        commands: lambda as fractions of rest length by muscle; muscles not named are silent, as in
            :class:`glossa.MotorCommands`.
        lips: name of a vowel of Table IV, a pair (length m, area m2) or Lips; None: no acoustics.
        scene: options of :class:`glossa.Scene` that differ from those of the study's scene.
        shape: shape parameters of the built-in speaker, added to its own as by
            ``Speaker.reference(landmarks={"shape": ...})``.
        labels: coordinates of the point in the result, numbers or words.

    Raises:
        InputError: malformed values, saying which. Names of muscles, options and parameters are checked by the study,
            against its scene.
    """

    commands: Mapping[str, float]
    lips: str | tuple[float, float] | Lips | None = None
    scene: Mapping[str, Any] = field(default_factory=dict)
    shape: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("scene", "shape", "labels"):
            value = getattr(self, name)
            if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
                raise InputError(f"{name} of a point must be a mapping of names to values, got {value!r}")
        shape = {name: finite_number(value, f"shape parameter {name}") for name, value in self.shape.items()}
        labels = {name: _label(name, value) for name, value in self.labels.items()}
        lips = self.lips
        if lips is not None:
            known = as_lips(lips)
            lips = lips if isinstance(lips, str) else (known.length, known.area)
        for name, checked in (
            ("commands", dict(MotorCommands(self.commands))),
            ("lips", lips),
            ("scene", dict(self.scene)),
            ("shape", shape),
            ("labels", labels),
        ):
            object.__setattr__(self, name, checked)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: equal points give equal ones."""
        return {each.name: plain(getattr(self, each.name)) for each in fields(self)}


def _label(name: str, value: Any) -> float | str:
    return value if isinstance(value, str) else finite_number(value, f"label {name}")


def plain(value: Any) -> Any:
    """Scene options and the like as values for JSON; a dataclass as its fields, tuples and arrays as lists.

    Raises:
        InputError: something that has no such form.
    """
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if is_dataclass(value) and not isinstance(value, type):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value) if each.name != "_"}
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    raise InputError(f"a study cannot write {type(value).__name__} down, got {value!r}")


def canonical(value: Any) -> str:
    """JSON of :func:`plain` values with sorted names: the same text for equal values, doubles to the last bit.

    Raises:
        InputError: NaN or infinite numbers, or as :func:`plain`.
    """
    try:
        return json.dumps(plain(value), sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"a study cannot write {value!r} down: {error}") from None
