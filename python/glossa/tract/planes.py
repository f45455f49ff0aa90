"""Cutting planes: orthogonal to the midsagittal plane and perpendicular to the midline at rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from glossa.anatomy.arrays import FloatArray, frozen
from glossa.anatomy.swept_surface import chord_lengths


@dataclass(frozen=True, eq=False)
class CuttingPlanes:
    """k planes, glottis first.

    In a plane, a point has the coordinates (y, t): y lateral as in space, t along ``outwards``, from the midline
    towards palate and rear wall.

    Attributes:
        origins: (k, 2) x and z of the midline in each plane, m.
        normals: (k, 2) x and z of the unit normals, from glottis to lips.
        outwards: (k, 2) x and z of the unit vectors along t.
    """

    origins: FloatArray
    normals: FloatArray
    outwards: FloatArray

    def __len__(self) -> int:
        return len(self.origins)

    def to_space(self, number: int, points: FloatArray) -> FloatArray:
        """(…, 3) m: points (…, 2) of plane ``number``, coordinates (y, t), in space."""
        sagittal = self.origins[number] + points[..., 1:] * self.outwards[number]
        return np.stack([sagittal[..., 0], points[..., 0], sagittal[..., 1]], axis=-1)


def planes_along(midline: FloatArray, count: int) -> CuttingPlanes:
    """``count`` planes at equal distances along a midline (k, 2), one at either end."""
    along = chord_lengths(midline)
    at = np.linspace(0.0, along[-1], count)
    tangent = np.gradient(midline, along, axis=0)
    origins, normals = (np.stack([np.interp(at, along, v[:, a]) for a in range(2)], axis=1) for v in (midline, tangent))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    # From glottis to lips the midline runs up and then forwards: rear wall and palate lie on its right.
    outwards = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    return CuttingPlanes(frozen(origins), frozen(normals), frozen(outwards))
