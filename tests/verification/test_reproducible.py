"""The same question has the same answer, bit by bit, whatever was asked before."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, block, furnished, hyoid_block, plate
from tests.verification.test_threads import bits, movement_bits

from glossa import VOWELS, MotorCommands, Movement, Ramp, Scene, Speaker


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True)


def test_equilibrium_again(reference: Speaker, scene: Scene) -> None:
    first = scene.equilibrate(VOWELS["a"])
    for vowel in "iuə":
        scene.equilibrate(VOWELS[vowel])
    scene.equilibrate({"GGp": 0.8})
    assert bits(scene.equilibrate(VOWELS["a"])) == bits(first)
    assert bits(Scene(reference, mirror=True).equilibrate(VOWELS["a"])) == bits(first)


def test_movement_again(reference: Speaker, scene: Scene) -> None:
    schedule = Ramp(VOWELS["a"])
    first = scene.simulate(schedule, 0.05)
    scene.equilibrate(VOWELS["i"])
    assert movement_bits(scene.simulate(schedule, 0.05)) == movement_bits(first)
    assert movement_bits(Scene(reference, mirror=True).simulate(schedule, 0.05)) == movement_bits(first)


def side_by_side(scene: Scene, *, disturb: bool) -> tuple[FloatArray, FloatArray]:
    """Positions after 40 ms in 5 ms steps, with and without other solves of the same muscles between the steps."""
    schedule = Ramp(VOWELS["u"])
    alone = scene.start(schedule, dt=0.005)
    for _ in range(8):
        alone.step(0.005)
    other = scene.start(schedule, dt=0.005)
    for _ in range(8):
        if disturb:
            scene.equilibrate(VOWELS["i"])
            scene.simulate(VOWELS["u"], 0.005, dt=0.005)
        other.step(0.005)
    assert np.abs(alone.positions - scene.speaker.nodes).max() > 1e-3
    assert alone.time == other.time == pytest.approx(0.040, abs=1e-9)
    return alone.positions, other.positions


def test_two_movements_in_one_scene(scene: Scene) -> None:
    a, b = side_by_side(scene, disturb=False)
    assert a.tobytes() == b.tobytes()


def test_another_solve_in_between(scene: Scene) -> None:
    a, b = side_by_side(scene, disturb=True)
    assert a == pytest.approx(b, abs=1e-7)  # stages are solved to 2e-6 of the force scale


def test_another_solve_in_between_keeps_the_bits(scene: Scene) -> None:
    a, b = side_by_side(scene, disturb=True)
    assert a.tobytes() == b.tobytes()


OPTIONS: list[dict[str, Any]] = [{"dt": 0.002}, {}, {"dt": 0.004, "integrator": "BDF2"}]


def go_back(scene: Scene, options: dict[str, Any]) -> list[Movement]:
    """The movement from 20 to 50 ms three times: going on, and twice from the state at 20 ms."""
    simulation = scene.start(Ramp(VOWELS["u"]), **options)
    simulation.run(0.02)
    state = simulation.state
    movements = [simulation.run(0.05)]
    for _ in range(2):
        simulation.state = state
        assert simulation.time == pytest.approx(0.02, abs=1e-9)
        movements.append(simulation.run(0.05))
    assert np.abs(movements[0].positions[-1] - movements[0].positions[0]).max() > 1e-3
    return movements


@pytest.mark.parametrize("options", OPTIONS)
def test_going_back(scene: Scene, options: dict[str, Any]) -> None:
    there, again, _ = go_back(scene, options)
    # Stages are solved to 2e-6 of the force scale; adaptive steps err by 5 micrometres each.
    tolerance = 1e-6 if "dt" in options else 5e-5
    assert again.positions[-1] == pytest.approx(there.positions[-1], abs=tolerance)


@pytest.mark.parametrize("options", OPTIONS[:2])
def test_going_back_keeps_the_bits(scene: Scene, options: dict[str, Any]) -> None:
    there, again, once_more = (movement_bits(movement) for movement in go_back(scene, options))
    assert again == there
    assert once_more == there


def test_states_travel_between_simulations(scene: Scene) -> None:
    schedule = Ramp(VOWELS["u"])
    first, second = scene.start(schedule, dt=0.005), scene.start(schedule, dt=0.005)
    first.run(0.02)
    second.state = first.state
    first.state = second.state
    assert second.run(0.04).positions[-1] == pytest.approx(first.run(0.04).positions[-1], abs=1e-6)


# With contact, friction and a mobile hyoid

LIFT = MotorCommands({"upper": 0.85})


@pytest.fixture(scope="module")
def touching() -> Scene:
    body = hyoid_block(muscles={"upper": 3.0}, between_walls=True)
    return Scene(body, fixed=["right"], tissue=PASSIVE, friction=0.2)


def test_equilibrium_with_contact_again(touching: Scene) -> None:
    raised: dict[str, Any] = {"loads": {"top": (0.0, 0.0, 1.0)}, "prescribed": {"wall:roof": (0.0, 0.0, -0.0002)}}
    first = touching.equilibrate(LIFT, **raised)
    assert first.contact is not None
    assert first.contact.drags.any()
    touching.equilibrate(LIFT, prescribed={"wall:roof": (0.0, 0.0, -0.002)})
    touching.simulate(Ramp(LIFT), 0.02, dt=0.004)
    again = touching.equilibrate(LIFT, **raised)
    assert bits(again) == bits(first)
    assert again.contact is not None
    assert np.array_equal(again.contact.pressures, first.contact.pressures)


@pytest.mark.parametrize("options", OPTIONS[:2])
def test_going_back_with_contact(touching: Scene, options: dict[str, Any]) -> None:
    simulation = touching.start(Ramp(LIFT), **options)
    simulation.run(0.02)
    state = simulation.state
    there = simulation.run(0.05)
    assert there.contact is not None
    assert there.contact.drags.any()
    for _ in range(2):
        simulation.state = state
        again = simulation.run(0.05)
        assert movement_bits(again) == movement_bits(there)
        assert again.contact is not None
        assert np.array_equal(again.contact.drags, there.contact.drags)


def test_a_wall_moved_in_between() -> None:
    """Walls stand where they were built in a movement, whatever an equilibrium of the same scene does with them."""
    size = (0.04, 0.04, 0.03)
    roof = plate(size[2], (-0.015, -0.015), (0.055, 0.055), facing=-1)
    body = furnished(block((4, 4, 3), size), walls={"roof": roof})
    ends = []
    for disturbed in (False, True):
        scene = Scene(body, gravity=(0.0, 0.0, 5.0), fixed=["bottom"], tissue=PASSIVE)
        simulation = scene.start(None, dt=0.004)
        for _ in range(5):
            if disturbed:
                scene.equilibrate(prescribed={"wall:roof": (0.0, 0.0, -0.002)})
            simulation.step(0.004)
        ends.append((simulation.positions, simulation.potential_energy))
    assert ends[0][0].tobytes() == ends[1][0].tobytes()
    assert ends[0][1] == ends[1][1]
