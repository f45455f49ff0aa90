"""The muscles of the built-in tongue as families of grid lines of its block.

Every family is written in anatomical indices: ray i (0..16), layer j (0..6), column k (-4..4). At resolution r a fibre
stands at every 1/r, so that a muscle stays a bundle that fills the same volume. Families are generated for k >= 0 and
mirrored; midline fibres stand once. Steps that change two indices run along face diagonals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import IntArray
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.reference_block import Block, Index

#: fibres through an interior cell of any family at any resolution; sets p1 of eq. 1
FIBRES_PER_ELEMENT = 4
#: layer at which a vertical fibre ends below, for the rays 1..13
_VERTICALIS_FLOOR = (1, 1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4)

Corners = list[Index]
Family = Callable[[Block], Iterator[Corners]]


def _genioglossus(first_ray: int, last_ray: int, columns: int) -> Family:
    """Rays from the symphysis to one layer below the dorsum, within ``columns`` of the midline."""

    def family(b: Block) -> Iterator[Corners]:
        for i in b.span(first_ray, last_ray):
            for k in b.span(0, columns):
                yield [(i, 0, k), (i, 5 * b.resolution, k)]

    return family


def _styloglossus_tip(b: Block) -> Iterator[Corners]:
    """From the styloid into the side at ray 9, inwards to columns 3..4, forward in the lower edge to the tip."""
    r = b.resolution
    for e in b.span(0, 1):
        for k in b.span(3, 4):
            corners = [(9 * r, 4 * r + e, 4 * r), (9 * r, 4 * r + e, k), (7 * r, 2 * r + e, k)]
            yield [*corners, (4 * r, 2 * r + e, k), (3 * r, r + e, k), (r, r + e, k)]


def _styloglossus_transverse(b: Block) -> Iterator[Corners]:
    """From the styloid into the side at rays 9..10 and across to the midline."""
    for i in b.span(9, 10):
        for j in b.span(3, 4):
            yield [(i, j, 4 * b.resolution), (i, j, 0)]


def _hyoglossus(b: Block) -> Iterator[Corners]:
    """From along the hyoid diagonally to ray 14, then upwards in layers 3..5, columns 2..4, to ray 8 (7 at layer 5)."""
    r = b.resolution
    for e in b.span(3, 5):
        spread = e - 3 * r
        start = (16 * r, 5 * r + spread) if spread <= r else (17 * r - spread, 6 * r)
        top = 8 * r - max(0, e - 4 * r)
        for k in b.span(2, 4):
            yield [(*start, k), (14 * r, e, k), (top, e, k)]


def _verticalis_floor(b: Block, i: int) -> int:
    """Fine layer index of the lower end of the vertical fibres on fine ray ``i``; linear between whole rays."""
    r = b.resolution
    ray, part = divmod(i, r)
    floor = _VERTICALIS_FLOOR[ray - 1]
    following = _VERTICALIS_FLOOR[min(ray, len(_VERTICALIS_FLOOR) - 1)]
    return floor * r + (following - floor) * part


def _verticalis(b: Block) -> Iterator[Corners]:
    """Rays 1..11, columns 1..3: from the dorsum down to the floor of the intrinsic layer."""
    for i in b.span(1, 11):
        for k in b.span(1, 3):
            yield [(i, 6 * b.resolution, k), (i, _verticalis_floor(b, i), k)]


def _transversus(b: Block) -> Iterator[Corners]:
    """Rays 1..13, from three layers under the floor of the verticalis to layer 5: from column 3 to the midline."""
    r = b.resolution
    for i in b.span(1, 13):
        for j in range(max(r, _verticalis_floor(b, i) - 3 * r), 5 * r + 1):
            yield [(i, j, 3 * r), (i, j, 0)]


def _inferior_longitudinal(b: Block) -> Iterator[Corners]:
    """Columns 2..3 along the underside from the tip to the hyoid."""
    r = b.resolution
    for e in b.span(0, 1):
        for k in b.span(2, 3):
            yield [
                (0, r + e, k), (3 * r, r + e, k), (4 * r, 2 * r + e, k), (8 * r, 2 * r + e, k), (9 * r, 3 * r + e, k),
                (13 * r, 3 * r + e, k), (15 * r - e, 5 * r, k), (16 * r - e, 6 * r, k),
            ]  # fmt: skip


def _superior_longitudinal(b: Block) -> Iterator[Corners]:
    """The outermost layer within three columns of the midline, from the tip to ray 13."""
    for j in b.span(5, 6):
        for k in b.span(0, 3):
            yield [(0, j, k), (13 * b.resolution, j, k)]


def _geniohyoid(b: Block) -> Iterator[Corners]:
    """A wedge from the lower end of the symphysis, rays 15..16, to layer 5 of ray 16 at the hyoid."""
    r = b.resolution
    for i in b.span(15, 16):
        for k in b.span(0, 1):
            yield [(i + ((16 * r - i) * 2 * j + 5 * r) // (10 * r), j, k) for j in range(5 * r + 1)]


def _mylohyoid(b: Block) -> Iterator[Corners]:
    """From the mylohyoid line on the side, steeply down and inwards, then across the floor to the midline."""
    r = b.resolution
    for e in b.span(0, 1):
        for j in b.span(1, 4):
            yield [(16 * r - j - e, j, 4 * r), (16 * r - e, j, 4 * r - j), (16 * r - e, j, 0)]


FAMILIES: dict[str, tuple[Family, ...]] = {
    "GGa": (_genioglossus(4, 6, 2),),
    "GGm": (_genioglossus(6, 9, 1),),
    "GGp": (_genioglossus(9, 14, 1),),
    "Sty": (_styloglossus_tip, _styloglossus_transverse),
    "HG": (_hyoglossus,),
    "Vert": (_verticalis,),
    "Trans": (_transversus,),
    "IL": (_inferior_longitudinal,),
    "SL": (_superior_longitudinal,),
    "GH": (_geniohyoid,),
    "MH": (_mylohyoid,),
}


def mylohyoid_line(b: Block) -> IntArray:
    """Nodes of the strip of the side that is attached to the jaw along the mylohyoid line; both sides."""
    r = b.resolution
    return np.array(
        sorted(
            int(b.node(i, j, side * 4 * r))
            for side in (-1, 1)
            for j in b.span(0, 4)
            for i in range(15 * r - j, 16 * r - j + 1)
        ),
        dtype=np.int32,
    )


def reference_muscles(
    b: Block, hexahedra: IntArray, capacities: dict[str, float], peak_multiplier: float
) -> dict[str, Muscle]:
    """The eleven muscles; ``capacities`` rho(m) in N, ``peak_multiplier`` of every one.

    Styloid points are nodes n (y < 0) and n + 1 (y > 0).
    """
    styloid = (b.n_nodes, b.n_nodes + 1)
    muscles = {}
    for name, families in FAMILIES.items():
        fibres = [fibre for family in families for fibre in _both_sides(b, family, styloid if name == "Sty" else None)]
        elements = _bundle(hexahedra, fibres, b.n_nodes + 2, sheet=name == "MH")
        muscles[name] = Muscle(elements, fibres, capacities[name], FIBRES_PER_ELEMENT, peak_multiplier)
    return muscles


def _both_sides(b: Block, family: Family, styloid: tuple[int, int] | None) -> Iterator[list[int]]:
    """Node lists of the side y < 0 and of y > 0; a fibre that lies in the midplane stands once."""
    for corners in family(b):
        for side in (-1, 1):
            if side < 0 and all(k == 0 for _, _, k in corners):
                continue
            path = b.path(*((i, j, side * k) for i, j, k in corners))
            yield path if styloid is None else [styloid[side > 0], *path]


def _bundle(hexahedra: IntArray, fibres: list[list[int]], n_nodes: int, *, sheet: bool) -> IntArray:
    """Cells inside a bundle: at least three fibres along their edges, or two that pass by a face diagonal.

    ``sheet``: the mylohyoid's rule, one diagonal or two edges, because its sheet turns within one cell.
    """
    segments = Muscle([0], fibres, 1.0).segments
    keys = hexa.pair_keys(segments[:, :2], n_nodes)
    on_edges = _fibres_on(hexahedra[:, hexa.EDGES], keys, segments[:, 2], n_nodes)
    on_diagonals = _fibres_on(hexahedra[:, hexa.FACE_DIAGONALS], keys, segments[:, 2], n_nodes)
    inside = (on_diagonals >= 1) | (on_edges >= 2) if sheet else (on_diagonals >= 2) | (on_edges >= 3)
    return np.flatnonzero(inside).astype(np.int32)


def _fibres_on(pairs: IntArray, keys: np.ndarray, fibre: IntArray, n_nodes: int) -> IntArray:
    """(m,) number of distinct fibres with a segment among the node pairs (m, p, 2) of each cell."""
    order = np.argsort(keys, kind="stable")
    sorted_keys = keys[order]
    wanted = hexa.pair_keys(pairs, n_nodes)
    cells = np.broadcast_to(np.arange(len(pairs))[:, None], wanted.shape).ravel()
    wanted = wanted.ravel()
    first, last = np.searchsorted(sorted_keys, wanted, "left"), np.searchsorted(sorted_keys, wanted, "right")
    found: list[np.ndarray] = []
    offset = 0
    while (hit := first + offset < last).any():
        found.append(cells[hit].astype(np.int64) * (int(fibre.max()) + 1) + fibre[order[first[hit] + offset]])
        offset += 1
    distinct = np.unique(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)
    return np.bincount(distinct // (int(fibre.max()) + 1), minlength=len(pairs)).astype(np.int32)
