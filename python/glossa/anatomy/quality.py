"""Quality report of a speaker: shape and size of its elements, and the room between tongue and walls at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glossa.anatomy.clearance import Clearance, clearances
from glossa.anatomy.hexahedra import EDGES
from glossa.anatomy.speaker import Speaker

LEAST_JACOBIAN = 0.1
"""Scaled Jacobian under which an element of a generated or adapted speaker is refused."""

GOOD_JACOBIAN, POOR_JACOBIAN = 0.3, 0.2
"""Scaled Jacobians under which elements are counted; the built-in speaker keeps the first."""

NOTED_OVERLAP = 1e-3
"""Of tongue and wall at rest, m: more is told of."""


@dataclass(frozen=True, kw_only=True)
class Quality:
    """Numbers that tell how sound a speaker is.

    Attributes:
        elements: hexahedra.
        jacobian_min, jacobian_low, jacobian_median: scaled Jacobian of the elements: smallest, 5 % quantile, median.
        below_good, below_poor: elements with a scaled Jacobian under 0.3 and under 0.2.
        element_volumes: smallest and largest, m3.
        edge_lengths: shortest and longest, m.
        volume: of the body, m3.
        clearance: by wall, smallest distance from the tongue at rest, m; negative where they overlap. Walls that the
            tongue may not touch, or does not face, are left out.
    """

    elements: int
    jacobian_min: float
    jacobian_low: float
    jacobian_median: float
    below_good: int
    below_poor: int
    element_volumes: tuple[float, float]
    edge_lengths: tuple[float, float]
    volume: float
    clearance: Mapping[str, float]

    @property
    def notes(self) -> tuple[str, ...]:
        """What falls short, a sentence each; empty where nothing does."""
        found = []
        if self.jacobian_min < GOOD_JACOBIAN:
            found.append(
                f"smallest scaled Jacobian {self.jacobian_min:.3f}, {self.below_good} of {self.elements} elements "
                f"below {GOOD_JACOBIAN}"
            )
        found += [
            f"the tongue at rest overlaps wall {name} by {-distance * 1e3:.2f} mm"
            for name, distance in self.clearance.items()
            if distance < -NOTED_OVERLAP
        ]
        return tuple(found)

    def text(self) -> str:
        """The report in a few lines."""
        least, largest = (volume * 1e9 for volume in self.element_volumes)
        short, long = (length * 1e3 for length in self.edge_lengths)
        lines = [
            f"scaled Jacobian: smallest {self.jacobian_min:.3f}, 5 % {self.jacobian_low:.2f}, median "
            f"{self.jacobian_median:.2f}; {self.below_good} of {self.elements} elements below {GOOD_JACOBIAN}, "
            f"{self.below_poor} below {POOR_JACOBIAN}",
            f"elements {least:.2g}..{largest:.3g} mm3, edges {short:.2f}..{long:.1f} mm, body {self.volume * 1e6:.1f} "
            f"cm3",
        ]
        if self.clearance:
            walls = ", ".join(f"{name} {distance * 1e3:.2f}" for name, distance in self.clearance.items())
            lines.append(f"smallest distance of the tongue at rest, mm: {walls}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


def quality_of(speaker: Speaker, clear: Mapping[str, Clearance] | None = None) -> Quality:
    """The report on a speaker.

    Args:
        speaker: of any origin.
        clear: its clearances, where they are known already.
    """
    jacobians, volumes = speaker.scaled_jacobians, speaker.element_volumes
    ends = speaker.nodes[speaker.hexahedra[:, EDGES]]
    lengths = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    low, median = np.quantile(jacobians, [0.05, 0.5])
    return Quality(
        elements=len(jacobians),
        jacobian_min=float(jacobians.min()),
        jacobian_low=float(low),
        jacobian_median=float(median),
        below_good=int((jacobians < GOOD_JACOBIAN).sum()),
        below_poor=int((jacobians < POOR_JACOBIAN).sum()),
        element_volumes=(float(volumes.min()), float(volumes.max())),
        edge_lengths=(float(lengths.min()), float(lengths.max())),
        volume=speaker.volume,
        clearance={name: wall.least for name, wall in (clearances(speaker) if clear is None else clear).items()},
    )
