"""The built-in speaker with walls, friction, mobile hyoid and gravity."""

from __future__ import annotations

import pickle
from functools import cache

import numpy as np
import pytest
from tests.speaker_contact import (
    FRICTIONS,
    REFLEX_ONLY,
    bone_balance,
    largest,
    on_both_sides,
    scene_of,
    tongue_balance,
    touched,
    vowel_of,
)

from glossa import VOWELS, Ramp, Scene, Speaker, _core
from glossa.anatomy.walls import Wall
from glossa.surface_penetration import surface_penetration


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("vowel", list(VOWELS))
def test_vowels_converge_from_rest(reference: Speaker, friction: float, vowel: str) -> None:
    scene, posture = scene_of(reference, friction), vowel_of(reference, friction, vowel)
    report, contact = posture.report, posture.contact
    assert report is not None
    assert contact is not None
    assert report.converged
    assert report.iterations <= 40  # 5 to 14
    assert contact.penetration < 5e-5
    assert np.abs(contact.gaps[contact.touching]).max(initial=0.0) < 5e-5
    tolerance = 10.0 * report.residual + 1e-9  # N; the residual is a 2-norm, this a sum over nodes
    assert tongue_balance(scene, posture) == pytest.approx(np.zeros(3), abs=tolerance)
    force, moment = bone_balance(scene, posture)
    assert force == pytest.approx(np.zeros(3), abs=tolerance)
    assert moment == pytest.approx(np.zeros(3), abs=0.05 * tolerance)


@pytest.mark.parametrize("vowel", list(VOWELS))
def test_the_half_is_the_whole(reference: Speaker, vowel: str) -> None:
    half, full = (vowel_of(reference, 0.0, vowel, mirror) for mirror in (True, False))
    assert largest(half.positions - full.positions) < 1e-7  # 29 nm seen
    assert half.forces.to_numpy() == pytest.approx(full.forces.to_numpy(), abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("vowel", list(VOWELS))
def test_the_half_is_the_whole_with_friction(reference: Speaker, vowel: str) -> None:
    half, full = (vowel_of(reference, 0.1, vowel, mirror) for mirror in (True, False))
    assert largest(half.positions - full.positions) < 2e-6  # 0.2 um of /a/
    assert half.forces.to_numpy() == pytest.approx(full.forces.to_numpy(), abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("vowel", list(VOWELS))
def test_finer_elements_converge(vowel: str) -> None:
    fine = vowel_of(finer(), 0.1, vowel)
    assert fine.report is not None
    assert fine.report.converged
    assert fine.contact is not None
    assert fine.contact.penetration < 5e-5


@cache
def finer() -> Speaker:
    return Speaker.reference(2)


def test_rest_feels_no_wall(reference: Speaker) -> None:
    posture = Scene(reference, gravity=None, mirror=True).equilibrate()
    assert posture.contact is not None
    assert posture.contact.pressures.max() == 0.0
    assert posture.contact.gaps.min() >= 0.0  # a wall counts as dented where a point starts behind it
    assert np.abs(posture.displacements).max() < 1e-15
    points = scene_of(reference, 0.1)._contact_points
    assert points is not None
    assert points.offsets.max() < 1e-3


@pytest.mark.parametrize("friction", FRICTIONS)
def test_contacts_of_the_vowels(reference: Speaker, friction: float) -> None:
    """As section III.A.2 has it."""
    i, u, a = (vowel_of(reference, friction, vowel) for vowel in "iua")
    areas = {name: p.contact.touched_areas for name, p in zip("iua", (i, u, a), strict=True) if p.contact is not None}
    palate = touched(i, "hard_palate")
    assert on_both_sides(palate)
    assert np.abs(palate[:, 1]).min() > 0.009  # a groove: nothing near the midline
    assert palate[:, 0].min() < 0.075
    assert palate[:, 0].max() > 0.100
    assert areas["i"]["hard_palate"] > 1e-4
    assert (touched(i, "mandible")[:, 0] < 0.060).any()  # the apex behind the lower incisors
    assert areas["u"]["soft_palate"] > 0.8e-4
    assert areas["u"]["hard_palate"] > 0.4e-4
    assert on_both_sides(touched(u, "soft_palate"))
    assert areas["a"]["hard_palate"] == areas["a"]["soft_palate"] == 0.0
    lower = touched(a, "mandible")
    for side in (1.0, -1.0):
        border = lower[(side * lower[:, 1] > 0.004) & (lower[:, 2] > 0.085)]
        assert border[:, 0].min() < 0.068
        assert border[:, 0].max() > 0.100
    assert areas["a"]["mandible"] > 2e-4


@pytest.mark.parametrize("vowel", ["i", "a", "u"])
def test_penetration_between_the_points(reference: Speaker, vowel: str) -> None:
    surface = surface_penetration(vowel_of(reference, 0.1, vowel))
    depths = surface.depths[~surface.attached]
    assert len(depths) > 50_000
    assert 1e-4 < depths.max() < 6e-4  # 0.50 mm seen, at an edge
    assert (depths > 5e-5).mean() < 0.03


def test_geniohyoid_moves_the_hyoid_forward_and_down(reference: Speaker) -> None:
    scene = scene_of(reference, 0.1)
    before, after = scene.equilibrate().hyoid, scene.equilibrate({"GH": 0.75}).hyoid
    assert before is not None
    assert after is not None
    shift = 1e3 * (after.displacement - before.displacement)
    assert -6.0 < shift[0] < -2.0  # mm; 3.5 forward
    assert -2.0 < shift[2] < -0.4  # 0.83 down


def test_schwa_hardly_needs_walls(reference: Speaker) -> None:
    without = Scene(reference, contact=False, mirror=True).equilibrate(VOWELS["ə"])
    difference = (vowel_of(reference, 0.1, "ə").forces - without.forces).abs()
    assert difference.max() < 0.05  # N; 0.03 seen


# From elsewhere


@pytest.mark.parametrize("mirror", [True, False])
@pytest.mark.parametrize("friction", FRICTIONS)
def test_a_posture_is_its_own_equilibrium(reference: Speaker, friction: float, mirror: bool) -> None:
    vowel = "ə" if not mirror else "i"
    scene, posture = scene_of(reference, friction, mirror), vowel_of(reference, friction, vowel, mirror)
    for start in (posture, pickle.loads(pickle.dumps(posture))):
        again = scene.equilibrate(VOWELS[vowel], start=start)
        assert again.report is not None
        assert (again.report.iterations, again.report.quasi_newton, again.report.factorisations) == (0, 0, 0)
        assert largest(again.positions - posture.positions) < 1e-15
        assert again.contact is not None
        assert posture.contact is not None
        assert again.contact.pressures == pytest.approx(posture.contact.pressures, abs=1e-6)
        assert again.contact.drags == pytest.approx(posture.contact.drags, abs=1e-6)


def test_a_neighbour_is_near(reference: Speaker) -> None:
    """The same posture as from rest, for a third of its factorisations at most."""
    scene, start = scene_of(reference, 0.1), vowel_of(reference, 0.1, "i")
    commands = VOWELS["i"].scaled("GGp", 1.05)
    cold, warm = scene.equilibrate(commands), scene.equilibrate(commands, start=start)
    assert largest(warm.positions - cold.positions) < 1e-8
    assert cold.report is not None
    assert warm.report is not None
    assert 0 < 3 * warm.report.factorisations <= cold.report.factorisations


def test_starts_of_other_scenes(reference: Speaker) -> None:
    """Without walls, with other friction, of the whole body: what fits is taken, and the posture is the same."""
    here = vowel_of(reference, 0.1, "ə")
    others = [
        Scene(reference, contact=False, mirror=True).equilibrate(VOWELS["ə"]),
        vowel_of(reference, 0.0, "ə"),
        vowel_of(reference, 0.1, "ə", False),
    ]
    for other in others:
        found = scene_of(reference, 0.1).equilibrate(VOWELS["ə"], start=other)
        assert largest(found.positions - here.positions) < 1e-7


# Walls out of reach


@cache
def far_walls(speaker: Speaker) -> Speaker:
    """A metre above."""
    away = np.array([0.0, 0.0, 1.0])
    walls = {name: Wall(wall.vertices + away, wall.faces) for name, wall in speaker.walls.items()}
    return Speaker(
        speaker.nodes,
        speaker.hexahedra,
        muscles=dict(speaker.muscles),
        node_sets=dict(speaker.node_sets),
        contours=dict(speaker.contours),
        walls=walls,
        contact_faces=dict(speaker.contact_faces),
        hyoid=speaker.hyoid,
        name="walls out of reach",
    )


def test_walls_out_of_reach_change_nothing(reference: Speaker) -> None:
    far, none = (
        Scene(far_walls(reference), mirror=True),
        Scene(reference, contact=False, mirror=True),
    )
    for vowel in ("i", "ə"):
        with_walls, without = far.equilibrate(VOWELS[vowel]), none.equilibrate(VOWELS[vowel])
        assert largest(with_walls.positions - without.positions) < 1e-8  # other order of elimination
        first, second = with_walls.report, without.report
        assert first is not None
        assert second is not None
        assert (first.iterations, first.factorisations) == (second.iterations, second.factorisations)
        assert first.contact_updates == 0
    moved, free = (scene.simulate(Ramp(VOWELS["i"]), 0.04, dt=0.002, integrator="BDF2") for scene in (far, none))
    assert largest(moved.positions - free.positions) < 1e-8
    assert moved.report.factorisations == free.report.factorisations
    assert moved.report.residuals == free.report.residuals


def test_walls_out_of_reach_cost_next_to_nothing(reference: Speaker) -> None:
    """Work of a factorisation, the largest part of every solve."""
    work = []
    for scene in (Scene(far_walls(reference), mirror=True), Scene(reference, contact=False, mirror=True)):
        pieces = _core.Pieces(scene._solver, scene._fractions(None))
        pieces.force(scene._body.nodes)
        pieces.assemble()
        assert pieces.factorise()
        work.append(pieces.factor_flops)
    assert work[0] < 1.1 * work[1]


# Movements


@pytest.mark.parametrize("vowel", ["i", "u"])
def test_movement_with_everything(reference: Speaker, vowel: str) -> None:
    scene = scene_of(reference, 0.1)
    start = scene.equilibrate(REFLEX_ONLY)
    movement = scene.simulate(Ramp(VOWELS[vowel]), 0.2, dt=0.002, initial=start, integrator="BDF2")
    assert movement.report.penetration < 5e-5
    assert np.linalg.norm(movement.velocities, axis=2).max() < 1.0  # m/s
    end = vowel_of(reference, 0.1, vowel)
    assert np.abs(movement.forces.iloc[-1].to_numpy() - end.forces.to_numpy()).max() < 1.5


@pytest.mark.slow
@pytest.mark.parametrize("friction", FRICTIONS)
def test_adaptive_movement(reference: Speaker, friction: float) -> None:
    """The call of the README, with the defaults of scene and solver."""
    movement = scene_of(reference, friction).simulate(Ramp(VOWELS["i"], duration=0.030), until=0.200)
    assert movement.report.rescued <= 5
    assert np.linalg.norm(movement.velocities, axis=2).max() < 1.0  # m/s


@pytest.mark.slow
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("vowel", ["i", "a", "u"])
def test_an_equilibrium_stays(reference: Speaker, vowel: str, friction: float) -> None:
    scene, held = scene_of(reference, friction), vowel_of(reference, friction, vowel)
    movement = scene.simulate(VOWELS[vowel], 0.02, dt=0.001, initial=held)
    assert largest(movement.positions - held.positions) < (5e-6 if friction else 1e-10)  # bounds of friction: 1 %
