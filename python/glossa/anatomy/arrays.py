"""Checked, write-protected arrays: the form in which anatomy is stored."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa.checks import real_array
from glossa.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Write-protect an array and return it."""
    array.setflags(write=False)
    return array


def float_array(value: Any, what: str, columns: int | None = None) -> FloatArray:
    """Own, C-contiguous, write-protected float64 copy of ``value``.

    Args:
        value: anything numpy turns into an array of numbers.
        what: name for error messages.
        columns: required second dimension of a 2-D array; None asks for a 1-D array.

    Raises:
        InputError: not numbers, wrong shape, or not finite (naming the first bad row).
    """
    array = real_array(value, f"{what}: expected an array of numbers")
    _check_shape(array, what, columns)
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        raise InputError(f"{what}: value at {tuple(int(i) for i in bad[0])} is {array[tuple(bad[0])]}, not finite")
    return frozen(array)


def int_array(value: Any, what: str, columns: int | None = None) -> IntArray:
    """Own, C-contiguous, write-protected int32 copy of ``value``; whole numbers only.

    Raises:
        InputError: not whole numbers, too large for 32 bits, negative, or wrong shape.
    """
    try:
        array = np.array(value, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what}: expected an array of whole numbers ({error})") from None
    if array.size == 0:
        array = array.reshape((0, columns) if columns is not None else (0,)).astype(np.int32)
    if array.dtype.kind not in "iu":
        raise InputError(f"{what}: expected whole numbers (indices from 0), got values of type {array.dtype}")
    _check_shape(array, what, columns)
    if array.size and (array.min() < 0 or array.max() > np.iinfo(np.int32).max):
        worst = array.min() if array.min() < 0 else array.max()
        raise InputError(f"{what}: index {int(worst)} out of range; indices start at 0")
    return frozen(array.astype(np.int32))


def place_mm(point: Any) -> str:
    """A place or vector (3,) in m as text, mm."""
    x, y, z = (1e3 * float(value) + 0.0 for value in point)
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


def _check_shape(array: NDArray[Any], what: str, columns: int | None) -> None:
    if columns is None and array.ndim != 1:
        raise InputError(f"{what}: expected a one-dimensional array, got shape {array.shape}")
    if columns is not None and (array.ndim != 2 or array.shape[1] != columns):
        raise InputError(f"{what}: expected shape (n, {columns}), got {array.shape}")
