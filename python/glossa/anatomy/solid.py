"""Volume and centre of what a closed surface encloses."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.walls import Wall


def solid(surface: Wall) -> tuple[float, FloatArray]:
    """Volume (m3) and centre of mass (3,) m of what a closed surface with normals outwards encloses, uniformly filled.

    Exact for the facets: the sum over the tetrahedra between the facets and the origin.
    """
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    volumes = (a * np.cross(b, c)).sum(axis=1) / 6.0
    volume = float(volumes.sum())
    centre: FloatArray = (volumes[:, None] * (a + b + c)).sum(axis=0) / (4.0 * volume)
    return volume, centre
