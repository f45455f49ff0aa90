"""Speakers the anatomy tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Muscle, Speaker


def block_parts(nx: int, ny: int, nz: int) -> tuple[np.ndarray, np.ndarray, Callable[..., int]]:
    """Nodes (cm steps, y centred), hexahedra and the node number of a lattice point of a block of cubes."""
    x, y, z = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1) - ny / 2, np.arange(nz + 1), indexing="ij")
    nodes = 0.01 * np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)

    def node(i: int, j: int, k: int) -> int:
        return (i * (ny + 1) + j) * (nz + 1) + k

    bottom = ((0, 0), (1, 0), (1, 1), (0, 1))
    hexahedra = [
        [node(i + a, j + b, k + c) for c in (0, 1) for a, b in bottom]
        for i in range(nx)
        for j in range(ny)
        for k in range(nz)
    ]
    return nodes, np.array(hexahedra), node


@pytest.fixture
def make_block() -> Callable[..., Any]:
    return block_parts


@pytest.fixture
def block() -> Speaker:
    """2 x 2 x 2 cubes with one muscle whose nine fibres run along every x line."""
    nodes, hexahedra, node = block_parts(2, 2, 2)
    fibres = [[node(i, j, k) for i in range(3)] for j in range(3) for k in range(3)]
    sets = {"left": [node(0, j, k) for j in range(3) for k in range(3)], "line": [node(0, 1, k) for k in range(3)]}
    return Speaker(
        nodes,
        hexahedra,
        muscles={"bundle": Muscle(range(8), fibres, 10.0)},
        node_sets=sets,
        contours={"top": [node(i, 1, 2) for i in range(3)]},
        name="block",
    )
