"""Checks of single arguments, with messages that name the argument and the value found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa.errors import InputError


def finite_number(value: Any, what: str) -> float:
    """The value as float.

    Raises:
        InputError: not a number, NaN or infinite; ``what`` names it in the message.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{what} must be a number, got {value!r}")
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond the range of doubles
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{what} must be finite, got {number!r}")
    return number


def real_array(value: Any, rule: str) -> NDArray[np.float64]:
    """A new array of doubles, of any shape.

    Args:
        value: anything numpy turns into an array of numbers.
        rule: what is expected, with its name: the message begins with it.

    Raises:
        InputError: no numbers, complex ones, too large ones or rows of unequal length.
    """
    try:
        given = np.array(value)
        if given.dtype.kind == "c":
            raise TypeError("complex numbers")
        return np.array(given, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{rule}, got {_short(value)} ({error})") from None


def items(value: Any, what: str) -> tuple[Any, ...]:
    """What a list, a tuple or anything else that can be gone through holds; not the letters of a string.

    Raises:
        InputError: anything else.
    """
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return tuple(value)
    except TypeError:
        raise InputError(f"{what} must be a list, got {_short(value)}") from None


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


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
        raise InputError(f"{what} must be a whole number from {least} to {most}, got {_short(value)}")
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
