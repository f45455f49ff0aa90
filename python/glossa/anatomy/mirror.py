"""Mirror symmetry about the midsagittal plane y = 0: node pairing and the half body y >= 0.

In the half body a fibre that lies in the midplane has half its force (the rest belongs to the other side). A fibre that
crosses the midplane and is its own mirror image keeps its tension; its whole length is twice that of its half.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError

_REFLECTION = np.array([1.0, -1.0, 1.0])
TOLERANCE = 1e-9  # m; far above rounding, far below any element


def mirror_pairs(nodes: FloatArray, tolerance: float = TOLERANCE) -> IntArray:
    """(n,) index of the mirror image of each node (n, 3); nodes of the midplane are their own.

    Raises:
        InputError: naming the first node without a mirror image within ``tolerance`` (m, per coordinate).
    """
    if not len(nodes):
        return np.zeros(0, dtype=np.int32)
    distance, nearest = cKDTree(nodes).query(nodes * _REFLECTION, p=np.inf)
    lonely = np.flatnonzero(distance > tolerance)
    if len(lonely):
        place = ", ".join(f"{c:.6g}" for c in nodes[lonely[0]])
        raise InputError(f"node {lonely[0]} at ({place}) m has no mirror image about y = 0 within {tolerance:g} m")
    partner: IntArray = nearest.astype(np.int32)
    doubled = np.flatnonzero(partner[partner] != np.arange(len(nodes)))
    if len(doubled):
        raise InputError(f"node {doubled[0]} has more than one mirror image about y = 0; merge coincident nodes")
    return partner


@dataclass(frozen=True, eq=False, kw_only=True)
class HalfFibre:
    """A fibre of the half body.

    Attributes:
        muscle: name of its muscle.
        index: its position among the fibres of that muscle in the whole speaker.
        nodes: node path in half numbering.
        length_factor: whole length over the length of ``nodes``: 2 for a fibre that crosses the midplane, else 1.
        force_share: part of its force that acts on this half: 0.5 for a fibre in the midplane, else 1.
    """

    muscle: str
    index: int
    nodes: IntArray
    length_factor: float
    force_share: float


@dataclass(frozen=True, eq=False, kw_only=True)
class HalfBody:
    """The half y >= 0 of a mirror-symmetric speaker; k nodes, h hexahedra.

    Attributes:
        kept_nodes: (k,) original node indices, ascending; outside points included.
        nodes: (k, 3) m.
        hexahedra: (h, 8) in half numbering.
        kept_elements: (h,) original element indices, ascending.
        midplane: (k,) True for nodes of the midplane.
        fibres: kept fibres, muscle by muscle.
        node_index: (n,) half node of every original node.
        reflected: (n,) True where the original node lies at y < 0.
        element_index: (m,) half element of every original element.
        fibre_index: muscle -> (n_fibres,) position in ``fibres`` for every original fibre.
    """

    kept_nodes: IntArray
    nodes: FloatArray
    hexahedra: IntArray
    kept_elements: IntArray
    midplane: BoolArray
    fibres: tuple[HalfFibre, ...]
    node_index: IntArray
    reflected: BoolArray
    element_index: IntArray
    fibre_index: Mapping[str, IntArray]

    def expand(self, values: FloatArray) -> FloatArray:
        """(n, 3) positions or vectors of the whole body from those of the half (k, 3); y changes sign by reflection."""
        whole = np.asarray(values, dtype=float)[self.node_index]
        whole[self.reflected, 1] *= -1.0
        return whole


def half_body(speaker: Speaker) -> HalfBody:
    """The half y >= 0 of a mirror-symmetric speaker.

    Raises:
        InputError: the speaker is not mirror symmetric; the message names the node, element or fibre.
    """
    partner = mirror_pairs(speaker.nodes)
    y = speaker.nodes[:, 1]
    kept = np.flatnonzero((y >= -TOLERANCE) & ((y > TOLERANCE) | (partner == np.arange(len(y))))).astype(np.int32)
    half_number = np.full(len(y), -1, dtype=np.int32)
    half_number[kept] = np.arange(len(kept))
    reflected = half_number < 0
    node_index = np.where(reflected, half_number[partner], half_number).astype(np.int32)
    element_partner = _element_pairs(speaker.hexahedra, partner)
    kept_elements, element_index = _kept_elements(speaker.hexahedra, reflected, element_partner, partner)
    _check_muscles(speaker, element_partner)
    fibres: list[HalfFibre] = []
    fibre_index = {
        name: _half_fibres(name, muscle, partner, half_number, fibres) for name, muscle in speaker.muscles.items()
    }
    return HalfBody(
        kept_nodes=kept,
        nodes=speaker.nodes[kept],
        hexahedra=half_number[speaker.hexahedra[kept_elements]],
        kept_elements=kept_elements,
        midplane=partner[kept] == kept,
        fibres=tuple(fibres),
        node_index=node_index,
        reflected=reflected,
        element_index=element_index,
        fibre_index=fibre_index,
    )


def _element_pairs(hexahedra: IntArray, partner: IntArray) -> IntArray:
    """(m,) mirror image of every element."""
    corners, images = np.sort(hexahedra, axis=1), np.sort(partner[hexahedra], axis=1)
    rows, inverse = np.unique(np.concatenate([corners, images]), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    owner = np.full(len(rows), -1, dtype=np.int32)
    owner[inverse[: len(hexahedra)]] = np.arange(len(hexahedra))
    result: IntArray = owner[inverse[len(hexahedra) :]]
    missing = np.flatnonzero(result < 0)
    if len(missing):
        raise InputError(f"hexahedron {missing[0]} has no mirror image about y = 0; the mirror model needs symmetry")
    return result


def _kept_elements(
    hexahedra: IntArray, reflected: BoolArray, element_partner: IntArray, partner: IntArray
) -> tuple[IntArray, IntArray]:
    """Elements of the half y >= 0, and the half element of every original one."""
    left = reflected[hexahedra].any(axis=1)
    right = (~reflected & (partner != np.arange(len(partner))))[hexahedra].any(axis=1)
    crossing = np.flatnonzero(left & right)
    if len(crossing):
        raise InputError(f"hexahedron {crossing[0]} crosses the midplane y = 0; the mirror model needs nodes on it")
    kept = np.flatnonzero(~left).astype(np.int32)
    number = np.full(len(hexahedra), -1, dtype=np.int32)
    number[kept] = np.arange(len(kept))
    return kept, np.where(number >= 0, number, number[element_partner]).astype(np.int32)


def _check_muscles(speaker: Speaker, element_partner: IntArray) -> None:
    for name, muscle in speaker.muscles.items():
        missing = np.setdiff1d(element_partner[muscle.elements], muscle.elements)
        if len(missing):
            raise InputError(f"muscle {name!r} is not symmetric: it lacks element {missing[0]}, a mirror image")


def _half_fibres(
    name: str, muscle: Muscle, partner: IntArray, half_number: IntArray, fibres: list[HalfFibre]
) -> IntArray:
    """Append the kept fibres of one muscle to ``fibres``; return the position of every original fibre's half."""
    places: dict[tuple[int, ...], list[int]] = {}
    for index, fibre in enumerate(muscle.fibres):
        places.setdefault(_undirected(fibre), []).append(index)
    result = np.full(len(muscle.fibres), -1, dtype=np.int32)
    images = np.empty(len(muscle.fibres), dtype=np.int32)
    for index, fibre in enumerate(muscle.fibres):
        twins, mirrored = places[_undirected(fibre)], places.get(_undirected(partner[fibre]), [])
        if len(twins) != len(mirrored):
            raise InputError(f"muscle {name!r}, fibre {index} has no mirror image about y = 0")
        images[index] = mirrored[twins.index(index)]
        half = _half_of(name, index, fibre, partner, half_number)
        if half is not None:
            result[index] = len(fibres)
            fibres.append(half)
    return np.where(result >= 0, result, result[images]).astype(np.int32)


def _half_of(name: str, index: int, fibre: IntArray, partner: IntArray, half_number: IntArray) -> HalfFibre | None:
    """The part of a fibre at y >= 0; None for a fibre that lies at y <= 0."""
    in_plane, right = partner[fibre] == fibre, half_number[fibre] >= 0
    factor, share = 1.0, 1.0
    if in_plane.all():
        share = 0.5
    elif not right.all():
        if not (right & ~in_plane).any():
            return None
        middle, odd = divmod(len(fibre), 2)
        if not np.array_equal(partner[fibre], fibre[::-1]):
            raise InputError(f"muscle {name!r}, fibre {index} crosses the midplane and is not its own mirror image")
        if not odd:
            raise InputError(f"muscle {name!r}, fibre {index} crosses the midplane y = 0 between two nodes")
        halves = fibre[: middle + 1], fibre[middle:]
        fibre = halves[0] if (half_number[halves[0]] >= 0).all() else halves[1]
        if (half_number[fibre] < 0).any():
            raise InputError(f"muscle {name!r}, fibre {index} crosses the midplane y = 0 more than once")
        factor = 2.0
    return HalfFibre(muscle=name, index=index, nodes=half_number[fibre], length_factor=factor, force_share=share)


def _undirected(fibre: IntArray) -> tuple[int, ...]:
    forward = tuple(fibre.tolist())
    return min(forward, forward[::-1])
