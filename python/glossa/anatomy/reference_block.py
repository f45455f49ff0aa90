"""Index arithmetic of the built-in tongue: one structured block of 16 x 6 x 8 cells, each divided into r x r x r.

Node and cell numbers and their neighbours are arithmetic; nothing is searched. Indices here are *fine*: multiples of
1/r of the anatomical indices ray i (0..16), layer j (0..6), column k (-4..4).
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.landmarks import COLUMNS, LAYERS, RAYS, Landmarks
from glossa.errors import InputError

Index = tuple[int, int, int]


@dataclass(frozen=True)
class Block:
    """The structured block at one resolution.

    Attributes:
        resolution: r >= 1.
    """

    resolution: int

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "resolution", operator.index(self.resolution))
        except TypeError:
            raise InputError(f"resolution must be a whole number, got {self.resolution!r}") from None
        if self.resolution < 1:
            raise InputError(f"resolution must be at least 1, got {self.resolution}")

    @property
    def n_nodes(self) -> int:
        """Nodes of the block, outside points not counted."""
        r = self.resolution
        return (RAYS * r + 1) * (LAYERS * r + 1) * (2 * COLUMNS * r + 1)

    def span(self, first: float, last: float) -> range:
        """Fine indices from ``first`` to ``last`` (anatomical units), both included, upwards or downwards."""
        start, end = round(first * self.resolution), round(last * self.resolution)
        return range(start, end + 1) if start <= end else range(start, end - 1, -1)

    def node(self, i: Any, j: Any, k: Any) -> Any:
        """Node number at fine indices; arrays broadcast."""
        r = self.resolution
        return (i * (LAYERS * r + 1) + j) * (2 * COLUMNS * r + 1) + (k + COLUMNS * r)

    def node_grid(self, i: range, j: range, k: range) -> IntArray:
        """Node numbers of all combinations, i slowest, flattened."""
        numbers = self.node(np.array(i)[:, None, None], np.array(j)[:, None], np.array(k))
        return np.asarray(numbers, dtype=np.int32).ravel()

    def path(self, *corners: Index) -> list[int]:
        """Node numbers along grid lines and diagonals through ``corners`` (fine indices).

        On each leg every index that changes at all changes by the same number of steps.
        """
        nodes = [int(self.node(*corners[0]))]
        for start, end in pairwise(corners):
            change = [b - a for a, b in zip(start, end, strict=True)]
            steps = max(abs(c) for c in change)
            if any(abs(c) not in (0, steps) for c in change):
                raise InputError(f"no grid line or diagonal from {start} to {end}")
            nodes.extend(
                int(self.node(*(a + c * step // steps for a, c in zip(start, change, strict=True))))
                for step in range(1, steps + 1)
            )
        return nodes

    def nodes(self, landmarks: Landmarks) -> FloatArray:
        """(n, 3) m. The side y < 0 is the exact mirror image of y > 0; the midline has y = 0."""
        r = self.resolution
        i, j, k = (np.arange(count * r + 1) / r for count in (RAYS, LAYERS, COLUMNS))
        half = landmarks.positions(i, j, k)
        mirrored = half[:, :, :0:-1] * np.array([1.0, -1.0, 1.0])
        return np.ascontiguousarray(np.concatenate([mirrored, half], axis=2).reshape(-1, 3))

    def hexahedra(self) -> IntArray:
        """(m, 8) VTK order, cell (i, j, k) at position (i * 6r + j) * 8r + (k + 4r); local axes i, k, j."""
        r = self.resolution
        i, j, k = (
            axis.ravel()
            for axis in np.meshgrid(
                np.arange(RAYS * r), np.arange(LAYERS * r), np.arange(-COLUMNS * r, COLUMNS * r), indexing="ij"
            )
        )
        corners: list[NDArray[Any]] = []
        for dj in (0, 1):
            corners += [self.node(i + di, j + dj, k + dk) for di, dk in ((0, 0), (1, 0), (1, 1), (0, 1))]
        return np.stack(corners, axis=1).astype(np.int32)
