"""Prescribed displacements and loads of node sets, as arrays over all nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.speaker import Speaker
from glossa.checks import real_array
from glossa.errors import InputError


def _nodes(speaker: Speaker, name: Any, what: str) -> IntArray:
    if name not in speaker.node_sets:
        known = ", ".join(speaker.node_sets) or "none"
        raise InputError(f"{what}: no node set {name!r}; this speaker has {known}")
    return speaker.node_sets[name]


def _vectors(value: Any, what: str) -> tuple[FloatArray, BoolArray]:
    """Numbers with 0 for None, and where a number was given."""
    try:
        entries = np.array(value, dtype=object)
        given: BoolArray = np.asarray(np.frompyfunc(lambda x: x is not None, 1, 1)(entries), dtype=bool)
        numbers = real_array(np.where(given, entries, 0.0).tolist(), f"{what}: expected numbers")
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: expected numbers (or None for a free component), got {value!r}") from None
    if not np.isfinite(numbers).all():
        raise InputError(f"{what}: every component must be finite (None leaves one free)")
    return numbers, given


WALL = "wall:"
"""What a key of ``prescribed`` begins with that names a wall."""


def wall_displacements(speaker: Speaker, prescribed: Any) -> tuple[dict[str, FloatArray], dict[str, Any]]:
    """The displacements of walls (3,) in m among what is prescribed, and the rest of it.

    Raises:
        InputError: not a mapping, an unknown wall, or not three finite numbers.
    """
    if not isinstance(prescribed, Mapping):
        raise InputError(f"prescribed must map node sets to displacements, got {type(prescribed).__name__}")
    walls: dict[str, FloatArray] = {}
    others: dict[str, Any] = {}
    for key, value in prescribed.items():
        if not (isinstance(key, str) and key.startswith(WALL)):
            others[key] = value
            continue
        name = key.removeprefix(WALL)
        if name not in speaker.walls:
            raise InputError(f"prescribed: no wall {name!r}; this speaker has {', '.join(speaker.walls) or 'none'}")
        numbers, given = _vectors(value, f"prescribed displacement of wall {name!r}")
        if numbers.shape != (3,) or not given.all():
            raise InputError(f"prescribed displacement of wall {name!r}: expected three numbers in m, got {value!r}")
        walls[name] = numbers
    return walls, others


def prescribed_positions(speaker: Speaker, prescribed: Mapping[str, Any]) -> tuple[BoolArray, FloatArray]:
    """Which components are prescribed (n, 3), and their positions (n, 3) in m.

    Raises:
        InputError: unknown set, wrong shape, not finite, or two sets that disagree about a node.
    """
    held = np.zeros(speaker.nodes.shape, dtype=bool)
    target = np.array(speaker.nodes)
    for name, value in prescribed.items():
        nodes = _nodes(speaker, name, "prescribed")
        numbers, given = _vectors(value, f"prescribed displacement of {name!r}")
        if numbers.shape not in ((3,), (len(nodes), 3)):
            raise InputError(
                f"prescribed displacement of {name!r}: expected shape (3,) or ({len(nodes)}, 3), got {numbers.shape}"
            )
        numbers, given = np.broadcast_to(numbers, (len(nodes), 3)), np.broadcast_to(given, (len(nodes), 3))
        wanted = speaker.nodes[nodes] + numbers
        clash = held[nodes] & given & (target[nodes] != wanted)
        if clash.any():
            node = int(nodes[np.argmax(clash.any(axis=1))])
            raise InputError(f"prescribed displacement of {name!r}: node {node} is already prescribed otherwise")
        target[nodes] = np.where(given, wanted, target[nodes])
        held[nodes] |= given
    return held, target


def nodal_loads(speaker: Speaker, loads: Mapping[str, Any]) -> FloatArray | None:
    """(n, 3) nodal forces in N of total forces on node sets; None without loads.

    Raises:
        InputError: unknown set, or not three finite numbers.
    """
    if not isinstance(loads, Mapping):
        raise InputError(f"loads must map node sets to forces, got {type(loads).__name__}")
    if not loads:
        return None
    result = np.zeros(speaker.nodes.shape)
    for name, value in loads.items():
        nodes = _nodes(speaker, name, "loads")
        force = real_array(value, f"load on {name!r}: expected three numbers in N")
        if force.shape != (3,) or not np.isfinite(force).all():
            raise InputError(f"load on {name!r}: expected three finite numbers in N, got {value!r}")
        result += traction_weights(speaker, nodes)[:, None] * force
    return result


def traction_weights(speaker: Speaker, nodes: IntArray) -> FloatArray:
    """(n,) shares, summing to 1, of a uniform dead traction on the boundary faces that lie wholly in a set of nodes.

    Consistent with bilinear faces (2 x 2 Gauss rule). Without such a face every node has an equal share.
    """
    weights = np.zeros(len(speaker.nodes))
    quads = speaker.surface_quads[np.isin(speaker.surface_quads, nodes).all(axis=1)]
    if len(quads) == 0:
        weights[nodes] = 1.0 / len(nodes)
        return weights
    corners = speaker.nodes[quads]
    g = 1.0 / np.sqrt(3.0)
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for r, s in signs * g:
        shape = (1 + signs[:, 0] * r) * (1 + signs[:, 1] * s) / 4.0
        along_r = np.einsum("a,qai->qi", signs[:, 0] * (1 + signs[:, 1] * s) / 4.0, corners)
        along_s = np.einsum("a,qai->qi", signs[:, 1] * (1 + signs[:, 0] * r) / 4.0, corners)
        area = np.linalg.norm(np.cross(along_r, along_s), axis=1)
        np.add.at(weights, quads, area[:, None] * shape)
    return np.asarray(weights / weights.sum())
