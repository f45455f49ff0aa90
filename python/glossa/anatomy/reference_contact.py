"""Which boundary faces of the built-in tongue may touch which wall, as index ranges of its block.

Every patch is written in anatomical indices: ray i (0..16), layer j (0..6), column k (-4..4); one index stands still,
at an end of its range. Patches of different walls overlap. The larynx is named nowhere: nothing touches it.
"""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import IntArray
from glossa.anatomy.landmarks import COLUMNS, LAYERS, RAYS
from glossa.anatomy.reference_block import Block

Range = tuple[int, int]
Patch = tuple[Range, Range, Range]

_ACROSS = (-COLUMNS, COLUMNS)
_TOP = (LAYERS, LAYERS)
_TIP_FACE: Patch = ((0, 0), (0, LAYERS), _ACROSS)


def _sides(i: Range, j: Range) -> list[Patch]:
    return [(i, j, (side, side)) for side in (-COLUMNS, COLUMNS)]


#: by wall: tip, dorsum or root, borders; mandible: tip, underside, sides, lateral parts of the mouth floor
CONTACT_PATCHES: dict[str, list[Patch]] = {
    "hard_palate": [_TIP_FACE, ((0, 11), _TOP, _ACROSS), *_sides((0, 11), (4, 6))],
    "soft_palate": [((4, 13), _TOP, _ACROSS), *_sides((5, 12), (4, 6))],
    "pharynx": [((8, 15), _TOP, _ACROSS), *_sides((9, 12), (5, 6))],
    "mandible": [
        _TIP_FACE,
        ((0, 4), (0, 0), _ACROSS),
        *_sides((0, 11), (0, 6)),
        *_sides((11, 16), (0, 5)),
        ((RAYS, RAYS), (0, 5), (-4, -3)),
        ((RAYS, RAYS), (0, 5), (3, 4)),
    ],
}


def reference_contact_faces(b: Block, node_sets: dict[str, IntArray]) -> dict[str, IntArray]:
    """By wall, (k, 4) nodes of the faces that may touch it, without those that jaw or hyoid hold at all corners."""
    held = [np.isin(np.arange(b.n_nodes), node_sets[name]) for name in ("jaw", "hyoid")]
    result = {}
    for wall, patches in CONTACT_PATCHES.items():
        faces = np.concatenate([_faces(b, patch) for patch in patches])
        free = ~np.any([nodes[faces].all(axis=1) for nodes in held], axis=0)
        result[wall] = faces[free]
    return result


def _faces(b: Block, patch: Patch) -> IntArray:
    """(k, 4) nodes of the faces of one patch."""
    spans = [b.span(first, last) for first, last in patch]
    rows, columns = (len(span) for span in spans if len(span) > 1)
    grid = b.node_grid(*spans).reshape(rows, columns)
    corners = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.stack(corners, axis=2).reshape(-1, 4)
