"""Landmarks that can be measured on a subject, found on any speaker."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from glossa.anatomy import Speaker, landmark_points
from glossa.anatomy.landmark_points import LATERAL, MIDSAGITTAL, SIDES, tongue_surface
from glossa.anatomy.walls import Wall

ON = {
    "hard_palate": ["upper_incisor", "alveolar_ridge", "vault", "palate_side", "upper_molar"],
    "mandible": ["lower_incisor", "symphysis", "lower_molar"],
    "tongue": ["tip", "blade", "dorsum", "back", "rear", "vallecula", "frenulum", "tongue_side", "root_side"],
    "hyoid": ["hyoid_horn"],
    "rear": ["pharynx_wall", "lower_pharynx_wall", "velum", "palate_end", "pharynx_side"],
}


@pytest.fixture(params=["reference", "pb"])
def speaker(request: pytest.FixtureRequest) -> Speaker:
    found: Speaker = request.getfixturevalue(request.param)
    return found


def _dense(wall: Wall) -> np.ndarray:
    """Points on a surface, less than half a millimetre apart for edges of a few millimetres."""
    corners = wall.vertices[wall.triangles]
    steps = np.linspace(0.0, 1.0, 11)
    a, b = (grid.ravel() for grid in np.meshgrid(steps, steps))
    a, b = a[a + b <= 1.0 + 1e-9], b[a + b <= 1.0 + 1e-9]
    weights = np.stack([a, b, 1.0 - a - b], axis=1)
    return np.asarray(np.einsum("pk,tki->tpi", weights, corners).reshape(-1, 3))


def _keys(names: list[str]) -> list[str]:
    return [key for name in names for key in ([name] if name in MIDSAGITTAL else [f"{name}_{side}" for side in SIDES])]


def test_every_landmark_is_found_on_both_speakers(speaker: Speaker) -> None:
    points = landmark_points(speaker)
    assert list(points) == [*MIDSAGITTAL, *(f"{name}_{side}" for name in LATERAL for side in SIDES)]
    for name in MIDSAGITTAL:
        assert points[name][1] == 0.0
    for name in LATERAL:
        left, right = points[f"{name}_left"], points[f"{name}_right"]
        assert right[1] > 0.005
        assert np.allclose(left, right * [1, -1, 1], rtol=0, atol=1e-8)


def test_landmarks_lie_on_their_organs(speaker: Speaker) -> None:
    points = landmark_points(speaker)
    assert speaker.hyoid is not None
    assert speaker.hyoid.surface is not None
    rear = [speaker.walls[name] for name in ("soft_palate", "pharynx", "larynx") if name in speaker.walls]
    clouds = {
        "hard_palate": _dense(speaker.walls["hard_palate"]),
        "mandible": _dense(speaker.walls["mandible"]),
        "tongue": _dense(tongue_surface(speaker)),
        "hyoid": _dense(speaker.hyoid.surface),
        "rear": np.concatenate([_dense(wall) for wall in rear]),
    }
    for organ, names in ON.items():
        distances = cKDTree(clouds[organ]).query(np.array([points[key] for key in _keys(names)]))[0]
        assert distances.max() < 0.5e-3, (organ, names)


def test_order_along_the_tract(speaker: Speaker) -> None:
    """Front to back, and top to bottom, as in every head."""
    points = landmark_points(speaker)
    palate = [points[name] for name in ("upper_incisor", "alveolar_ridge", "vault", "palate_end", "velum")]
    assert (np.diff([point[0] for point in palate]) > 5e-3).all()
    rear = [points[name] for name in ("velum", "pharynx_wall", "lower_pharynx_wall", "glottis")]
    assert (np.diff([point[2] for point in rear]) < -10e-3).all()
    tongue = [points[name] for name in ("tip", "blade", "dorsum", "back", "rear")]
    assert (np.diff([point[0] for point in tongue]) > 5e-3).all()
    assert points["tip"][0] < points["frenulum"][0] < points["dorsum"][0]
    assert points["vallecula"][2] < points["rear"][2]
    assert points["vault"][2] > points["dorsum"][2]
    assert points["symphysis"][2] < points["frenulum"][2] < points["lower_incisor"][2]


def test_known_places_of_the_built_in_speaker(reference: Speaker) -> None:
    points = landmark_points(reference)
    for name in ("dorsum", "vallecula"):
        node = reference.nodes[reference.node_sets[name][0]]
        assert np.linalg.norm(points[name] - node) < 5e-3
    palate = reference.walls["hard_palate"].vertices
    middle = palate[palate[:, 1] == 0.0]
    assert points["vault"][2] == pytest.approx(middle[:, 2].max(), abs=0.1e-3)
    assert points["upper_incisor"] == pytest.approx(middle[middle[:, 2].argmin()], abs=1e-6)
    assert points["alveolar_ridge"][2] == pytest.approx(0.5 * (middle[:, 2].min() + middle[:, 2].max()), abs=0.3e-3)
    larynx = reference.walls["larynx"].vertices
    assert points["glottis"][2] == pytest.approx(larynx[:, 2].min(), abs=0.5e-3)
    styloid = reference.nodes[reference.node_sets["styloid"]]
    assert np.array_equal(points["styloid_right"], styloid[styloid[:, 1] > 0.0][0])


def test_landmarks_hardly_depend_on_the_resolution(reference: Speaker) -> None:
    coarse, fine = landmark_points(reference), landmark_points(Speaker.reference(2))
    assert max(np.linalg.norm(coarse[name] - fine[name]) for name in coarse) < 2e-3


def test_landmarks_move_with_the_speaker(reference: Speaker) -> None:
    shift = np.array([0.03, 0.0, -0.02])
    moved = Speaker(
        reference.nodes + shift,
        reference.hexahedra,
        muscles=reference.muscles,
        node_sets=reference.node_sets,
        walls={name: Wall(wall.vertices + shift, wall.faces) for name, wall in reference.walls.items()},
    )
    before, after = landmark_points(reference), landmark_points(moved)
    assert set(before) - set(after) == {"hyoid", "hyoid_horn_left", "hyoid_horn_right"}
    for name in after:
        assert np.allclose(after[name], before[name] + shift, rtol=0, atol=1e-6), name


def test_a_bare_tongue_has_the_landmarks_of_the_tongue(reference: Speaker) -> None:
    bare = Speaker(reference.nodes, reference.hexahedra, muscles=reference.muscles)
    found = landmark_points(bare)
    names = {"tip", "blade", "dorsum", "back", "rear", "vallecula", "frenulum", "root_side_left", "root_side_right"}
    assert set(found) == names
    full = landmark_points(reference)
    for name in names:
        assert np.array_equal(found[name], full[name])
