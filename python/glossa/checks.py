"""Checks of single arguments, with messages that name the argument and the value found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np

from glossa.errors import InputError


def finite_number(value: Any, what: str) -> float:
    """The value as float.

    Raises:
        InputError: not a number, NaN or infinite; ``what`` names it in the message.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{what} must be a number, got {value!r}")
    number = float(value)
    if not math.isfinite(number):
        raise InputError(f"{what} must be finite, got {number!r}")
    return number


def positive_number(value: Any, what: str) -> float:
    """The value as float above 0.

    Raises:
        InputError: anything else.
    """
    number = finite_number(value, what)
    if number <= 0.0:
        raise InputError(f"{what} must be positive, got {number!r}")
    return number


def not_negative_number(value: Any, what: str) -> float:
    """The value as float of at least 0.

    Raises:
        InputError: anything else.
    """
    number = finite_number(value, what)
    if number < 0.0:
        raise InputError(f"{what} must not be negative, got {number!r}")
    return number


def whole_number(value: Any, what: str, least: int, most: int) -> int:
    """A whole number between two limits, both included.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InputError(f"{what} must be a whole number from {least} to {most}, got {value!r}")
    return int(value)


def flag(value: Any, what: str) -> bool:
    """True or False.

    Raises:
        InputError: anything else; ``what`` names it in the message.
    """
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{what} must be True or False, got {value!r}")
    return bool(value)


def one_of(value: Any, allowed: Sequence[str], what: str) -> str:
    """One of the allowed words.

    Raises:
        InputError: anything else; the message lists what is allowed.
    """
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{what} must be one of {', '.join(map(repr, allowed))}, got {value!r}")
    return value


def instance(value: Any, kind: type, what: str, *, optional: bool = False) -> Any:
    """An instance of ``kind``, or None where that is allowed.

    Raises:
        InputError: anything else.
    """
    if value is None and optional:
        return None
    if not isinstance(value, kind):
        alternative = " or None" if optional else ""
        raise InputError(f"{what} must be a {kind.__name__}{alternative}, got {value!r}")
    return value
