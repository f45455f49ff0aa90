"""Meshes and loads that are hard on elements: flat ones, PB's worst, bodies without support, strong gravity."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.bodies import with_flat_element
from tests.hard.checks import asymmetry, farthest, sound

from glossa import MUSCLES, VOWELS, InputError, MotorCommands, Scene, Speaker
from glossa.anatomy.hexahedra import scaled_jacobians

THIN = (1e-1, 1e-2, 1e-4, 1e-6, 1e-7)


@pytest.mark.parametrize("thickness", THIN)
def test_a_nearly_flat_element(thickness: float) -> None:
    """Hard: one element is down to a ten-millionth as thick as its neighbours and its stiffness as many times larger.
    Right: no more iterations, and a shape with a limit. (At a hundred-millionth rounding exceeds the tolerance.)"""
    regular = block((6, 4, 4), muscles={"upper": 6.0})
    posture = Scene(with_flat_element(regular, thickness), fixed=["left"]).equilibrate({"upper": 0.5})
    assert sound(posture).iterations <= 15  # 4 seen
    limit = Scene(with_flat_element(regular, 1e-6), fixed=["left"]).equilibrate({"upper": 0.5})
    assert farthest(posture.node_set("right"), limit.node_set("right")) < 3e-3 * thickness + 1e-8  # 1e-3 to 2e-3 seen


def test_a_flat_element_moves() -> None:
    """Hard: mass and stiffness of the element differ from its neighbours' by six powers of ten. Right: the movement of
    the regular block, but for what the coarser neighbours change."""
    regular = block((6, 4, 4), muscles={"upper": 6.0})
    commands = MotorCommands({"upper": 0.7})
    ends = []
    for body in (regular, with_flat_element(regular, 1e-6)):
        movement = Scene(body, fixed=["left"]).simulate(commands, 0.05, accuracy="draft")
        assert movement.report.converged
        assert movement.report.rescued == 0
        ends.append(movement.positions[-1, body.node_sets["right"]])
    assert farthest(ends[0], ends[1]) < 5e-4


def test_an_inverted_element_is_refused() -> None:
    with pytest.raises(InputError, match="hexahedron"):
        with_flat_element(block((6, 4, 4)), -0.1)


def test_worst_elements_of_pb(pb: Speaker) -> None:
    """Hard: 104 of PB's hexahedra have a scaled Jacobian below 0.2, the worst 0.007. Right: every vowel converges, and
    the worst elements stay uninverted."""
    quality = scaled_jacobians(pb.nodes, pb.hexahedra)
    assert quality.min() == pytest.approx(0.0073, abs=1e-4)
    scene = Scene(pb, mirror=True)
    for vowel in ("i", "a"):
        posture = scene.equilibrate(VOWELS[vowel])
        sound(posture)
        assert scaled_jacobians(posture.positions, pb.hexahedra)[np.argsort(quality)[:20]].min() > -0.5


@pytest.mark.slow
@pytest.mark.parametrize("muscle", MUSCLES)
def test_worst_elements_of_pb_under_single_muscles(pb: Speaker, muscle: str) -> None:
    """Hard: one muscle shortens to 0.4 without antagonists through elements that are nearly flat."""
    sound(Scene(pb, mirror=True).equilibrate({muscle: 0.4}))


# Support

FREE = [([], 6), (["corner"], 3), (["edge"], 1)]


@pytest.mark.parametrize(("fixed", "motions"), FREE)
def test_a_body_without_support_is_refused(fixed: list[str], motions: int) -> None:
    """Hard: a singular matrix, which rounding may hide. Right: a clear error before anything is solved."""
    number = np.arange(7 * 5 * 5).reshape(7, 5, 5)
    sets = {"corner": [int(number[0, 0, 0])], "edge": number[0, 0].tolist()}
    body = block((6, 4, 4), muscles={"upper": 6.0}, sets=sets)
    scene = Scene(body, fixed=fixed)
    with pytest.raises(InputError, match=rf"free to move rigidly \({motions} of 6 rigid motions\)"):
        scene.equilibrate({"upper": 0.9})


def test_a_body_without_support_falls() -> None:
    """Hard: no static stiffness against falling. Right: in a movement that is no fault; it falls as Galilei says."""
    movement = Scene(block((2, 2, 2)), fixed=[], damping=None).simulate(None, 0.1, dt=1e-3)
    assert movement.report.converged
    fallen = movement.positions[-1] - movement.positions[0]
    assert fallen == pytest.approx(np.tile([0.0, 0.0, -0.5 * 9.81 * 0.1**2], (len(fallen), 1)), abs=1e-9)


def test_a_body_held_at_three_points_is_solved() -> None:
    """Hard: the least support there is; a third of the block's weight on earth passes through three nodes and shears
    the elements there. Right: solved, reactions balance."""
    number = np.arange(7 * 5 * 5).reshape(7, 5, 5)
    three = [int(number[0, 0, 0]), int(number[0, -1, 0]), int(number[-1, 2, 0])]
    body = block((6, 4, 4), sets={"three": three})
    posture = Scene(body, fixed=["three"], gravity=(0.0, 0.0, -3.0)).equilibrate()
    sound(posture)
    assert np.abs(posture.reactions("three")[:2]).max() < 1e-6
    assert posture.reactions("three")[2] == pytest.approx(0.06 * 0.04 * 0.04 * 1040.0 * 3.0, rel=1e-6)


# Gravity

DIRECTIONS = {
    "down": (0.0, 0.0, -98.1),
    "up": (0.0, 0.0, 98.1),
    "sideways": (0.0, 98.1, 0.0),
    "back": (98.1, 0.0, 0.0),
    "askew": (-50.0, 60.0, -59.4),
}


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_ten_times_gravity_on_a_block(direction: str) -> None:
    """Hard: the block, a cantilever, falls through half a turn. Right: solved from rest; reactions carry the weight."""
    gravity = DIRECTIONS[direction]
    posture = Scene(block((6, 4, 4)), fixed=["left"], gravity=gravity).equilibrate()
    sound(posture)
    weight = 0.06 * 0.04 * 0.04 * 1040.0 * np.asarray(gravity)
    assert posture.reactions("left") == pytest.approx(-weight, abs=1e-6)


def test_gravity_sideways_on_a_tongue(reference: Speaker) -> None:
    """Hard: nothing of the scene is symmetric any more. Right: the whole tongue leans to that side, and a scene that
    was asked to mirror refuses."""
    posture = Scene(reference, gravity=(0.0, 9.81, 0.0)).equilibrate()
    sound(posture)
    assert posture.displacements[:, 1].mean() > 1e-4
    assert asymmetry(reference, posture.positions) > 1e-3
    with pytest.raises(InputError, match="gravity in the midsagittal plane"):
        Scene(reference, gravity=(0.0, 9.81, 0.0), mirror=True)


@pytest.mark.slow
@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("vowel", [None, "i"])
def test_ten_times_gravity_on_a_tongue(reference: Speaker, direction: str, vowel: str | None) -> None:
    """Hard: the tongue, silent or in /i/, is thrown against teeth, velum or palate by ten times its weight."""
    scene = Scene(reference, gravity=DIRECTIONS[direction])
    sound(scene.equilibrate(None if vowel is None else VOWELS[vowel]))
