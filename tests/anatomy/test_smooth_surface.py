"""The smooth surface: interpolation, linearity, locality, smoothness, and what it refuses."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Speaker
from glossa.anatomy.hexahedra import matching_faces
from glossa.anatomy.mirror import mirror_pairs
from glossa.anatomy.smooth_surface import SmoothSurface
from glossa.anatomy.surface_patch import face_coordinates
from glossa.anatomy.surface_sampling import surface_lattice
from glossa.errors import InputError

Points = tuple[np.ndarray, np.ndarray, np.ndarray]


def grid(surface: SmoothSurface, m: int, faces: np.ndarray | None = None) -> Points:
    """Centres of an m x m division of every face, face by face."""
    chosen = np.arange(len(surface.quads)) if faces is None else faces
    t = (np.arange(m) + 0.5) / m
    u, v = (np.tile(part.ravel(), len(chosen)) for part in np.meshgrid(t, t, indexing="ij"))
    return np.repeat(chosen, m * m), u, v


def along_edges(surface: SmoothSurface, t: np.ndarray) -> Points:
    """The points ``t`` of every half-edge."""
    faces = np.repeat(np.arange(len(surface.quads)), 4 * len(t))
    pairs = [face_coordinates(corner, t, np.zeros_like(t)) for corner in range(4)]
    u, v = (np.tile(np.concatenate([pair[axis] for pair in pairs]), len(surface.quads)) for axis in range(2))
    return faces, u, v


def normals(surface: SmoothSurface, points: Points, positions: np.ndarray) -> np.ndarray:
    by_u, by_v = surface.derivatives(*points)
    areas = np.cross(by_u @ positions, by_v @ positions)
    return np.asarray(areas / np.linalg.norm(areas, axis=1)[:, None])


def bent(nodes: np.ndarray) -> np.ndarray:
    """A large smooth deformation without symmetry."""
    x, y, z = ((nodes - nodes.mean(axis=0)) / np.ptp(nodes, axis=0).max()).T
    moves = np.stack([0.3 * z * z + 0.2 * x * y, 0.2 * np.sin(3 * x) + 0.1 * z * y, 0.4 * x * x - 0.3 * y * z], axis=1)
    return np.asarray(nodes + moves * np.ptp(nodes, axis=0).max())


def ball(n: int, ratio: float = 1.0) -> SmoothSurface:
    """Unit sphere of 6 n^2 faces; the angles of neighbouring edges are as 1 to ``ratio``."""
    ends = np.concatenate([[0.0], np.cumsum(np.where(np.arange(n) % 2 == 0, 1.0, ratio))])
    t = np.tan((2.0 * ends / ends[-1] - 1.0) * np.pi / 4)
    number: dict[tuple[float, ...], int] = {}
    quads = []
    for axis, sign in product(range(3), (-1.0, 1.0)):
        for i, j in product(range(n), range(n)):
            corners = []
            for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                place = np.roll([sign, t[a], t[b]], axis)
                corners.append(number.setdefault(tuple(np.round(place, 9)), len(number)))
            quads.append(corners if sign > 0 else corners[::-1])
    nodes = np.array(list(number))
    return SmoothSurface(nodes / np.linalg.norm(nodes, axis=1)[:, None], quads)


@pytest.fixture(params=["block", "ball", "reference", "pb"])
def surface(request: pytest.FixtureRequest, make_block: Callable[..., Any]) -> SmoothSurface:
    if request.param == "block":
        return Speaker(*make_block(2, 3, 1)[:2]).smooth_surface
    if request.param == "ball":
        return ball(3)
    speaker: Speaker = request.getfixturevalue(request.param)
    return speaker.smooth_surface


def test_passes_through_the_nodes(surface: SmoothSurface) -> None:
    faces = np.arange(len(surface.quads))
    for corner, (u, v) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        weights = surface.operator(faces, np.full(len(faces), float(u)), np.full(len(faces), float(v)))
        assert weights.nnz == len(faces)
        assert np.array_equal(weights.indices, surface.quads[:, corner])
        assert (weights.data == 1.0).all()


def test_follows_affine_maps(surface: SmoothSurface) -> None:
    points = grid(surface, 3)
    weights = surface.operator(*points)
    assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-14
    assert max(np.abs(by.sum(axis=1)).max() for by in surface.derivatives(*points)) < 2e-14
    matrix, shift = np.array([[0.3, 0.9, -0.2], [-1.1, 0.4, 0.5], [0.1, 0.2, 1.3]]), np.array([0.2, -0.1, 0.3])
    moved = surface.nodes @ matrix.T + shift
    expected = (weights @ surface.nodes) @ matrix.T + shift
    assert np.abs(surface.points(*points, moved) - expected).max() < 1e-14


def test_depends_on_the_faces_around_its_corners_only(surface: SmoothSurface) -> None:
    weights = surface.operator(*grid(surface, 2))
    around = [set(surface.quads[(surface.quads == node).any(axis=1)].ravel()) for node in range(len(surface.nodes))]
    for row, face in enumerate(grid(surface, 2)[0]):
        allowed = set.union(*(around[node] for node in surface.quads[face]))
        assert set(weights.indices[weights.indptr[row] : weights.indptr[row + 1]]) <= allowed


def test_neighbours_meet(surface: SmoothSurface) -> None:
    t = np.linspace(0.1, 0.9, 5)
    for positions in (surface.nodes, bent(surface.nodes)):
        points = surface.points(*along_edges(surface, t), positions).reshape(-1, 5, 3)
        assert np.abs(points - points[surface.mesh.twin][:, ::-1]).max() < 1e-15 * np.abs(positions).max()


def normal_jumps(surface: SmoothSurface, t: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """(4 q, len(t)) sine of the angle between the normals on both sides of every half-edge."""
    here, there = (normals(surface, along_edges(surface, s), positions).reshape(-1, len(t), 3) for s in (t, 1 - t))
    result: np.ndarray = np.linalg.norm(np.cross(here, there[surface.mesh.twin]), axis=2)
    return result


def off_creases(surface: SmoothSurface) -> np.ndarray:
    """(4 q,) half-edges of which neither end lies on a crease."""
    mesh = surface.mesh
    return ~(np.isin(mesh.start, surface.creases) | np.isin(mesh.end, surface.creases))


def smooth_edges(surface: SmoothSurface) -> np.ndarray:
    """(4 q,) half-edges that are no creases."""
    creases = {tuple(pair) for pair in surface.creases.tolist()}
    pairs = np.sort(np.stack([surface.mesh.start, surface.mesh.end], axis=1), axis=1)
    return np.array([tuple(pair) not in creases for pair in pairs.tolist()])


def test_one_tangent_plane_at_nodes_off_creases(surface: SmoothSurface) -> None:
    smooth = off_creases(surface)
    assert smooth.sum() >= 2
    # The slopes at a node are its tangents: two neighbouring faces share one, and the others lie in its plane.
    assert normal_jumps(surface, np.array([0.0, 1.0]), bent(surface.nodes))[smooth].max() < 4e-12


@pytest.mark.parametrize("name", ["ball", "reference"])
def test_one_tangent_plane_along_edges_off_creases(name: str, request: pytest.FixtureRequest) -> None:
    surface = ball(4) if name == "ball" else request.getfixturevalue(name).smooth_surface
    t = np.array([0.05, 0.3, 0.5, 0.8])
    smooth = smooth_edges(surface)
    assert smooth.sum() > 380
    for positions in (surface.nodes, bent(surface.nodes)):
        corners = positions[surface.quads]
        flat = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        flat = np.repeat(flat / np.linalg.norm(flat, axis=1)[:, None], 4, axis=0)
        assert np.linalg.norm(np.cross(flat, flat[surface.mesh.twin]), axis=1)[smooth].max() > 0.3
        assert normal_jumps(surface, t, positions)[smooth].max() < 1e-11


def test_few_edges_of_pb_show_a_jump(pb: Speaker) -> None:
    jumps = np.degrees(np.arcsin(np.minimum(normal_jumps(pb.smooth_surface, np.linspace(0.1, 0.9, 5), pb.nodes), 1.0)))
    jumps = jumps[smooth_edges(pb.smooth_surface)]
    assert np.percentile(jumps, 90) < 1e-6
    assert np.percentile(jumps, 95) < 5.0
    assert jumps.max() > 1.0


def test_flat_parts_stay_flat(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, _ = make_block(3, 3, 3)
    stretched = nodes * [1.0, 3.0, 0.5] + 0.003 * np.stack([np.sin(80 * nodes[:, 0]), nodes[:, 0], 0 * nodes[:, 0]], 1)
    for rest in (nodes, stretched):
        speaker = Speaker(rest, hexahedra)
        surface = speaker.smooth_surface
        assert len(surface.creases) == 36
        top = np.flatnonzero((rest[surface.quads, 2] == rest[:, 2].max()).all(axis=1))
        assert len(top) == 9
        moved = bent(rest)
        moved[np.unique(surface.quads[top]), 2] = 0.1
        points = surface.points(*grid(surface, 4, top), moved)
        assert np.abs(points[:, 2] - 0.1).max() < 1e-16
        assert np.ptp(surface.points(*grid(surface, 4), moved)[:, 2]) > 0.02


def test_regular_faces_keep_their_parameters(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, node = make_block(3, 3, 1)
    surface = Speaker(nodes @ np.array([[1, 0.2, 0], [0.4, 1, 0], [0, 0, 1]]), hexahedra).smooth_surface
    middle = [node(i, j, 1) for i in (1, 2) for j in (1, 2)]
    (face,) = np.flatnonzero(np.isin(surface.quads, middle).all(axis=1))
    points = grid(surface, 4, np.array([face]))
    a, b, c, d = surface.nodes[surface.quads[face]]
    u, v = points[1][:, None], points[2][:, None]
    bilinear = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
    assert np.abs(surface.points(*points, surface.nodes) - bilinear).max() < 1e-16


def test_no_folds_between_unequal_edges(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, _ = make_block(4, 4, 1)
    steps = np.array([0.0, 0.001, 0.021, 0.022, 0.042])
    x, y = steps[np.rint(nodes[:, 0] * 100).astype(int)], steps[np.rint(nodes[:, 1] * 100 + 2).astype(int)]
    rest = np.stack([x, y, nodes[:, 2] + 0.002 * np.sin(90 * x) * np.cos(70 * y)], axis=1)
    surface = Speaker(rest, hexahedra).smooth_surface
    top = np.flatnonzero((rest[surface.quads, 2] > 0.005).all(axis=1))
    assert len(top) == 16
    n = normals(surface, grid(surface, 8, top), rest)
    assert n[:, 2].min() > 0.95
    steepest = 1.0 / np.hypot(1.0, 0.002 * 90)
    assert n[:, 2].min() < steepest + 0.05


def test_sphere_converges() -> None:
    errors, facets = [], []
    for n in (4, 8, 16):
        surface = ball(n)
        assert len(surface.creases) == 0
        radii = np.linalg.norm(surface.points(*grid(surface, 4), surface.nodes), axis=1)
        errors.append(np.sqrt(((radii - 1.0) ** 2).mean()))
        facets.append(1.0 - np.linalg.norm(surface.nodes[surface.quads].mean(axis=1), axis=1).min())
        assert np.abs(radii - 1.0).max() < 0.12 * facets[-1]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[0] > 1e-4
    assert (orders > 2.4).all()


def test_sphere_of_very_unequal_edges_converges_alike() -> None:
    errors = []
    for n in (5, 9, 17):
        surface = ball(n, ratio=5.0)
        assert len(surface.creases) == 0
        deviations = np.linalg.norm(surface.points(*grid(surface, 4), surface.nodes), axis=1) - 1.0
        facets = 1.0 - np.linalg.norm(surface.nodes[surface.quads].mean(axis=1), axis=1)
        errors.append(np.sqrt((deviations**2).mean()))
        assert errors[-1] < 0.35 * np.sqrt((facets**2).mean()) * (5 / n)
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 2.4).all()


def test_symmetric_bodies_get_symmetric_surfaces(request: pytest.FixtureRequest) -> None:
    for name in ("reference", "pb"):
        speaker: Speaker = request.getfixturevalue(name)
        surface = speaker.smooth_surface
        partner = mirror_pairs(speaker.nodes)
        faces, u, v = grid(surface, 3)
        turned = partner[surface.quads]
        other = matching_faces(turned, surface.quads)
        corner = (surface.quads[other] == turned[:, :1]).argmax(axis=1)
        places = np.array([face_coordinates(c, v[i], u[i]) for i, c in enumerate(corner[faces])])
        weights = surface.operator(faces, u, v).toarray()
        mirrored = surface.operator(other[faces], *places.T).toarray()
        assert np.abs(mirrored[:, partner] - weights).max() < 5e-14


def test_derivatives_are_slopes(surface: SmoothSurface) -> None:
    faces, u, v = grid(surface, 3)
    positions = bent(surface.nodes)
    h = 1e-6
    for slope, (du, dv) in zip(surface.derivatives(faces, u, v), ((h, 0.0), (0.0, h)), strict=True):
        after = surface.points(faces, u + du, v + dv, positions)
        before = surface.points(faces, u - du, v - dv, positions)
        exact = slope @ positions
        assert np.linalg.norm(exact, axis=1).min() > 0.0
        assert np.abs((after - before) / (2 * h) - exact).max() < 1e-7 * np.abs(exact).max()


@pytest.mark.parametrize("divisions", [1, 2, 5])
def test_triangulation_is_closed(surface: SmoothSurface, divisions: int) -> None:
    weights, triangles = surface.triangulation(divisions)
    corners = np.unique(surface.quads)
    assert np.array_equal((weights @ surface.nodes)[: len(corners)], surface.nodes[corners])
    assert len(triangles) == 2 * len(surface.quads) * divisions**2
    assert np.array_equal(np.unique(triangles), np.arange(weights.shape[0]))
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = {tuple(pair) for pair in pairs.tolist()}
    assert len(forward) == len(pairs)
    assert forward == {(b, a) for a, b in forward}
    volume = np.linalg.det((weights @ surface.nodes)[triangles]).sum() / 6
    facets, quads = surface.nodes[surface.quads], surface.quads
    flat = sum(np.linalg.det(facets[:, [0, i, j]]).sum() for i, j in ((1, 2), (2, 3))) / 6
    assert quads.size > 0
    assert volume == pytest.approx(flat, rel=0.15)


def test_volume_is_near_that_of_the_hexahedra(reference: Speaker, pb: Speaker) -> None:
    for speaker, swelling in ((reference, 0.025), (pb, 0.06)):
        weights, triangles = speaker.smooth_surface.triangulation(6)
        volume = np.linalg.det((weights @ speaker.nodes)[triangles]).sum() / 6
        assert 1.0 < volume / speaker.volume < 1.0 + swelling


def test_samples_carry_the_area(reference: Speaker) -> None:
    surface = reference.smooth_surface
    faces = np.flatnonzero(surface.nodes[surface.quads, 2].mean(axis=1) > 0.085)[::-3]
    samples = surface.samples(faces, 0.0025)
    corners = surface.nodes[surface.quads[faces]]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    both = np.maximum(edges[:, :2], edges[:, 2:])  # opposite edges are divided alike, by the longer
    expected = np.clip(np.ceil(both / 0.0025), 1, 6).astype(int).prod(axis=1)
    assert len(set(expected)) > 4
    assert np.array_equal(samples.faces, np.repeat(faces, expected))
    assert np.array_equal(samples.operator.toarray(), surface.operator(samples.faces, samples.u, samples.v).toarray())
    assert np.allclose(np.linalg.norm(samples.normals, axis=1), 1.0, rtol=1e-14)
    facets = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (samples.normals * np.repeat(facets, expected, axis=0)).sum(axis=1).min() > 0
    fine = grid(surface, 40, faces)
    areas = np.linalg.norm(surface.area_vectors(*fine), axis=1).reshape(len(faces), -1).mean(axis=1)
    carried = np.bincount(samples.faces, weights=samples.areas)[faces]
    assert np.allclose(carried, areas, rtol=1e-2)  # 2 x 2 Gauss points in each cell
    assert carried.sum() == pytest.approx(areas.sum(), rel=1e-3)
    assert len(surface.samples([], 0.001).u) == 0
    assert len(surface.samples(faces[:2], 1.0).u) == 2
    assert len(surface.samples(faces[:2], 1e-5).u) == 72


def test_lattice_has_nodes_and_edges_and_no_wider_gaps(reference: Speaker) -> None:
    surface = reference.smooth_surface
    faces = np.arange(0, len(surface.quads), 7)
    face, u, v = surface_lattice(surface, faces, 1e-3)
    points = surface.operator(face, u, v) @ surface.nodes
    assert np.array_equal(np.unique(face), faces)
    for number in faces[:20]:
        own = face == number
        corners = surface.nodes[surface.quads[number]]
        assert np.linalg.norm(points[own][:, None] - corners, axis=2).min(axis=0).max() < 1e-15
        columns, rows = len(np.unique(u[own])), len(np.unique(v[own]))
        assert own.sum() == columns * rows
        assert np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)[[0, 2]].max() <= 1e-3 * (columns - 1)
        assert np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)[[1, 3]].max() <= 1e-3 * (rows - 1)
    assert len(surface_lattice(surface, faces[:1], 1e-6)[0]) == 41**2
    with pytest.raises(InputError, match="no face"):
        surface_lattice(surface, [len(surface.quads)], 1e-3)


def test_pb_bulges_little_where_it_may_touch(pb: Speaker) -> None:
    surface = pb.smooth_surface
    for quads in pb.contact_faces.values():
        faces = matching_faces(quads, surface.quads)
        points = grid(surface, 6, faces)
        a, b, c, d = (pb.nodes[surface.quads[points[0], corner]] for corner in range(4))
        u, v = points[1][:, None], points[2][:, None]
        facet = np.cross(v * (c - d) + (1 - v) * (b - a), u * (c - b) + (1 - u) * (d - a))
        bilinear = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
        off = surface.points(*points, pb.nodes) - bilinear
        height = (off * facet).sum(axis=1) / np.linalg.norm(facet, axis=1)
        assert 0.1e-3 < np.abs(height).mean() < 0.75e-3
        assert np.abs(height).max() < 2.0e-3
        assert (normals(surface, points, pb.nodes) * facet).sum(axis=1).min() > 0.0


def test_node_inside_a_face_and_parts_that_touch_at_a_node() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]]
    split = [*sides[:1], [4, 5, 6, 8], [4, 8, 6, 7], *sides[2:]]  # node 8 has two faces and two edges only
    surface = SmoothSurface(np.concatenate([corners, [[0.4, 0.6, 1.05]]]), split, crease_angle=np.pi)
    assert normal_jumps(surface, np.array([0.0, 1.0]), surface.nodes).max() < 1e-13
    two = np.concatenate([corners, corners[1:] + 0.0])
    two[8:] *= -1.0
    other = [[0 if n == 0 else n + 7 for n in side[::-1]] for side in sides]
    surface = SmoothSurface(two, sides + other)
    weights = surface.operator(*grid(surface, 2))
    single = SmoothSurface(corners, sides).operator(*grid(surface, 2, np.arange(6)))
    assert np.array_equal(weights[:24, :8].toarray(), single.toarray())


def test_arrays_are_write_protected_and_pickled(block: Speaker) -> None:
    surface = block.smooth_surface
    assert surface is block.smooth_surface
    for array in (surface.nodes, surface.quads, surface.creases, surface.mesh.twin, surface.samples([0], 0.01).areas):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    copy = pickle.loads(pickle.dumps(surface))
    assert np.array_equal(copy.operator([3], [0.3], [0.4]).toarray(), surface.operator([3], [0.3], [0.4]).toarray())


def _bad(speaker: Speaker, change: Callable[[np.ndarray, np.ndarray], tuple[Any, Any]]) -> None:
    SmoothSurface(*change(speaker.nodes.copy(), speaker.surface_quads.copy()))


def _moved(nodes: np.ndarray, node: int, to: int) -> np.ndarray:
    nodes[node] = nodes[to]
    return nodes


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda x, q: (x, q[1:]), r"the edge of face \d+ between the nodes \d+ and \d+ has no face on its other side"),
        (lambda x, q: (x, np.concatenate([q, q[:1]])), r"faces 0 and 24 both run from node \d+ to node"),
        (lambda x, q: (x, np.concatenate([q[:1, ::-1], q[1:]])), r"faces 0 and \d+ both run from"),
        (lambda x, q: (x, q[:, ::-1]), "normals point inwards"),
        (lambda x, q: (x, q[:0]), "a surface needs faces"),
        (lambda x, q: (x, q + 10), r"face \d+ names node \d+; there are 27 nodes"),
        (lambda x, q: (x[:, :2], q), r"nodes: expected shape \(n, 3\)"),
        (lambda x, q: (_moved(x, q[5, 0], q[5, 1]), q), r"face \d+: its neighbouring corners \d+ and \d+ are at the"),
        (lambda x, q: (x * [1, 1, 0], q), r"are at the same place|has no area"),
    ],
)
def test_refused_surfaces(block: Speaker, change: Callable[..., tuple[Any, Any]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        _bad(block, change)


def test_parts_that_touch_along_an_edge_are_refused(make_block: Callable[..., Any]) -> None:
    nodes, hexahedra, _ = make_block(2, 2, 1)
    used, corners = np.unique(hexahedra[[0, 3]], return_inverse=True)
    speaker = Speaker(nodes[used], corners.reshape(2, 8))
    with pytest.raises(InputError, match="no more than two may meet at an edge"):
        _ = speaker.smooth_surface


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.operator([0, 1], [0.5], [0.5]), "faces, u and v differ in length: 2, 1, 1"),
        (lambda s: s.operator([24], [0.5], [0.5]), r"there is no face 24; the surface has 24"),
        (lambda s: s.operator([0], [1.5], [0.5]), "u runs from 0 to 1 over a face, got 1.5"),
        (lambda s: s.derivatives([0], [0.5], [-0.5]), "v runs from 0 to 1 over a face, got -0.5"),
        (lambda s: s.points([0], [0.5], [0.5], s.nodes[1:]), "one row for each of 27 nodes, got 26"),
        (lambda s: s.samples([24], 0.001), "there is no face 24"),
        (lambda s: s.samples([0], 0.0), "spacing must be a positive length"),
        (lambda s: s.triangulation(0), "divisions must be at least 1, got 0"),
        (lambda s: s.triangulation(1.5), "divisions: 1.5 is not a whole number"),
        (lambda s: SmoothSurface(s.nodes, s.quads, 0.0), "crease_angle must be above 0"),
    ],
)
def test_refused_requests(block: Speaker, call: Callable[[SmoothSurface], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        call(block.smooth_surface)
