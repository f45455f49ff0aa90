"""The transfer function of an area function on the real frequency axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glossa.acoustics.area_function import AreaFunction
from glossa.acoustics.constants import TubeConstants, tube_constants
from glossa.acoustics.transmission_line import flow_ratio
from glossa.errors import InputError

STILL = 1e-3
"""Hz at which a frequency of 0 is evaluated, where the coefficients are not defined."""


def transfer_function(
    area: AreaFunction, frequency: ArrayLike, *, constants: str | TubeConstants = "badin"
) -> NDArray[np.complex128]:
    """Volume flow through the lips over that at the closed glottis, e^{jωt}.

    Args:
        area: sections.
        frequency: Hz, any shape.
        constants: a named set or your own.

    Raises:
        InputError: a frequency that is negative or not finite.
    """
    chosen = tube_constants(constants)
    try:
        hertz = np.asarray(frequency, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"frequency must be real numbers in Hz: {error}") from error
    if not np.isfinite(hertz).all() or (hertz < 0.0).any():
        raise InputError("frequency must be finite and not negative, in Hz")
    omega = np.asarray(2.0 * np.pi * np.maximum(hertz.reshape(1, -1), STILL), dtype=np.complex128)
    ratio = flow_ratio(omega, area.lengths[None, :], area.areas[None, :], chosen)
    return (1.0 / ratio).reshape(hertz.shape)
