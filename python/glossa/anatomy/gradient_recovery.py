"""Where a mesh is too coarse for a nodal field: the distance of its gradient from a continuous one.

Mean gradients of the hexahedra around a node, weighted by volume, have one more order of accuracy than the gradient
itself; the trilinear field through them stands for the exact one (Zienkiewicz & Zhu 1987, Int. J. Numer. Methods Eng.
24:337). Kinks that belong to the solution, along fibres for example, count as errors.
"""

from __future__ import annotations

import numpy as np

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray


def gradient_errors(nodes: FloatArray, field: FloatArray, hexahedra: IntArray) -> FloatArray:
    """(m,) estimated error of the gradient of a nodal field: root mean square of its norm over each hexahedron.

    Args:
        nodes: (n, 3) m.
        field: (n, 3), trilinear in each hexahedron.
        hexahedra: (m, 8).
    """
    gradients = hexa.gauss_gradients(nodes, field, hexahedra)
    volumes = hexa.gauss_determinants(nodes, hexahedra)
    sizes = volumes.sum(axis=1)
    means = np.einsum("mpab,mp->mab", gradients, volumes)  # times the volume
    total, around = np.zeros((len(nodes), 3, 3)), np.zeros(len(nodes))
    for corner in hexahedra.T:
        np.add.at(total, corner, means)
        np.add.at(around, corner, sizes)
    smooth = total / np.where(around > 0.0, around, 1.0)[:, None, None]
    missing = np.einsum("pi,miab->mpab", hexa.GAUSS_WEIGHTS, smooth[hexahedra]) - gradients
    return np.asarray(np.sqrt(np.einsum("mpab,mpab,mp->m", missing, missing, volumes) / sizes))
