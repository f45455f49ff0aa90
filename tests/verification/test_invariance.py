"""Objectivity: turned or shifted problems have turned or shifted solutions; a rigid motion costs no force."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, block, hyoid_block, wall_force

from glossa import Hyoid, MotorCommands, Ramp, Scene, Speaker, Spring, Wall

COMMANDS = MotorCommands({"upper": 0.8, "side": 1.02})
GRAVITY = np.array([1.0, -2.0, -9.0])


def rotation(axis: tuple[float, float, float], angle: float) -> FloatArray:
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)


TURN = rotation((1.0, 2.0, -0.5), 2.1)
SHIFT = np.array([0.3, -0.2, 0.1])


def moved(speaker: Speaker, turn: FloatArray, shift: FloatArray) -> Speaker:
    """The same body elsewhere."""
    sets = dict(speaker.node_sets)
    nodes = speaker.nodes @ turn.T + shift
    return Speaker(nodes, speaker.hexahedra, muscles=dict(speaker.muscles), node_sets=sets)


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((5, 3, 3), muscles={"upper": 3.0, "side": 2.0}, distortion=0.2)


@pytest.mark.parametrize(("turn", "shift"), [(TURN, SHIFT), (np.eye(3), SHIFT)])
def test_equilibrium_elsewhere(body: Speaker, turn: FloatArray, shift: FloatArray) -> None:
    here = Scene(body, fixed=["left"], gravity=GRAVITY.tolist())
    there = Scene(moved(body, turn, shift), fixed=["left"], gravity=(turn @ GRAVITY).tolist())
    a = here.equilibrate(COMMANDS, accuracy="reference")
    b = there.equilibrate(COMMANDS, accuracy="reference")
    assert np.abs(a.displacements).max() > 5e-3
    # Two solves to 1e-11 of the force scale, and rounding of positions of 0.4 m.
    assert b.positions == pytest.approx(a.positions @ turn.T + shift, abs=1e-10)
    assert b.forces.to_numpy() == pytest.approx(a.forces.to_numpy(), rel=1e-8)
    assert b.reactions("left") == pytest.approx(turn @ a.reactions("left"), abs=1e-8)
    assert b.stiffening == pytest.approx(np.asarray(a.stiffening), rel=1e-8)


def test_movement_elsewhere(body: Speaker) -> None:
    here = Scene(body, fixed=["left"], gravity=GRAVITY.tolist())
    there = Scene(moved(body, TURN, SHIFT), fixed=["left"], gravity=(TURN @ GRAVITY).tolist())
    a, b = (scene.simulate(Ramp(COMMANDS), 0.06, dt=0.004, accuracy="reference") for scene in (here, there))
    assert np.array_equal(a.times, b.times)
    assert np.abs(a.positions[-1] - a.positions[0]).max() > 2e-3
    # Stages are solved to 1e-9 of the force scale.
    assert b.positions == pytest.approx(a.positions @ TURN.T + SHIFT, abs=1e-8)
    assert b.velocities == pytest.approx(a.velocities @ TURN.T, abs=1e-6)


@pytest.mark.parametrize("fixed", [[], ["left"]])
@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
def test_rigid_motion_of_the_support(body: Speaker, element: str, fixed: list[str]) -> None:
    """A support turned by 29 degrees and shifted by half the body takes the body along, without stress."""
    scene = Scene(body, gravity=None, fixed=fixed, element=element)
    turn = rotation((0.2, 1.0, 0.3), 0.5)
    wanted = body.nodes @ turn.T + [0.03, 0.0, 0.0]
    held = body.node_sets["left"]
    posture = scene.equilibrate(prescribed={"left": (wanted - body.nodes)[held]}, accuracy="reference")
    assert posture.positions == pytest.approx(wanted, abs=1e-9)
    assert np.abs(posture.support_forces).max() < 1e-8  # type: ignore[arg-type]
    assert np.abs(posture.displacements).max() > 0.03


def test_rigid_rotation_in_steps(body: Speaker) -> None:
    """Larger rotations go through postures that start from one another."""
    scene = Scene(body, gravity=None, fixed=["left"])
    held, start = body.node_sets["left"], None
    for angle in np.linspace(0.0, np.pi, 8)[1:]:
        wanted = body.nodes @ rotation((0.2, 1.0, 0.3), angle).T
        start = scene.equilibrate(prescribed={"left": (wanted - body.nodes)[held]}, start=start, accuracy="reference")
        assert start.positions == pytest.approx(wanted, abs=1e-9)


def moved_with_surroundings(speaker: Speaker, turn: FloatArray, shift: FloatArray) -> Speaker:
    """The same body, walls and hyoid elsewhere."""
    place: Callable[[FloatArray], FloatArray] = lambda points: points @ turn.T + shift  # noqa: E731
    hyoid = speaker.hyoid
    assert hyoid is not None
    springs = [Spring(place(s.on_hyoid), place(s.fixed), s.stiffness, s.rest_length, s.name) for s in hyoid.springs]
    return Speaker(
        place(speaker.nodes),
        speaker.hexahedra,
        muscles=dict(speaker.muscles),
        node_sets=dict(speaker.node_sets),
        walls={name: Wall(place(wall.vertices), wall.faces) for name, wall in speaker.walls.items()},
        hyoid=Hyoid(None, hyoid.mass, place(hyoid.centre), tuple(springs)),
    )


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_contact_and_hyoid_elsewhere(friction: float) -> None:
    """Walls are splined on a lattice that does not turn with them: what differs is the error of the splines."""
    body = hyoid_block(muscles={"upper": 3.0}, between_walls=True)
    field = np.array([0.5, 0.0, -9.0])
    arguments: dict[str, Any] = {"commands": {"upper": 0.85}, "accuracy": "reference"}
    a, b = (
        Scene(speaker, fixed=["right"], tissue=PASSIVE, friction=friction, gravity=(turn @ field).tolist()).equilibrate(
            loads={"top": (turn @ [0.0, 0.0, 1.0]).tolist()}, **arguments
        )
        for speaker, turn in ((body, np.eye(3)), (moved_with_surroundings(body, TURN, SHIFT), TURN))
    )
    assert a.hyoid is not None
    assert b.hyoid is not None
    assert np.abs(a.displacements).max() > 1e-3
    assert np.abs(b.positions - (a.positions @ TURN.T + SHIFT)).max() < 20e-6
    force = wall_force(a, "roof")
    assert np.linalg.norm(force) > 0.2
    assert wall_force(b, "roof") == pytest.approx(TURN @ force, abs=0.01 * float(np.linalg.norm(force)))
    assert b.hyoid.displacement == pytest.approx(TURN @ a.hyoid.displacement, abs=5e-6)
    assert b.hyoid.rotation == pytest.approx(TURN @ a.hyoid.rotation, abs=1e-3)
    assert np.linalg.norm(a.hyoid.rotation) > 0.05
