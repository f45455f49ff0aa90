"""How closely an equilibrium is solved: its tolerances, and the named ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from glossa.checks import one_of, positive_number


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """When an equilibrium counts as found.

    Attributes:
        residual: over force scale.
        gap: deepest penetration of a wall at any contact point, m.
    """

    residual: float
    gap: float

    def __post_init__(self) -> None:
        positive_number(self.residual, "residual")
        positive_number(self.gap, "gap (m)")


ACCURACIES: Mapping[str, Tolerances] = MappingProxyType(
    {
        "draft": Tolerances(residual=1e-5, gap=5e-5),
        "standard": Tolerances(residual=1e-8, gap=5e-5),
        "reference": Tolerances(residual=1e-11, gap=2e-5),
    }
)
"""What the names of an accuracy stand for.

Largest error at any node of the built-in speaker's /i/ and /u/ against the limit of hard contact, and mean time on one
thread (``glossa accuracy --show``): draft and standard 0.11 mm, 0.14 to 0.19 s; reference 0.09 mm
(/i/), 0.27 to 0.36 s."""


def tolerances(accuracy: str | Tolerances) -> Tolerances:
    """Those of a name, or the ones given.

    Raises:
        InputError: an unknown name.
    """
    return accuracy if isinstance(accuracy, Tolerances) else ACCURACIES[one_of(accuracy, tuple(ACCURACIES), "accuracy")]
