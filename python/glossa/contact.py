"""What touches what, how hard: contact results of postures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.errors import InputError

_AXES = ["x", "y", "z"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """Contact of the tongue's smooth surface with rigid walls; k pairs of a surface point and a wall it may touch.

    Attributes:
        walls: names.
        wall: (k,) which wall.
        points: (k, 3) m.
        areas: (k,) m2 of the surface at rest that the point stands for.
        gaps: (k,) m, distance from the wall, overlap at rest left out; negative where the point has entered it. Known
            up to 6 mm, more reads as that.
        pressures: (k,) Pa, never negative.
        directions: (k, 3) gradient of the distance: the way out of the wall, of about unit length.
        drags: (k, 3) Pa, friction of the tongue on the wall.
        held: (h,) nodes of the speaker that never move: on bone, where nothing touches.
        spacing: of neighbouring points, m.
    """

    walls: tuple[str, ...]
    wall: IntArray
    points: FloatArray
    areas: FloatArray
    gaps: FloatArray
    pressures: FloatArray
    directions: FloatArray
    drags: FloatArray
    held: IntArray
    spacing: float

    @property
    def touching(self) -> BoolArray:
        """(k,) points under pressure."""
        return np.asarray(self.pressures > 0.0)

    @cached_property
    def tractions(self) -> FloatArray:
        """(k, 3) Pa: force of the wall on the tongue per area, pressure and friction."""
        return np.asarray(self.pressures[:, None] * self.directions - self.drags)

    def at_wall(self, name: str) -> BoolArray:
        """(k,) points that belong to a wall.

        Raises:
            InputError: no such wall.
        """
        if name not in self.walls:
            raise InputError(f"no wall {name!r}; this speaker has {', '.join(self.walls)}")
        return np.asarray(self.wall == self.walls.index(name))

    @property
    def forces(self) -> pd.DataFrame:
        """Force of each wall on the tongue, N; columns x, y, z."""
        pulls = self.tractions * self.areas[:, None]
        sums = [pulls[self.wall == number].sum(axis=0) for number in range(len(self.walls))]
        return pd.DataFrame(np.reshape(sums, (-1, 3)), index=list(self.walls), columns=_AXES)

    @property
    def touched_areas(self) -> pd.Series[float]:
        """Area of the tongue at rest that touches each wall, m2."""
        sums = [self.areas[self.touching & (self.wall == number)].sum() for number in range(len(self.walls))]
        return pd.Series(sums, index=list(self.walls), name="area_m2", dtype=float)

    @property
    def penetration(self) -> float:
        """Deepest penetration of any point, m; for the surface between them see :mod:`glossa.surface_penetration`."""
        return float(max(0.0, -self.gaps.min(initial=0.0)))

    def __repr__(self) -> str:
        touched = ", ".join(f"{name} {area * 1e4:.2f} cm2" for name, area in self.touched_areas.items() if area > 0.0)
        return f"Contact({touched or 'nothing touches'})"
