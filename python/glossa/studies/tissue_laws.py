"""The tissue pulled in one direction, sides free: the laws of fig. 3."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from glossa.anatomy.muscle import PEAK_MULTIPLIER
from glossa.checks import positive_number
from glossa.effects import Yeoh
from glossa.errors import InputError

LAWS: Mapping[str, tuple[Yeoh, float]] = MappingProxyType(
    {
        "fresh cadaver": (Yeoh(192.0, 90.0), 1.0),
        "passive": (Yeoh(), 1.0),
        "activated, 2 ×": (Yeoh(), 2.0),
        "activated, 5 ×": (Yeoh(), 5.0),
        "maximal activation": (Yeoh(), PEAK_MULTIPLIER),
    }
)
"""The three of fig. 3, and two between: tissue, and the factor of eq. 1 that stiffens it."""

STRAINS = np.linspace(-0.4, 0.8, 61)
"""Of the curves; the paper's figure has no numbers in the text."""

_SMALL = 1e-4  # strain at which Young's modulus is taken, on both sides


def stress_strain(laws: Mapping[str, tuple[Yeoh, float]] = LAWS, strains: ArrayLike = STRAINS) -> xr.Dataset:
    """Uniaxial stress of tissues, each by a factor of eq. 1 stiffer than at rest.

    Args:
        laws: tissue and factor, at least 1, by name.
        strains: elongation over length at rest, above -1.

    Returns:
        Over ``law``: ``nominal_stress (…, strain)``, force over area at rest, and ``stress (…, strain)``, over the area
        of the moment, Pa; ``volume_ratio (…, strain)``; ``modulus``, of Young, at rest, Pa; ``multiplier``.

    Raises:
        InputError: no law, a factor below 1, or impossible strains.
    """
    values = np.asarray(strains, dtype=float)
    if values.ndim != 1 or not len(values) or not np.isfinite(values).all() or (values <= -1.0).any():
        raise InputError("strains must be a list of numbers above -1")
    if not laws:
        raise InputError("stress and strain need at least one law")
    rows = [_curve(name, tissue, multiplier, values) for name, (tissue, multiplier) in laws.items()]
    pascal = {"units": "Pa"}
    return xr.Dataset(
        {
            "nominal_stress": (("law", "strain"), np.stack([row["nominal"] for row in rows]), pascal),
            "stress": (("law", "strain"), np.stack([row["true"] for row in rows]), pascal),
            "volume_ratio": (("law", "strain"), np.stack([row["volume"] for row in rows]), {"units": "1"}),
            "modulus": (("law",), np.array([row["modulus"] for row in rows]), pascal),
            "multiplier": (("law",), np.array([multiplier for _, multiplier in laws.values()]), {"units": "1"}),
        },
        coords={"law": list(laws), "strain": ("strain", values, {"units": "1"})},
        attrs={"study": "stress_strain"},
    )


def _curve(name: str, tissue: Yeoh, multiplier: float, strains: np.ndarray[Any, Any]) -> dict[str, Any]:
    factor = positive_number(multiplier, f"factor of {name!r}")
    if factor < 1.0:
        raise InputError(f"factor of {name!r} must be at least 1, got {factor!r}")
    found = np.array([_pulled(tissue, factor, 1.0 + strain) for strain in strains.tolist()])
    around = [_pulled(tissue, factor, 1.0 + strain)[0] for strain in (-_SMALL, _SMALL)]
    nominal, side = found.T
    return {
        "nominal": nominal,
        "true": nominal / side**2,
        "volume": (1.0 + strains) * side**2,
        "modulus": (around[1] - around[0]) / (2.0 * _SMALL),
    }


def _pulled(tissue: Yeoh, factor: float, stretch: float) -> tuple[float, float]:
    """Nominal stress (Pa) and stretch across, where nothing presses on the sides."""
    bulk = tissue.bulk_modulus

    def stresses(side: float) -> tuple[float, float]:
        """First Piola-Kirchhoff stress along and across."""
        volume, squares = stretch * side**2, stretch**2 + 2.0 * side**2
        scale = math.pow(volume, -2.0 / 3.0)
        slope = factor * (tissue.c10 + 2.0 * tissue.c20 * (scale * squares - 3.0))
        pressure = bulk * (volume - 1.0) * volume

        def along(own: float) -> float:
            return 2.0 * slope * scale * (own - squares / (3.0 * own)) + pressure / own

        return along(stretch), along(side)

    isochoric = stretch**-0.5
    side = float(brentq(lambda t: stresses(t)[1], 0.5 * isochoric, 2.0 * isochoric, xtol=1e-15, rtol=1e-14))
    return stresses(side)[0], side
