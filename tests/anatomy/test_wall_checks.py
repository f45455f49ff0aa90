"""What is wrong with a wall is found before contact meets it, and named with its place and a cure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from glossa import InputError, Speaker, Wall
from glossa.anatomy.wall_checks import check_facing, check_wall

SIZE, CELLS = 0.05, 20  # of the vault below, m and cells: faces of 2.5 mm


def vault(change: Callable[[np.ndarray], np.ndarray] = lambda faces: faces) -> Wall:
    """An arch over the origin, seen from below: 10 mm above it, 5 mm lower at its edges, normals down."""
    u, v = np.meshgrid(np.linspace(-1, 1, CELLS + 1), np.linspace(-1, 1, CELLS + 1), indexing="ij")
    vertices = np.stack([SIZE / 2 * u, SIZE / 2 * v, 0.01 - 0.005 * v**2], axis=-1).reshape(-1, 3)
    return Wall(vertices, change(vault_faces()))


def vault_faces() -> np.ndarray:
    n = CELLS + 1
    i, j = (k.ravel() for k in np.meshgrid(np.arange(CELLS), np.arange(CELLS), indexing="ij"))
    a, b, c, d = i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def cell(i: int, j: int) -> int:
    """Number of the first triangle of a cell; the second is CELLS**2 later."""
    return i * CELLS + j


def tongue(gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Points in a disc of 15 mm under the vault, ``gap`` below it, and normals upwards."""
    x, y = (k.ravel() for k in np.meshgrid(np.arange(-0.015, 0.0151, 0.002), np.arange(-0.015, 0.0151, 0.002)))
    inside = np.hypot(x, y) <= 0.015
    x, y = x[inside], y[inside]
    points = np.stack([x, y, 0.01 - 0.005 * (y / (SIZE / 2)) ** 2 - gap], axis=1)
    return points, np.broadcast_to([0.0, 0.0, 1.0], points.shape)


def box(size: float) -> Wall:
    corners = size * (np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]) - 0.5)
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return Wall(corners, faces)


def test_sound_walls_pass(pb: Speaker) -> None:
    for wall in (vault(), box(0.01), *pb.walls.values()):
        check_wall("wall", wall)
    assert pb.hyoid is not None
    assert pb.hyoid.surface is not None
    check_wall("hyoid", pb.hyoid.surface)


def test_a_triangle_may_be_given_as_a_quadrilateral_with_its_last_vertex_twice() -> None:
    check_wall("wall", vault(lambda faces: faces[:, [0, 1, 2, 2]]))


def moved(vertex: int, to: np.ndarray) -> Wall:
    sound = vault()
    vertices = sound.vertices.copy()
    vertices[vertex] = to
    return Wall(vertices, sound.faces)


def test_triangles_without_area_are_refused() -> None:
    sound = vault()
    a, b, c = sound.triangles[cell(10, 10)]
    with pytest.raises(InputError, match=r"wall 'palate': triangle \d+ at .* two of its corners are at the same place"):
        check_wall("palate", moved(a, sound.vertices[b] + [0, 0, 5e-8]))
    with pytest.raises(InputError, match=r"wall 'palate': triangle \d+ at .* its area is 0 mm2; remove it or move"):
        check_wall("palate", moved(a, 0.5 * (sound.vertices[b] + sound.vertices[c])))
    with pytest.raises(InputError, match=r"its area is 0\.00011 mm2"):  # 90 nm high, 2.5 mm long
        check_wall("palate", moved(a, 0.5 * (sound.vertices[b] + sound.vertices[c]) + [0, 0, 9e-8]))
    with pytest.raises(InputError, match=r"triangle 210 at \(0\.0, 1\.7, 10\.0\) mm .* \(1 of 800 triangles"):
        check_wall("palate", vault(lambda f: np.where(np.arange(800)[:, None] == 210, f[:, [0, 1, 1]], f)))


def test_triangles_given_twice_are_refused() -> None:
    again = cell(10, 10)
    for turn in ([0, 1, 2], [1, 2, 0], [0, 2, 1]):
        with pytest.raises(InputError, match=rf"wall 'palate': triangles {again} and 800 at .* same three corners"):
            check_wall("palate", vault(lambda f, turn=turn: np.concatenate([f, f[[again]][:, turn]])))  # type: ignore[misc]


def test_edges_of_three_triangles_are_refused() -> None:
    sound = vault()
    a, b, _ = sound.triangles[cell(10, 10)]
    fin = Wall(np.concatenate([sound.vertices, [[0, 0, 0.0]]]), np.concatenate([sound.faces, [[a, b, 441]]]))
    with pytest.raises(InputError, match=r"wall 'palate': the edge at .* belongs to 3 triangles \(\d+, \d+, 800\)"):
        check_wall("palate", fin)


def test_not_a_number_never_becomes_a_wall() -> None:
    with pytest.raises(InputError, match="not finite"):
        moved(3, np.array([0, np.nan, 0]))


@pytest.mark.parametrize("gap", [5e-3, 1e-3, 0.0, -1e-3, -1.9e-3])
def test_a_tongue_in_front_or_slightly_in_the_wall_passes(gap: float) -> None:
    points, normals = tongue(gap)
    check_facing("palate", vault(), points, normals)
    if gap >= 0:
        check_facing("palate", vault(), points)


def test_nothing_to_check() -> None:
    check_facing("palate", vault(lambda f: f[:, ::-1]), np.zeros((0, 3)), np.zeros((0, 3)))
    beyond = np.array([[0.06, 0.0, 0.02], [0.08, 0.0, 0.0]])  # nearest to the rim, where no side is told
    check_facing("palate", vault(), beyond)


@pytest.mark.parametrize("gap", [20e-3, 5e-3, 0.5e-3])
@pytest.mark.parametrize("with_normals", [True, False])
def test_all_faces_reversed(gap: float, with_normals: bool) -> None:
    points, normals = tongue(gap)
    reversed_wall = vault(lambda f: f[:, ::-1])
    check_wall("palate", reversed_wall)
    message = (
        rf"wall 'palate': {len(points)} of the {len(points)} points .* behind it, up to {gap * 1e3:.1f} mm at \(.*\) "
        r"mm; its normals must point towards the tongue: reverse"
    )
    with pytest.raises(InputError, match=message):
        check_facing("palate", reversed_wall, points, normals if with_normals else None)


def test_a_reversed_closed_wall() -> None:
    wall = box(0.01)
    points = np.array([[x, y, 0.007] for x in (-3e-3, 0, 3e-3) for y in (-3e-3, 0, 3e-3)])
    check_facing("mandible", wall, points)
    with pytest.raises(InputError, match="normals must point towards the tongue"):
        check_facing("mandible", Wall(wall.vertices, wall.faces[:, ::-1]), points)


@pytest.mark.parametrize("gap", [5e-3, 1e-3])
def test_one_face_reversed(gap: float) -> None:
    turned = cell(11, 8)

    def turn(faces: np.ndarray) -> np.ndarray:
        faces[turned] = faces[turned][::-1]
        return faces

    points, normals = tongue(gap)
    with pytest.raises(InputError, match=r"wall 'palate': at .*, where the tongue faces it, triangle \d+ .* run diff"):
        check_facing("palate", vault(turn), points, normals)
    turned = cell(0, 1)  # 24 mm off the middle
    check_facing("palate", vault(turn), points, normals)
    turned = cell(11, 8)
    with pytest.raises(InputError, match="run different ways round"):  # not called a tongue behind the wall
        check_facing("palate", vault(turn), points - [0, 0, 0.01], normals)


def test_half_of_the_faces_reversed() -> None:
    points, normals = tongue(1e-3)
    with pytest.raises(InputError, match="run different ways round"):
        check_facing("palate", vault(lambda f: np.where(f[:, :1] < 220, f[:, ::-1], f)), points, normals)


def test_a_hole_where_the_tongue_faces_it() -> None:
    points, normals = tongue(3e-3)

    def without(*cells: int) -> Callable[[np.ndarray], np.ndarray]:
        return lambda f: np.delete(f, [t + k * CELLS**2 for t in cells for k in (0, 1)], axis=0)

    with pytest.raises(
        InputError, match=r"wall 'palate' has a hole of 2\.5 mm \(4 edges\) at \(3\.8, -3\.7, 9\.9\) mm"
    ):
        check_facing("palate", vault(without(cell(11, 8))), points, normals)
    wide = (cell(11, 8), cell(11, 9), cell(12, 8), cell(12, 9))
    with pytest.raises(InputError, match=r"a hole of 5\.0 mm \(8 edges\) .* close it, or keep .* contact_faces"):
        check_facing("palate", vault(without(*wide)), points, normals)
    check_facing("palate", vault(without(cell(18, 17))), points, normals)  # 29 mm off the middle
    check_facing("palate", vault(without(cell(11, 8))), points - [0, 0, 0.01], normals)  # out of reach
    check_facing("palate", vault(lambda f: f[(f < 300).all(axis=1)]), points, normals)  # cut short: that is its rim


def test_a_tongue_half_through_the_wall() -> None:
    points, normals = tongue(3e-3)
    tilted = points + np.outer(points[:, 0], [0, 0, 0.5])
    behind = int((tilted[:, 2] - points[:, 2] > 5.1e-3).sum())
    assert 10 < behind < len(points) / 2
    for directions in (normals, None):
        with pytest.raises(InputError, match=r"rest starts behind it at 18 of 172 points, up to 3\.5 mm at \(13\.0, "):
            check_facing("palate", vault(), tilted, directions)
    with pytest.raises(InputError, match=f"starts behind it at {len(points)} of"):
        check_facing("palate", vault(), tongue(-4e-3)[0], normals)  # through: its normals tell it from a reversed wall


def test_pb_passes_with_its_contact_zones(pb: Speaker) -> None:
    assert set(pb.contact_faces) == set(pb.walls)
    everywhere = pb.smooth_surface.samples(np.arange(len(pb.surface_quads)), 2.5e-3)
    for name, wall in pb.walls.items():
        zone = pb.contact_faces[name]
        check_facing(name, wall, pb.nodes[zone].mean(axis=1))
        check_facing(name, wall, pb.nodes[np.unique(zone)])
        numbers = np.flatnonzero((np.sort(pb.surface_quads, axis=1)[:, None] == np.sort(zone, axis=1)).all(2).any(1))
        assert len(numbers) == len(zone)
        samples = pb.smooth_surface.samples(numbers, 2.5e-3)
        check_facing(name, wall, samples.operator @ pb.nodes, samples.normals)
        check_facing(name, wall, everywhere.operator @ pb.nodes, everywhere.normals)


@pytest.mark.parametrize("name", ["hard_palate", "soft_palate", "mandible"])
def test_pb_with_its_normals_reversed_is_refused(name: str, pb: Speaker) -> None:
    wall = pb.walls[name]
    with pytest.raises(InputError, match="normals must point towards the tongue"):
        check_facing(name, Wall(wall.vertices, wall.triangles[:, ::-1]), pb.nodes[pb.contact_faces[name]].mean(axis=1))
