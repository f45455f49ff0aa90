"""Which elements a macrofibre passes: the basis of eq. 4 (force shares) and eq. 1 (stiffening).

Equations and Table I: Buchaillard, Perrier & Payan 2009.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.muscle import Muscle
from glossa.errors import InputError

_INSIDE, _ON_FACE, _ON_EDGE = 1.0, 0.5, 0.25


@dataclass(frozen=True, eq=False)
class PassTable:
    """Every (fibre, element) pair with p2(f, e) = 1, sorted by fibre, then element.

    Attributes:
        fibres: (k,) fibre indices.
        elements: (k,) hexahedron indices.
        fractions: (k,) p(e, f) of eq. 4.
    """

    fibres: IntArray
    elements: IntArray
    fractions: FloatArray


def pass_table(hexahedra: IntArray, muscle: Muscle) -> PassTable:
    """Muscle elements that contain both nodes of at least one segment of a fibre: p2(f, e) = 1 of eq. 1.

    The fraction p(e, f) of eq. 4 is 1 where the segment lies inside the muscle's element set, 0.5 on its boundary
    surface and 0.25 on an edge that one muscle element only touches. A segment that is a face diagonal is inside when
    two muscle elements share that face. Over several segments in one element the mean is taken.
    """
    segments = muscle.segments
    n_nodes = int(max(hexahedra.max(initial=0), segments[:, :2].max())) + 1
    keys, local, fractions = _pairs_of_elements(hexahedra[muscle.elements], n_nodes)
    order = np.argsort(keys, kind="stable")
    keys, local, fractions = keys[order], local[order], fractions[order]
    wanted = hexa.pair_keys(segments[:, :2], n_nodes)
    first, last = np.searchsorted(keys, wanted, "left"), np.searchsorted(keys, wanted, "right")
    counts = last - first
    hits = np.repeat(first - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts) + np.arange(counts.sum())
    fibre = np.repeat(segments[:, 2], counts).astype(np.int64)
    element = muscle.elements[local[hits]].astype(np.int64)
    n_elements = len(hexahedra)
    pair, inverse, number = np.unique(fibre * n_elements + element, return_inverse=True, return_counts=True)
    mean = np.bincount(inverse, weights=fractions[hits], minlength=len(pair)) / number
    return PassTable((pair // n_elements).astype(np.int32), (pair % n_elements).astype(np.int32), mean)


def _pairs_of_elements(elements: IntArray, n_nodes: int) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """All node pairs of the muscle's elements: edges, face diagonals, body diagonals.

    Returns the pair key, the element's position in the muscle's list and the fraction p, each (28 k,).
    """
    m = len(elements)
    faces, face_keys = hexa.face_keys(elements, n_nodes)
    shared = (np.bincount(face_keys.ravel(), minlength=1)[face_keys] > 1) if m else np.zeros((0, 6), dtype=bool)
    outer = faces[~shared]
    outer_edges = hexa.pair_keys(np.stack([outer, np.roll(outer, -1, axis=1)], axis=2).reshape(-1, 2), n_nodes)
    edge_keys = hexa.pair_keys(elements[:, hexa.EDGES], n_nodes)
    _, inverse, count = np.unique(edge_keys.ravel(), return_inverse=True, return_counts=True)
    alone = (count[inverse] == 1).reshape(m, 12)
    on_boundary = np.isin(edge_keys, outer_edges)
    edge_fractions = np.where(alone, _ON_EDGE, np.where(on_boundary, _ON_FACE, _INSIDE))
    face_fractions = np.repeat(np.where(shared, _INSIDE, _ON_FACE), 2, axis=1)
    keys = np.concatenate(
        [
            edge_keys,
            hexa.pair_keys(elements[:, hexa.FACE_DIAGONALS], n_nodes),
            hexa.pair_keys(elements[:, hexa.BODY_DIAGONALS], n_nodes),
        ],
        axis=1,
    )
    fractions = np.concatenate([edge_fractions, face_fractions, np.full((m, 4), _INSIDE)], axis=1)
    return keys.ravel(), np.repeat(np.arange(m), keys.shape[1]), fractions.ravel()


def fibre_passes(hexahedra: IntArray, muscle: Muscle) -> list[list[tuple[int, float]]]:
    """Per fibre the list of (element, fraction p(e, f)) of the muscle elements it passes; see :func:`pass_table`."""
    table = pass_table(hexahedra, muscle)
    result: list[list[tuple[int, float]]] = [[] for _ in muscle.fibres]
    for fibre, element, fraction in zip(
        table.fibres.tolist(), table.elements.tolist(), table.fractions.tolist(), strict=True
    ):
        result[fibre].append((element, fraction))
    return result


def capacity_shares(nodes: FloatArray, hexahedra: IntArray, muscle: Muscle) -> FloatArray:
    """(n_fibres,) shares of the muscle's force capacity, eq. 4; they sum to 1.

    The weight of a fibre is the sum of V(e) p(e, f) over the muscle elements it passes. A fibre that passes none
    gets the smallest weight of those that do, so that it still carries force; if none passes any, all shares are
    equal.
    """
    table = pass_table(hexahedra, muscle)
    volumes = hexa.volumes(nodes, hexahedra[muscle.elements])
    volume_of = dict(zip(muscle.elements.tolist(), volumes.tolist(), strict=True))
    passed = np.array([volume_of[e] for e in table.elements.tolist()], dtype=float)
    weights = np.bincount(table.fibres, weights=passed * table.fractions, minlength=len(muscle.fibres))
    touching = weights > 0.0
    weights = np.where(touching, weights, weights[touching].min() if touching.any() else 1.0)
    shares: FloatArray = weights / weights.sum()
    return shares


def largest_fibre_count(hexahedra: IntArray, muscle: Muscle) -> int:
    """Largest number of fibres that pass one element of the muscle; 0 when none passes any."""
    table = pass_table(hexahedra, muscle)
    return int(np.bincount(table.elements, minlength=1).max()) if len(table.elements) else 0


def stiffening_gain(
    hexahedra: IntArray, muscle: Muscle, saturation_activation: float, peak_multiplier: float | None = None
) -> float:
    """p1(m) of eq. 1, 1/m: an element passed by n saturated fibres gets ``peak_multiplier`` times its passive c_i0.

    The paper gives no p1. The rule here is p1 = (peak_multiplier - 1) / (n * saturation_activation), with n the
    muscle's ``fibres_per_element`` or, when that is None, the largest number of its fibres that pass one element.

    Args:
        hexahedra: (m, 8) of the speaker.
        muscle: the muscle.
        saturation_activation: activation A at which eq. 3 saturates, m (ln 2 / c).
        peak_multiplier: stiffness at saturation over passive stiffness; None: the muscle's own.
    """
    if not saturation_activation > 0.0:
        raise InputError(f"saturation_activation must be positive, got {saturation_activation!r}")
    peak = muscle.peak_multiplier if peak_multiplier is None else peak_multiplier
    if not peak >= 1.0:
        raise InputError(f"peak_multiplier must be at least 1, got {peak!r}")
    count = muscle.fibres_per_element or max(1, largest_fibre_count(hexahedra, muscle))
    return (peak - 1.0) / (count * saturation_activation)
