"""Rayleigh damping against the critical one (fig. 4)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from glossa.effects import Damping
from glossa.errors import InputError

FREQUENCIES = np.geomspace(0.5, 50.0, 201)
"""Hz."""


def damping_ratio(damping: Damping = Damping(), frequencies: ArrayLike = FREQUENCIES) -> xr.Dataset:
    """Damping of a mode over its critical damping, alpha / (2 omega) + beta omega / 2.

    Args:
        damping: of a scene.
        frequencies: modal ones, Hz.

    Returns:
        ``ratio (frequency)``; 1 is critical. Attributes ``alpha_per_s`` and ``beta_s``.

    Raises:
        InputError: frequencies that are not positive.
    """
    values = np.asarray(frequencies, dtype=float)
    if values.ndim != 1 or not len(values) or not np.isfinite(values).all() or (values <= 0.0).any():
        raise InputError("frequencies must be a list of positive numbers in Hz")
    omega = 2.0 * np.pi * values
    ratio = damping.alpha / (2.0 * omega) + damping.beta * omega / 2.0
    return xr.Dataset(
        {"ratio": (("frequency",), ratio, {"units": "1"})},
        coords={"frequency": ("frequency", values, {"units": "Hz"})},
        attrs={"study": "damping_ratio", "alpha_per_s": damping.alpha, "beta_s": damping.beta},
    )
