"""Bodies of simple shape for the verification tests: blocks of hexahedra with named faces, and Cook's membrane."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa import Hyoid, Muscle, Posture, Speaker, Spring, Wall, Yeoh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

CELLS = (6, 4, 4)
SIZE = (0.06, 0.04, 0.04)
"""Cells and edges (m) of the cantilever P1 of the shared solver references."""

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def lattice(cells: Sequence[int]) -> tuple[FloatArray, IntArray, NDArray[np.int64]]:
    """Nodes in the unit cube (n, 3), hexahedra (m, 8) and node numbers by lattice point (nx + 1, ny + 1, nz + 1)."""
    nx, ny, nz = cells
    grid = np.meshgrid(*(np.linspace(0.0, 1.0, n + 1) for n in cells), indexing="ij")
    nodes = np.stack([axis.ravel() for axis in grid], axis=1)
    number = np.arange(len(nodes)).reshape(nx + 1, ny + 1, nz + 1)
    corner = [number[a : nx + a, b : ny + b, c : nz + c].ravel() for a, b, c in _CORNERS]
    return nodes, np.stack(corner, axis=1).astype(np.int32), number


def face_sets(number: NDArray[np.int64], *, sides: bool = True) -> dict[str, IntArray]:
    """The six faces, the whole boundary, all nodes and the eight corners of a lattice; without ``sides`` those that
    are their own mirror images about a middle plane y = 0."""
    faces = {
        "left": number[0],
        "right": number[-1],
        "front": number[:, 0],
        "back": number[:, -1],
        "bottom": number[:, :, 0],
        "top": number[:, :, -1],
    }
    ends = np.ix_(*((0, n - 1) for n in number.shape))
    sets = {name: np.sort(face.ravel()) for name, face in faces.items()}
    sets["boundary"] = np.unique(np.concatenate(list(sets.values())))
    sets["all"] = number.ravel()
    sets["corners"] = np.sort(number[ends].ravel())
    if not sides:
        del sets["front"], sets["back"]
    return {name: nodes.astype(np.int32) for name, nodes in sets.items()}


def block(
    cells: Sequence[int] = CELLS,
    size: Sequence[float] = SIZE,
    *,
    muscles: Mapping[str, float] | None = None,
    distortion: float = 0.0,
    centred: bool = False,
    sets: Mapping[str, Any] | None = None,
    name: str = "block",
) -> Speaker:
    """A block from the origin (``centred``: mirror symmetric about y = 0, with symmetric node sets only).

    Args:
        cells: along x, y, z.
        size: edges, m.
        muscles: force capacity in N by name. Fibres run along x, one for every grid line: all lines for a muscle
            called "axial", those with z above or below the middle for "upper" and "lower", the others of "side" at
            y below the middle only. A muscle's elements are those that touch its fibres with an edge.
        distortion: inner nodes move at random by up to this share of a cell.
        sets: node sets beside those of :func:`face_sets`.
        name: of the speaker.
    """
    nodes, hexahedra, number = lattice(cells)
    if distortion:
        inner = np.setdiff1d(number, face_sets(number)["boundary"])
        shift = np.random.default_rng(1).uniform(-distortion, distortion, (len(inner), 3))
        nodes[inner] += shift / np.asarray(cells)
    nodes = (nodes - np.array([0.0, 0.5 if centred else 0.0, 0.0])) * np.asarray(size)
    found = {muscle: _muscle(muscle, capacity, hexahedra, number) for muscle, capacity in (muscles or {}).items()}
    named = {**face_sets(number, sides=not centred), **(sets or {})}
    return Speaker(nodes, hexahedra, muscles=found, node_sets=named, name=name)


def _muscle(name: str, capacity: float, hexahedra: IntArray, number: NDArray[np.int64]) -> Muscle:
    _, ny, nz = number.shape
    lines = {
        "axial": [(j, k) for j in range(ny) for k in range(nz)],
        "upper": [(j, k) for j in range(ny) for k in range(nz) if 2 * k > nz - 1],
        "lower": [(j, k) for j in range(ny) for k in range(nz) if 2 * k < nz - 1],
        "side": [(j, k) for j in range(ny) for k in range(nz) if 2 * j < ny - 1],
    }[name]
    fibres = [number[:, j, k] for j, k in lines]
    # Edges of a cell along x in the VTK order of its corners.
    edges = hexahedra[:, [[0, 1], [3, 2], [4, 5], [7, 6]]]
    inside = np.isin(edges, np.concatenate(fibres))
    touched = np.any(np.all(inside, axis=2), axis=1)
    return Muscle(np.flatnonzero(touched), fibres, capacity)


def furnished(speaker: Speaker, *, walls: Mapping[str, Wall] | None = None, hyoid: Hyoid | None = None) -> Speaker:
    """The same body with other walls and another hyoid."""
    return Speaker(
        speaker.nodes,
        speaker.hexahedra,
        muscles=dict(speaker.muscles),
        node_sets=dict(speaker.node_sets),
        walls=walls or {},
        hyoid=hyoid,
        name=speaker.name,
    )


def sheet(
    height: Callable[[FloatArray, FloatArray], FloatArray | float],
    low: Sequence[float],
    high: Sequence[float],
    cells: Sequence[int] = (1, 1),
    *,
    facing: int = 1,
) -> Wall:
    """The open wall z = height(x, y) over the rectangle from ``low`` to ``high`` (x, y in m), in quadrilaterals.

    ``facing``: 1 for a floor, which is touched from above; -1 for a ceiling.
    """
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, cells, strict=True)]
    x, y = np.meshgrid(*axes, indexing="ij")
    z = np.broadcast_to(np.asarray(height(x, y), dtype=float), x.shape)
    number = np.arange(x.size).reshape(x.shape)
    turn = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]][::facing]
    faces = np.stack([corner.ravel() for corner in turn], axis=1)
    return Wall(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces)


def masses(speaker: Speaker, density: float) -> FloatArray:
    """(n,) kg: an eighth of each hexahedron at each of its corners, exact in sum and centre for cuboids."""
    result = np.zeros(len(speaker.nodes))
    np.add.at(result, speaker.hexahedra, (density * speaker.element_volumes / 8.0)[:, None])
    return result


def wall_force(posture: Posture, wall: str | None = None) -> FloatArray:
    """(3,) N, force of a wall, or of all, on the body."""
    assert posture.contact is not None
    forces = posture.contact.forces
    chosen = forces.sum() if wall is None else forces.loc[wall]
    return np.asarray(chosen.to_numpy(), dtype=np.float64)


def plate(height: float, low: Sequence[float], high: Sequence[float], *, facing: int) -> Wall:
    """A horizontal rectangle (see :func:`sheet`)."""
    return sheet(lambda x, _: np.full_like(x, height), low, high, facing=facing)


def hyoid_block(
    stiffness: float = 220.0,
    *,
    mass: float = 0.002,
    muscles: Mapping[str, float] | None = None,
    between_walls: bool = False,
) -> Speaker:
    """A block, symmetric about y = 0, whose face x = 0 hangs on a hyoid with six springs (N/m) on each side.

    ``between_walls``: with curved walls "roof" and "floor" 0.3 mm from it.
    """
    body = block((4, 4, 2), (0.04, 0.02, 0.02), centred=True, muscles=muscles)
    centre = np.array([0.0, 0.0, 0.01])
    directions = (
        (0.0, 1.0, 0.3),
        (-1.0, 0.5, 0.0),
        (0.0, 0.3, -1.0),
        (0.2, 0.4, 1.0),
        (-0.5, 0.6, -0.6),
        (0.7, 0.7, 0.1),
    )
    springs = []
    for side in (1.0, -1.0):
        for i, (x, y, z) in enumerate(directions):
            start = centre + np.array([0.002 * (i - 2), side * (0.004 + 0.001 * i), 0.001 * (i % 3 - 1)])
            along = np.array([x, side * y, z]) / np.linalg.norm((x, y, z))
            springs.append(Spring(start, start + 0.03 * along, stiffness))
    walls = {}
    if between_walls:
        low, high = (-0.012, -0.022), (0.052, 0.022)
        walls["roof"] = sheet(lambda x, y: 0.0203 + 3.0 * (x - 0.01) ** 2 + 6.0 * y**2, low, high, (40, 40), facing=-1)
        walls["floor"] = sheet(lambda _, y: -0.0003 - 2.0 * y**2, low, high, (1, 40))
    return Speaker(
        body.nodes,
        body.hexahedra,
        muscles=dict(body.muscles),
        node_sets={**body.node_sets, "hyoid": body.node_sets["left"]},
        walls=walls,
        hyoid=Hyoid(None, mass, centre, tuple(springs)),
        name="block on a hyoid",
    )


def cook_membrane(n: int) -> Speaker:
    """Cook's membrane of n x n elements, one metre thick in one layer (problem P3; lengths in m)."""
    nodes, hexahedra, number = lattice((n, n, 1))
    r, s, t = nodes.T
    y = (1 - r) * 44.0 * s + r * (44.0 + 16.0 * s)
    return Speaker(np.stack([48.0 * r, y, t], axis=1), hexahedra, node_sets=face_sets(number), name="Cook")


def nearest(speaker: Speaker, point: Sequence[float]) -> int:
    """The node at a point, which has to be one."""
    distance = np.linalg.norm(speaker.nodes - np.asarray(point), axis=1)
    node = int(distance.argmin())
    assert distance[node] < 1e-9 * max(1.0, float(np.abs(speaker.nodes).max()))
    return node


def yeoh(c10: float, c20: float, bulk_modulus: float) -> Yeoh:
    """Yeoh material of a given bulk modulus (Pa): nu = (3 kappa - 2 mu) / (6 kappa + 2 mu), mu = 2 c10."""
    mu = 2.0 * c10
    return Yeoh(c10, c20, poissons_ratio=(3.0 * bulk_modulus - 2.0 * mu) / (6.0 * bulk_modulus + 2.0 * mu))


PASSIVE = yeoh(1037.0, 486.0, 1.037e6)
"""Material of the shared solver references."""
