"""Speaker, Muscle and Wall: what is computed, and every construction error with its message."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Hyoid, Muscle, Speaker, Spring, Wall
from glossa.errors import InputError

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
HEXAHEDRON = [list(range(8))]


def cube(**parts: Any) -> Speaker:
    return Speaker(CUBE, HEXAHEDRON, **parts)


def test_geometry_of_a_block(block: Speaker) -> None:
    assert block.volume == pytest.approx(8e-6, rel=1e-14)
    assert np.allclose(block.element_volumes, 1e-6, rtol=1e-13)
    assert np.allclose(block.scaled_jacobians, 1.0, rtol=1e-14)
    assert len(block.surface_quads) == 24
    assert len(block.midsagittal_nodes) == 9
    assert np.allclose(block.fibre_rest_lengths("bundle"), 0.02, rtol=1e-14)


def test_surface_normals_point_outwards(block: Speaker) -> None:
    corners = block.nodes[block.surface_quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    outward = corners.mean(axis=1) - block.nodes.mean(axis=0)
    assert ((normals * outward).sum(axis=1) > 0).all()


def test_volume_of_a_sheared_element_is_exact() -> None:
    sheared = CUBE @ np.array([[1.0, 0.3, 0.0], [0.0, 2.0, 0.1], [0.2, 0.0, 0.7]])
    speaker = Speaker(sheared, HEXAHEDRON)
    expected = abs(np.linalg.det(np.array([[1.0, 0.3, 0.0], [0.0, 2.0, 0.1], [0.2, 0.0, 0.7]])))
    assert speaker.volume == pytest.approx(expected, rel=1e-13)
    assert 0 < speaker.scaled_jacobians[0] < 1


def test_arrays_are_write_protected_copies() -> None:
    nodes = CUBE.copy()
    speaker = Speaker(nodes, HEXAHEDRON)
    nodes[0, 0] = 99.0
    assert speaker.nodes[0, 0] == 0.0
    assert speaker.nodes.dtype == np.float64
    assert speaker.hexahedra.dtype == np.int32
    for array in (speaker.nodes, speaker.hexahedra, speaker.element_volumes, speaker.surface_quads):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_pickle_keeps_the_content(block: Speaker) -> None:
    copy = pickle.loads(pickle.dumps(block))
    assert copy.fingerprint == block.fingerprint
    assert not copy.nodes.flags.writeable


def test_fingerprint_follows_content(block: Speaker) -> None:
    assert cube().fingerprint != block.fingerprint
    assert cube().fingerprint == cube().fingerprint
    assert cube(name="a").fingerprint != cube().fingerprint
    assert cube(node_sets={"a": [0]}).fingerprint != cube(contours={"a": [0]}).fingerprint


def test_contact_faces_are_boundary_faces_turned_outwards() -> None:
    palate = {"palate": Wall(CUBE, [[0, 1, 2]]), "jaw": Wall(CUBE, [[0, 1, 2]])}
    plain, named = cube(walls=palate), cube(walls=palate, contact_faces={"palate": [[5, 4, 6, 7], [0, 1, 2, 3]]})
    assert dict(plain.contact_faces) == {}
    assert set(named.contact_faces) == {"palate"}
    assert named.contact_faces["palate"].tolist() == [[4, 5, 6, 7], [0, 3, 2, 1]]
    assert named.fingerprint != plain.fingerprint
    assert cube(walls=palate, contact_faces={}).fingerprint == plain.fingerprint
    copy = pickle.loads(pickle.dumps(named))
    assert copy.fingerprint == named.fingerprint
    assert "contact faces: palate (2)" in named.summary()
    with pytest.raises(ValueError, match="read-only"):
        named.contact_faces["palate"][0] = 0


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([1], "contact_faces must be a mapping"),
        ({"velum": [[4, 5, 6, 7]]}, "there is no wall 'velum'; this speaker has palate"),
        ({"palate": [[4, 5, 6]]}, r"contact faces of wall 'palate': expected shape \(n, 4\)"),
        ({"palate": [[4, 5, 6, 7], [0, 1, 2, 8]]}, "of wall 'palate', face 1 names node 8, but there are 8 nodes"),
        (
            {"palate": [[4, 5, 6, 7], [0, 1, 6, 7]]},
            r"face 1: the nodes \[0, 1, 6, 7\] are not the corners of a",
        ),
        ({"palate": [[4, 5, 6, 7], [0, 1, 2, 3], [6, 7, 5, 4]]}, "faces 0 and 2 are the same"),
    ],
)
def test_bad_contact_faces(faces: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        cube(walls={"palate": Wall(CUBE, [[0, 1, 2]])}, contact_faces=faces)


def test_summary_names_the_parts(block: Speaker) -> None:
    text = block.summary()
    assert "27 nodes" in text
    assert "8 hexahedra" in text
    assert "bundle: 9 fibres" in text
    assert "left (9)" in text


def test_unknown_muscle(block: Speaker) -> None:
    with pytest.raises(InputError, match="no muscle 'GGx'; this speaker has bundle"):
        block.fibre_rest_lengths("GGx")


def test_outside_points_need_a_fibre() -> None:
    nodes = np.concatenate([CUBE, [[0.0, 0.0, 3.0]]])
    with pytest.raises(InputError, match="node 8 belongs to no hexahedron and no fibre"):
        Speaker(nodes, HEXAHEDRON)
    speaker = Speaker(nodes, HEXAHEDRON, muscles={"m": Muscle([0], [[4, 8]], 1.0)})
    assert speaker.outside_points.tolist() == [8]


def _moved(node: int, place: list[float]) -> np.ndarray:
    nodes = CUBE.copy()
    nodes[node] = place
    return nodes


@pytest.mark.parametrize(
    ("nodes", "hexahedra", "message"),
    [
        (CUBE[:, :2], HEXAHEDRON, r"nodes: expected shape \(n, 3\), got \(8, 2\)"),
        ("abc", HEXAHEDRON, "nodes: expected an array of numbers"),
        (_moved(3, [0, np.nan, 0]), HEXAHEDRON, r"nodes: value at \(3, 1\) is nan, not finite"),
        (np.zeros((0, 3)), HEXAHEDRON, "a body needs nodes and hexahedra"),
        (CUBE, np.zeros((0, 8), dtype=int), "a body needs nodes and hexahedra"),
        (CUBE, [list(range(7))], r"hexahedra: expected shape \(n, 8\), got \(1, 7\)"),
        (CUBE, [[0.0, 1, 2, 3, 4, 5, 6, 7]], "hexahedra: expected whole numbers"),
        (CUBE, [[0, 1, 2, 3, 4, 5, 6, -1]], "hexahedra: index -1 out of range"),
        (CUBE, [[0, 1, 2, 3, 4, 5, 6, 8]], r"hexahedron 0 names node 8, but there are 8 nodes \(0..7\)"),
        (CUBE, [[0, 1, 2, 3, 4, 5, 6, 6]], "hexahedron 0 names node 6 more than once"),
        (CUBE, [list(range(8)), [1, 2, 3, 0, 5, 6, 7, 4]], "hexahedra 0 and 1 have the same eight nodes"),
        (CUBE, [[4, 5, 6, 7, 0, 1, 2, 3]], "hexahedron 0 has Jacobian determinant .* not in VTK order"),
        (_moved(6, [0.1, 0.1, 0.1]), HEXAHEDRON, "hexahedron 0 has Jacobian determinant .*too distorted"),
        (_moved(6, [0.5, 0.5, 0.0]), HEXAHEDRON, r"at corner \d \(node \d\).*1 of 1 hexahedra fail"),
    ],
)  # fmt: skip
def test_bad_mesh(nodes: Any, hexahedra: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Speaker(nodes, hexahedra)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"muscles": [1]}, "muscles must be a mapping"),
        ({"muscles": {"m": 1}}, "muscle 'm' must be a Muscle, got int"),
        ({"muscles": {"": Muscle([0], [[0, 1]], 1.0)}}, "muscles: names must be non-empty strings"),
        ({"muscles": {"m": Muscle([1], [[0, 1]], 1.0)}}, "muscle 'm' names element 1, but there are 1 hexahedra"),
        ({"muscles": {"m": Muscle([0, 0], [[0, 1]], 1.0)}}, "muscle 'm' names element 0 more than once"),
        ({"muscles": {"m": Muscle([0], [[0, 1], [0, 9]], 1.0)}}, "muscle 'm', fibre 1 names node 9"),
        ({"muscles": {"m": Muscle([0], [[0, 1, 1]], 1.0)}}, "muscle 'm', fibre 0 names node 1 twice in a row"),
        ({"node_sets": {"jaw": [0, 8]}}, r"node set 'jaw' names node 8, but there are 8 nodes \(0..7\)"),
        ({"node_sets": {"jaw": [0, 0]}}, "node set 'jaw' names node 0 more than once"),
        ({"node_sets": {"jaw": [[0]]}}, "node set 'jaw': expected a one-dimensional array"),
        ({"contours": {"dorsum": [0, 8]}}, "contour 'dorsum' names node 8"),
        ({"contours": {"dorsum": [0, 0]}}, "contour 'dorsum' names node 0 twice in a row"),
        ({"walls": {"palate": 1}}, "wall 'palate' must be a Wall"),
        ({"hyoid": 1}, "hyoid must be a Hyoid or None"),
        ({"name": 1}, "name must be a string"),
    ],
)
def test_bad_parts(parts: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        cube(**parts)


def test_zero_length_segment() -> None:
    nodes = np.concatenate([CUBE, [[0.0, 0.0, 1.0]]])
    with pytest.raises(InputError, match="nodes 4 and 8 are at the same place"):
        Speaker(nodes, HEXAHEDRON, muscles={"m": Muscle([0], [[4, 8]], 1.0)})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([], [[0, 1]], 1.0), "muscle has no elements"),
        (([0], [], 1.0), "muscle has no fibres"),
        (([0], [[0, 1], [2]], 1.0), r"fibre 1 has 1 node\(s\)"),
        (([0.5], [[0, 1]], 1.0), "muscle elements: expected whole numbers"),
        (([0], [[0, -1]], 1.0), "fibre 0: index -1 out of range"),
        (([0], [[0, 1]], 0.0), "force_capacity must be a positive finite"),
        (([0], [[0, 1]], float("inf")), "force_capacity must be a positive finite"),
        (([0], [[0, 1]], "strong"), "force_capacity 'strong' is not a number"),
        (([0], [[0, 1]], 1.0, 0), "fibres_per_element must be at least 1"),
        (([0], [[0, 1]], 1.0, 1.5), "fibres_per_element 1.5 is not a whole number"),
    ],
)
def test_bad_muscle(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Muscle(*arguments)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Wall(CUBE, [[0, 1, 9]]), "wall face 0 names vertex 9; there are 8"),
        (lambda: Wall(CUBE, [[0, 1]]), "wall faces: expected shape"),
        (lambda: Spring([0, 0], [1, 1, 1], 1.0), "three coordinates"),
        (lambda: Spring([0, 0, 0], [1, 1, 1], -1.0, name="s"), "spring 's' stiffness must be finite and not negative"),
        (lambda: Hyoid(None, float("nan"), [0, 0, 0]), "hyoid mass must be finite"),
        (lambda: Hyoid(None, 1.0, [0, 0]), "hyoid centre: expected three coordinates"),
    ],
)
def test_bad_surroundings(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_wall_triangles_and_spring_rest_length() -> None:
    wall = Wall(CUBE, [[0, 1, 2, 3], [4, 5, 6, 6]])
    # Triangles first; of the diagonals of a square, equally long, the one through its corner of least z, x and |y|.
    assert wall.triangles.tolist() == [[4, 5, 6], [0, 1, 2], [0, 2, 3]]
    kite = Wall([[0, 0, 0], [0.01, 0, 0], [0.015, 0.015, 0], [0, 0.01, 0]], [[0, 1, 2, 3]])
    assert kite.triangles.tolist() == [[1, 2, 3], [1, 3, 0]]
    assert Spring([0, 0, 0], [0, 3, 4], 220.0).rest_length == 5.0
