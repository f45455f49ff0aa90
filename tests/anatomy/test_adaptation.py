"""Speakers adapted to measured points: what is met exactly, what is kept, what is refused."""

from __future__ import annotations

import logging
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from glossa import VOWELS, InputError, Scene, area_function
from glossa.anatomy import Hyoid, Speaker, Spring, landmark_points
from glossa.anatomy.adaptation import correspondences
from glossa.anatomy.landmark_points import MIDSAGITTAL, tongue_surface
from glossa.anatomy.mirror import half_body, mirror_pairs
from glossa.anatomy.plane_cut import plane_cut
from glossa.anatomy.solid import solid
from glossa.anatomy.warp import Warp, affine_amplification, best_similarity, similarity_amplification
from glossa.studies import rest_posture
from glossa.tract.midline import midsagittal_sides

DOWN = np.array([0.0, 0.0, -1.0])
SHEAR = np.array([[0.9, 0.0, 0.12], [0.0, 1.15, 0.0], [-0.08, 0.0, 1.1]])  # keeps the midplane
ARCH = ("palate_side", "upper_molar", "lower_molar", "tongue_side")
SHIFT = np.array([0.02, 0.0, -0.05])
Points = dict[str, np.ndarray]
log = logging.getLogger(__name__)


@pytest.fixture(scope="module")
def own(reference: Speaker) -> Points:
    return landmark_points(reference)


@pytest.fixture(scope="module")
def lowered(own: Points) -> Points:
    """Targets of a pharynx 8 mm longer."""
    moved = ("glottis", "hyoid", "vallecula", "lower_pharynx_wall", "hyoid_horn_left", "hyoid_horn_right")
    return own | {name: own[name] + 0.008 * DOWN for name in moved}


@pytest.fixture(scope="module")
def longer(reference: Speaker, lowered: Points) -> Speaker:
    return reference.adapted_to(lowered)


def _every_point(speaker: Speaker) -> np.ndarray:
    """(n, 3) nodes, walls, and all that belongs to the hyoid."""
    hyoid = speaker.hyoid
    assert hyoid is not None
    assert hyoid.surface is not None
    ends = [end for spring in hyoid.springs for end in (spring.on_hyoid, spring.fixed)]
    walls = [wall.vertices for wall in speaker.walls.values()]
    return np.concatenate([speaker.nodes, *walls, hyoid.surface.vertices, np.array(ends)])


# What is met


@pytest.mark.parametrize("name", ["reference", "pb"])
def test_own_landmarks_change_nothing(request: pytest.FixtureRequest, name: str) -> None:
    speaker: Speaker = request.getfixturevalue(name)
    same = speaker.adapted_to(landmark_points(speaker), name=speaker.name)
    assert np.abs(_every_point(same) - _every_point(speaker)).max() <= 1e-12
    assert same.hyoid is not None
    assert speaker.hyoid is not None
    assert same.hyoid.mass == pytest.approx(speaker.hyoid.mass, rel=1e-12)
    assert np.allclose(same.hyoid.centre, speaker.hyoid.centre, rtol=0, atol=1e-12)


def test_targets_are_met_exactly(reference: Speaker, own: Points) -> None:
    """Free points that are nodes land on their targets."""
    names = ("tip", "dorsum", "vallecula", "styloid")
    nodes = np.concatenate([reference.node_sets[name] for name in names])
    targets = reference.nodes[nodes] + np.array([[2, 0, -1], [0, 0, 3], [-1, 0, -2], [0, -1, 2], [0, 1, 2]]) * 1e-3
    kept = {name: own[name] for name in ("upper_incisor", "vault", "glottis", "pharynx_wall", "palate_side_left")}
    adapted = reference.adapted_to(kept, points=(reference.nodes[nodes], targets))
    assert np.abs(adapted.nodes[nodes] - targets).max() < 2e-12
    styloid = landmark_points(adapted)["styloid_right"]
    assert styloid == pytest.approx(targets[-1], abs=2e-12)


def test_the_warp_meets_every_landmark(reference: Speaker, lowered: Points) -> None:
    given = correspondences(reference, lowered)
    warp = Warp(given.points, given.targets, reference.nodes, symmetric=given.symmetric)
    assert given.symmetric
    assert warp.trend == "affine"
    assert np.abs(given.targets - given.points).max() == pytest.approx(0.008)
    assert np.abs(warp(given.points) - given.targets).max() < 2e-12
    step = 1e-6 * np.array([0.3, -0.5, 0.8])  # gradients by other differences
    for place in reference.nodes[::200]:
        change = (warp(place[None] + step) - warp(place[None] - step))[0]
        assert np.allclose(change, 2.0 * warp.gradient(place[None])[0] @ step, rtol=0, atol=2e-10)


def test_affine_maps_are_reproduced(reference: Speaker, own: Points) -> None:
    targets = {name: SHEAR @ point + SHIFT for name, point in own.items()}
    adapted = reference.adapted_to(targets)
    assert np.abs(_every_point(adapted) - (_every_point(reference) @ SHEAR.T + SHIFT)).max() < 1e-9
    assert adapted.volume == pytest.approx(np.linalg.det(SHEAR) * reference.volume, rel=1e-9)


def test_landmarks_of_the_adapted_speaker_are_the_targets(longer: Speaker, lowered: Points) -> None:
    """Found anew by their rules; the extreme points of a warped outline slide along it a little."""
    found = landmark_points(longer)
    off = {name: float(np.linalg.norm(found[name] - lowered[name])) for name in lowered}
    assert max(off.values()) < 4e-3, off
    assert np.median(list(off.values())) < 0.5e-3


# Few points


def test_one_point_shifts(reference: Speaker, own: Points) -> None:
    adapted = reference.adapted_to({"upper_incisor": own["upper_incisor"] + [0.01, 0.0, -0.02]})
    assert np.abs(adapted.nodes - reference.nodes - [0.01, 0.0, -0.02]).max() < 1e-12


def test_two_far_points_make_a_similarity(reference: Speaker, own: Points) -> None:
    a, b = own["upper_incisor"], own["glottis"]
    turn = 1.1 * np.array([[np.cos(0.2), 0.0, -np.sin(0.2)], [0.0, 1.0, 0.0], [np.sin(0.2), 0.0, np.cos(0.2)]])
    adapted = reference.adapted_to({"upper_incisor": (turn @ a)[[0, 2]], "glottis": turn @ b})
    assert np.abs(adapted.nodes - reference.nodes @ turn.T).max() < 1e-11
    assert adapted.hyoid is not None
    assert reference.hyoid is not None
    assert adapted.hyoid.mass == pytest.approx(1.1**3 * reference.hyoid.mass, rel=1e-9)


def test_near_points_do_not_carry_the_trend_far(reference: Speaker, own: Points) -> None:
    """Two millimetres at the vault alone: nothing that was not measured moves by more."""
    palate = {name: own[name] for name in ("upper_incisor", "alveolar_ridge", "vault", "palate_end")}
    adapted = reference.adapted_to(palate | {"vault": own["vault"] + [0.0, 0.0, 0.002]})
    moves = np.linalg.norm(_every_point(adapted) - _every_point(reference), axis=1)
    assert 1.5e-3 < moves.max() < 2.5e-3


def test_amplification_predicts_what_errors_do() -> None:
    """Of targets with independent errors, on the worst point."""
    generator = np.random.default_rng(5)
    points = generator.normal(size=(7, 3)) * [3.0, 1.0, 2.0]
    reach = generator.normal(size=(4, 3)) * 4.0
    design, goal = np.column_stack([np.ones(7), points]), np.column_stack([np.ones(4), reach])
    weights = goal @ np.linalg.pinv(design)
    assert affine_amplification(points, reach) == pytest.approx(np.linalg.norm(weights, axis=1).max())
    assert affine_amplification(points[:3], reach) == np.inf
    flat = points * [1.0, 0.0, 1.0]
    assert affine_amplification(flat, reach) == np.inf
    errors = generator.normal(size=(4000, 7, 2))
    far = reach * [1.0, 0.0, 1.0]
    moved = []
    for error in errors:
        shifted = flat + 1e-6 * np.stack([error[:, 0], np.zeros(7), error[:, 1]], axis=1)
        moved.append(best_similarity(flat, shifted).displacement(far)[:, [0, 2]] / 1e-6)
    spread = np.sqrt((np.array(moved) ** 2).mean(axis=(0, 2))).max()
    assert similarity_amplification(flat, far) == pytest.approx(spread, rel=0.05)


# Symmetry


def test_symmetric_targets_keep_the_symmetry_bit_for_bit(reference: Speaker, longer: Speaker) -> None:
    before, after = mirror_pairs(reference.nodes, tolerance=0.0), mirror_pairs(longer.nodes, tolerance=0.0)
    assert np.array_equal(before, after)
    middle = reference.midsagittal_nodes
    assert (longer.nodes[middle, 1] == 0.0).all()
    for wall in longer.walls.values():
        mirror_pairs(np.unique(wall.vertices, axis=0), tolerance=0.0)
    assert longer.hyoid is not None
    assert longer.hyoid.surface is not None
    mirror_pairs(longer.hyoid.surface.vertices, tolerance=0.0)
    half_body(longer)


def test_pieces_of_a_wall_still_share_their_vertices(reference: Speaker, longer: Speaker) -> None:
    for first, second in (("hard_palate", "soft_palate"), ("soft_palate", "pharynx"), ("pharynx", "larynx")):
        shared = [
            cKDTree(speaker.walls[second].vertices).query(speaker.walls[first].vertices)[0] == 0.0
            for speaker in (reference, longer)
        ]
        assert shared[0].sum() == 3 * 49
        assert np.array_equal(*shared)


def test_one_side_stands_for_both(reference: Speaker, own: Points) -> None:
    wide = {f"{name}_{side}": own[f"{name}_{side}"] * [1.0, 1.08, 1.0] for name in ARCH for side in ("left", "right")}
    middle = {name: own[name] for name in MIDSAGITTAL}
    both = reference.adapted_to(middle | wide)
    one = reference.adapted_to(middle | {name: wide[name] for name in wide if name.endswith("left")})
    assert np.abs(one.nodes - both.nodes).max() < 1e-11
    widths = [np.abs(speaker.walls["hard_palate"].vertices[:, 1]).max() for speaker in (both, reference)]
    ratio = widths[0] / widths[1]
    assert ratio == pytest.approx(1.08, abs=0.03)


def test_free_points_of_one_side_stand_for_both(reference: Speaker, own: Points) -> None:
    palate = reference.walls["hard_palate"].vertices
    beside = palate[palate[:, 1] > 5e-3][::150]
    adapted = reference.adapted_to(own, points=(beside, beside - 0.0005 * DOWN))
    assert np.array_equal(mirror_pairs(adapted.nodes, tolerance=0.0), mirror_pairs(reference.nodes))


def test_different_sides_make_an_asymmetric_speaker(reference: Speaker, own: Points) -> None:
    adapted = reference.adapted_to(own | {"palate_side_left": own["palate_side_left"] - [0.0, 0.002, 0.0]})
    palate, before = adapted.walls["hard_palate"].vertices, reference.walls["hard_palate"].vertices
    moved = np.abs(palate - before).max(axis=1)
    assert moved[before[:, 1] < -5e-3].max() > 1.5e-3
    assert moved[before[:, 1] > 5e-3].max() < 0.5e-3
    with pytest.raises(InputError, match="no mirror image"):
        half_body(adapted)
    Scene(adapted, mirror=False)


# What is kept


def test_topology_and_force_capacity_are_kept(reference: Speaker, longer: Speaker) -> None:
    assert longer.name == "reference, resolution 1, adapted"
    assert np.array_equal(longer.hexahedra, reference.hexahedra)
    assert longer.muscles == reference.muscles
    for kind in ("node_sets", "contours", "contact_faces"):
        before, after = getattr(reference, kind), getattr(longer, kind)
        assert list(after) == list(before)
        for name in before:
            assert np.array_equal(after[name], before[name])


def test_the_hyoid_keeps_density_and_slack(reference: Speaker, longer: Speaker) -> None:
    before, after = reference.hyoid, longer.hyoid
    assert before is not None
    assert after is not None
    assert before.surface is not None
    assert after.surface is not None
    volumes = [solid(surface)[0] for surface in (before.surface, after.surface)]
    assert volumes[1] != pytest.approx(volumes[0], rel=1e-3)
    assert after.mass / volumes[1] == pytest.approx(before.mass / volumes[0], rel=1e-12)
    assert after.centre == pytest.approx(solid(after.surface)[1], abs=1e-9)
    assert [spring.name for spring in after.springs] == [spring.name for spring in before.springs]
    for spring in after.springs:
        assert spring.rest_length == pytest.approx(np.linalg.norm(spring.fixed - spring.on_hyoid), rel=1e-15)


def test_a_taut_spring_stays_as_taut(reference: Speaker, own: Points) -> None:
    hyoid = reference.hyoid
    assert hyoid is not None
    first = hyoid.springs[0]
    taut = Spring(first.on_hyoid, first.fixed, first.stiffness, 0.8 * first.rest_length, first.name)
    parts: dict[str, Any] = {name: getattr(reference, name) for name in ("muscles", "node_sets", "walls")}
    bare = Hyoid(None, hyoid.mass, hyoid.centre, (taut,))
    speaker = Speaker(reference.nodes, reference.hexahedra, **parts, hyoid=bare)
    adapted = speaker.adapted_to({name: 1.2 * own[name] for name in ("upper_incisor", "glottis", "pharynx_wall")})
    assert adapted.hyoid is not None
    (spring,) = adapted.hyoid.springs
    assert spring.rest_length == pytest.approx(1.2 * taut.rest_length)
    assert adapted.hyoid.mass == hyoid.mass
    assert adapted.hyoid.centre == pytest.approx(1.2 * hyoid.centre)


# Whole speakers


def test_a_longer_pharynx(reference: Speaker, longer: Speaker) -> None:
    lengths = [area_function(rest_posture(speaker), "a").length for speaker in (reference, longer)]
    assert 4e-3 < lengths[1] - lengths[0] < 11e-3
    larynx = reference.walls["larynx"].vertices
    bottom = (larynx[:, 1] == 0.0) & (larynx[:, 2] == larynx[:, 2].min())  # front and rear of the glottis
    assert bottom.sum() == 2
    moves = longer.walls["larynx"].vertices[bottom] - larynx[bottom]
    assert moves.mean(axis=0) == pytest.approx(0.008 * DOWN, abs=0.3e-3)
    assert longer.scaled_jacobians.min() > 0.3


def test_finer_meshes_follow_the_same_map(longer: Speaker, lowered: Points) -> None:
    before = Speaker.reference(2)
    fine = before.adapted_to(lowered)
    assert fine.scaled_jacobians.min() > 0.25
    assert fine.volume == pytest.approx(longer.volume, rel=0.02)
    assert np.array_equal(mirror_pairs(fine.nodes, tolerance=0.0), mirror_pairs(before.nodes))
    distance = cKDTree(fine.nodes).query(longer.nodes)[0]
    assert distance.max() < 2e-3  # landmarks are found on the finer mesh's own surface


def _distances(speaker: Speaker, other: Speaker) -> dict[str, float]:
    """Root mean square distance, m, of midsagittal lines from those of another speaker: the tongue's upper side from
    tip to rear, and the outer wall."""
    (outline,), (goal,) = (plane_cut(tongue_surface(one), 1, 1e-5) for one in (speaker, other))
    own = landmark_points(speaker)
    upper = outline[(outline[:, 1] > own["tip"][2]) | (outline[:, 0] > own["dorsum"][0])]
    upper = upper[upper[:, 1] > own["rear"][2]]
    lines = {"dorsum": (upper, goal), "outer": (midsagittal_sides(speaker)[0], midsagittal_sides(other)[0])}
    return {name: float(np.sqrt((cKDTree(_dense(b)).query(a)[0] ** 2).mean())) for name, (a, b) in lines.items()}


def _dense(line: np.ndarray) -> np.ndarray:
    along = np.linspace(0.0, 1.0, 20)[:, None]
    return np.concatenate([p + along * (q - p) for p, q in pairwise(line)])


def test_the_built_in_speaker_becomes_pb(reference: Speaker, pb: Speaker) -> None:
    adapted = reference.adapted_to(landmark_points(pb), name="reference as PB")
    assert adapted.scaled_jacobians.min() > 0.2
    before, after = _distances(reference, pb), _distances(adapted, pb)
    log.info(
        "mm from PB's lines: before %s, after %s",
        *({k: f"{v * 1e3:.2f}" for k, v in d.items()} for d in (before, after)),
    )
    assert after["outer"] < 0.75 * before["outer"]
    assert after["dorsum"] < 0.8e-3
    assert adapted.volume == pytest.approx(pb.volume, rel=0.02)
    posture = Scene(adapted, mirror=True).equilibrate(VOWELS["i"])
    assert posture.contact is not None
    assert posture.contact.touched_areas["hard_palate"] > 0.5e-4
    assert posture.hyoid is not None


# What is refused


def _refused(speaker: Speaker, message: str, landmarks: Any, **options: Any) -> None:
    with pytest.raises(InputError, match=message):
        speaker.adapted_to(landmarks, **options)


@pytest.mark.parametrize(
    ("landmarks", "message"),
    [
        ({}, "adapted_to needs at least one landmark"),
        ([1, 2], "landmarks must be a mapping from names to points in m, got list"),
        ({"uvula": [0, 0, 0]}, "this speaker has no landmark 'uvula'; it has upper_incisor, .*styloid_right"),
        ({"tip": [0.05, 0.0, np.nan]}, r"landmark 'tip': value at \(2,\) is nan"),
        ({"tip": [0.05]}, r"landmark 'tip': expected the coordinates x, y, z \(or x, z: in the midsagittal plane\)"),
        ({"tip": "front"}, "landmark 'tip': expected an array of numbers"),
        ({"styloid_left": [0.14, 0.12]}, "landmark 'styloid_left': expected the coordinates x, y, z in m, got 2"),
        ({"styloid_left": [0.14, 0.03, 0.12]}, "'styloid_left': y = 0.03 m is on the other side; left is y < 0"),
        ({"tip": [58.0, 0.0, 98.0]}, "tip is to go to .* 98 m from the origin; .*divide millimetres by 1000"),
    ],
)
def test_malformed_targets(reference: Speaker, landmarks: Any, message: str) -> None:
    _refused(reference, message, landmarks)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((2, 3)), "points must be a pair of arrays"),
        ((np.zeros((2, 3)), np.zeros((1, 3))), "2 points of the speaker and 1 of the subject"),
        ((np.zeros((2, 2)), np.zeros((2, 2))), r"points, first: expected shape \(n, 3\)"),
        (([[0.05, 0.0, 0.1], [0.05, 0.0, 0.1001]], [[0.05, 0.0, 0.1]] * 2), "point 0 and point 1 are 0.100 mm apart"),
        (([[0.05, 0.0, 0.1]], [[0.05, 0.0, np.inf]]), r"points, second: value at \(0, 2\) is inf"),
    ],
)
def test_malformed_points(reference: Speaker, points: Any, message: str) -> None:
    _refused(reference, message, {}, points=points)


def test_foreign_units_and_frames(reference: Speaker, own: Points) -> None:
    _refused(reference, "4.5 times as far apart", {name: 4.5 * point for name, point in own.items()})
    sideways = {name: np.array([point[2], point[1], -point[0]]) for name, point in own.items()}
    _refused(reference, "turned by -90 degrees about the lateral axis", sideways)
    forwards = {name: point * [-1.0, 1.0, 1.0] for name, point in own.items()}
    _refused(reference, "turned by|folds over|inside out", forwards)


def test_too_few_asymmetric_points(reference: Speaker, own: Points) -> None:
    targets = {"palate_side_left": own["palate_side_left"], "palate_side_right": own["palate_side_right"] * [1, 1.1, 1]}
    _refused(reference, "2 points whose targets are not mirror symmetric", targets)


def test_targets_that_fold_the_speaker(reference: Speaker, own: Points) -> None:
    swapped = own | {"tip": own["dorsum"], "dorsum": own["tip"]}
    _refused(reference, r"folds over at .* mm; nearest to it, .* is .*, which moved by", swapped)
