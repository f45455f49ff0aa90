"""How deep the surface lies in walls between contact points, and what denser points do about it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.bodies import over_floor, over_tooth
from tests.speaker_contact import scene_of, vowel_of

from glossa import VOWELS, InputError, Movement, Posture, Ramp, Scene, Speaker
from glossa.studies import rest_posture
from glossa.surface_penetration import surface_penetration
from glossa.tolerances import Tolerances

CLEARANCE = 0.0005
EDGE = 0.0413
"""Where the edge of a wedge runs: not on a line of contact points, nor on one of samples."""
AIM = 5e-5
"""Depth that no place should exceed, m."""


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((6, 4, 4))


def lowered(scene: Scene, depth: float) -> Posture:
    """The scene's body at rest but for its free part, which has sunk by ``depth`` below the top of its wall."""
    posture = scene.equilibrate()
    nodes = scene.speaker.nodes
    down = np.where(nodes[:, :1] > 0.0, [[0.0, 0.0, -CLEARANCE - depth]], 0.0)
    points = scene._contact_points
    assert points is not None
    empty = np.zeros(len(points.wall))
    contact = points.contact(nodes + down, empty, np.zeros((len(empty), 3)), {})
    return replace(posture, positions=nodes + down, contact=contact)


# Known depths


def test_depth_in_a_plane_is_how_far_it_has_sunk(body: Speaker) -> None:
    """The first cells are sheared; all others lie flat, at their points and between them."""
    found = surface_penetration(lowered(Scene(over_floor(body, CLEARANCE), fixed=["left"]), 7e-4))
    assert found.deepest == pytest.approx(7e-4, abs=1e-6)
    table = found.by_wall.loc["floor"]
    assert table["points"] == pytest.approx(7e-4, abs=1e-6)
    under = (found.points[:, 2] < -CLEARANCE) & (found.points[:, 0] > 0.011)
    assert under.sum() > 1000
    assert found.depths[under & (found.points[:, 2] < -CLEARANCE - 6e-4)] == pytest.approx(7e-4, abs=1e-6)


@pytest.mark.parametrize("angle", [120.0, 60.0, 30.0])
def test_depth_of_an_edge_converges_to_what_it_is(body: Speaker, angle: float) -> None:
    """An edge of the angle a, sunk by s, is s sin(a/2) deep; samples h apart miss it by h/2 cos(a/2) at most."""
    half = 0.5 * np.radians(angle)
    posture = lowered(Scene(over_tooth(body, angle, x=EDGE, clearance=CLEARANCE), fixed=["left"]), 1.5e-3)
    exact = 1.5e-3 * np.sin(half)
    for samples in (2e-3, 1e-3, 5e-4, 2.5e-4):
        found = surface_penetration(posture, samples=samples).deepest
        assert exact - 0.5 * samples * np.cos(half) - 1e-9 < found < exact + 1e-9


def test_wall_is_where_the_posture_has_it(body: Speaker) -> None:
    """A wall that has sunk with the tongue is not entered; one that has risen is entered by as much."""
    posture = lowered(Scene(over_floor(body, CLEARANCE), fixed=["left"]), 7e-4)
    for rise in (-7e-4, -2e-4, 3e-4):
        shifted = replace(posture, wall_displacements={"floor": np.array([0.0, 0.0, rise])})
        assert surface_penetration(shifted).by_wall.loc["floor", "surface"] == pytest.approx(7e-4 + rise, abs=1e-6)


def test_nothing_is_entered_at_rest(pb: Speaker) -> None:
    """PB's rest state overlaps its walls by up to 1 mm; that is left out."""
    found = surface_penetration(Scene(pb, gravity=None).equilibrate())
    assert found.by_wall.to_numpy().max() < 1e-12
    assert (found.depths >= 0.0).all()


# Vowels


def test_vowel_between_its_points(reference: Speaker) -> None:
    posture = vowel_of(reference, 0.1, "i")
    found = [surface_penetration(posture, samples=samples) for samples in (1e-3, 5e-4)]
    assert posture.contact is not None
    for one in found:
        assert one.by_wall["points"].max() == pytest.approx(posture.contact.penetration, abs=1e-12)
        assert one.by_wall["points"].max() < AIM < 4e-4 < one.deepest < 6e-4
    assert len(found[1].depths) > 3 * len(found[0].depths)
    assert found[1].deepest == pytest.approx(found[0].deepest, abs=5e-5)
    left, right = (found[0].depths[found[0].points[:, 1] * side > 0.0].max() for side in (1.0, -1.0))
    assert left == pytest.approx(right, abs=1e-6)


def test_denser_points_keep_a_vowel_out_of_its_walls(reference: Speaker) -> None:
    """0.50, 0.20 and 0.06 mm for points 2.5, 1.25 and 0.625 mm apart; the last ones meet the aim with 0.02 mm in place
    of 0.05 as the tolerance of their own."""
    depths = [surface_penetration(vowel_of(reference, 0.1, "i")).deepest]
    for spacing, gap in ((1.25e-3, AIM), (0.625e-3, AIM), (0.625e-3, 2e-5)):
        scene = Scene(reference, mirror=True, contact_spacing=spacing)
        posture = scene.equilibrate(VOWELS["i"], accuracy=Tolerances(residual=1e-8, gap=gap))
        depths.append(surface_penetration(posture).deepest)
        assert depths[-1] < 0.8 * depths[-2]
    assert depths[-2] < 1e-4
    assert depths[-1] < AIM


@pytest.mark.parametrize(("angle", "coarse"), [(120.0, 2e-4), (60.0, 6e-4), (30.0, 8e-4)])
def test_denser_points_keep_an_edge_out(body: Speaker, angle: float, coarse: float) -> None:
    speaker = over_tooth(body, angle, x=0.04, clearance=CLEARANCE)
    depths = []
    for spacing in (2.5e-3, 1.25e-3, 0.625e-3):
        scene = Scene(speaker, fixed=["left"], contact_spacing=spacing)
        posture = scene.equilibrate(loads={"right": (0.0, 0.0, -0.3)})
        depths.append(surface_penetration(posture, samples=2.5e-4).deepest)
    assert depths[0] > coarse
    assert depths[1] < 0.5 * depths[0]
    assert depths[2] < 0.6 * depths[1]


# Where it comes from, and what is refused


def test_files_and_moments_of_movements(reference: Speaker, tmp_path: Path) -> None:
    posture = vowel_of(reference, 0.1, "i")
    scene = Scene(reference, mirror=True, contact_spacing=1.5e-3)
    dense = scene.equilibrate(VOWELS["i"], start=posture, accuracy="draft")
    dense.save(tmp_path / "i.nc")
    again = Posture.load(tmp_path / "i.nc", reference)
    assert again.contact is not None
    assert again.contact.spacing == 1.5e-3
    expected = surface_penetration(dense).by_wall
    assert (surface_penetration(again).by_wall == expected).all(axis=None)
    movement = scene.simulate(Ramp(VOWELS["i"]), 0.004, accuracy="draft", initial=dense)
    assert (surface_penetration(movement.at(0.0)).by_wall == expected).all(axis=None)
    movement.save(tmp_path / "movement.nc")
    read = Movement.load(tmp_path / "movement.nc", reference)
    assert surface_penetration(read.at(0.004)).deepest == surface_penetration(movement.at(0.004)).deepest


def test_impossible_requests(reference: Speaker) -> None:
    with pytest.raises(InputError, match="needs a posture with contact"):
        surface_penetration(rest_posture(reference))
    with pytest.raises(InputError, match=r"at least 0\.00025 m"):
        surface_penetration(vowel_of(reference, 0.1, "i"), samples=1e-5)
    for wrong in (1e-4, 3e-3, float("nan"), "fine"):
        with pytest.raises(InputError, match="contact spacing"):
            Scene(reference, contact_spacing=wrong)  # type: ignore[arg-type]
    assert scene_of(reference, 0.1).contact_spacing == 2.5e-3
