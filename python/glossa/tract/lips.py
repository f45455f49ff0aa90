"""The lips: one cylinder in front of the incisors, as the biomechanical model has none (section II.E, Table IV)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from glossa import paper
from glossa.checks import positive_number
from glossa.errors import InputError

LONGEST = 0.05
"""m; longer lips were meant in other units."""
WIDEST = 3e-3
"""m²; a wider opening was meant in other units."""


@dataclass(frozen=True)
class Lips:
    """Protrusion and aperture.

    Attributes:
        length: m.
        area: m².

    Raises:
        InputError: not positive, not finite, or as if given in other units.
    """

    length: float
    area: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", positive_number(self.length, "lip length (m)"))
        object.__setattr__(self, "area", positive_number(self.area, "lip area (m²)"))
        if self.length > LONGEST:
            raise InputError(f"lip length must be in m (0.008, not 0.8 cm or 8 mm), got {self.length:g}")
        if self.area > WIDEST:
            raise InputError(f"lip area must be in m² (1.5e-4, not 1.5 cm² or 150 mm²), got {self.area:g}")


def _of_the_paper() -> Mapping[str, Lips]:
    rows = paper.rows("table4_formants_simulated.csv")
    return MappingProxyType(
        {row["vowel"]: Lips(float(row["lip_protrusion_cm"]) * 1e-2, float(row["lip_area_cm2"]) * 1e-4) for row in rows}
    )


LIPS = _of_the_paper()
"""Lips of the vowels, by name as in ``VOWELS``: Table IV, based on Abry et al. (1980)."""


def as_lips(value: Any) -> Lips:
    """Lips from a vowel's name, a pair (length in m, area in m²), or Lips.

    Raises:
        InputError: None, an unknown vowel, or bad numbers.
    """
    if value is None:
        raise InputError(
            "lips are missing: the model has none of its own; give the name of a vowel of Table IV "
            f"({', '.join(LIPS)}), a pair (length in m, area in m²), or glossa.Lips"
        )
    if isinstance(value, Lips):
        return value
    if isinstance(value, str):
        if value not in LIPS:
            raise InputError(
                f"no lips known for {value!r}; Table IV has {', '.join(LIPS)}, or give (length m, area m²)"
            )
        return LIPS[value]
    try:
        length, area = value
    except (TypeError, ValueError):
        raise InputError(
            f"lips must be the name of a vowel, a pair (length in m, area in m²) or glossa.Lips, got {value!r}"
        ) from None
    return Lips(length, area)
