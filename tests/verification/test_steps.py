"""Which time steps are taken: corners, echoes, the delay, adaptive steps, and where movements end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import FloatArray, block

from glossa import VOWELS, Damping, InputError, MotorCommands, Movement, Ramp, Reflex, Scene, Schedule, Speaker

COMMANDS = MotorCommands({"upper": 0.9})


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((4, 2, 2), muscles={"upper": 2.0})


@pytest.fixture(scope="module")
def scene(body: Speaker) -> Scene:
    return Scene(body, fixed=["left"])


def has_steps_at(movement: Movement, times: list[float]) -> bool:
    return bool(np.isclose(movement.times[:, None], times, rtol=0, atol=1e-9).any(axis=0).all())


def gap(a: FloatArray, b: FloatArray) -> float:
    return float(np.abs(a - b).max())


@pytest.mark.parametrize("options", [{}, {"dt": 0.007}, {"dt": 0.007, "integrator": "BDF2"}])
def test_corners_and_echoes_are_step_ends(scene: Scene, options: dict[str, Any]) -> None:
    schedule = Schedule.through([(0.005, COMMANDS), (0.0512, MotorCommands({"upper": 1.1}))], transition=0.0137)
    movement = scene.simulate(schedule, 0.09, **options)
    corners = [0.005, 0.0187, 0.0512, 0.0649]
    assert schedule.corners == pytest.approx(corners)
    assert has_steps_at(movement, [*corners, *(t + 0.017 for t in corners), 0.09])
    assert movement.times[0] == 0.0
    assert movement.times[-1] == pytest.approx(0.09, abs=1e-9)
    assert (np.diff(movement.times) > 1e-5).all()


def test_fixed_steps_divide_intervals_equally(scene: Scene) -> None:
    movement = scene.simulate(Ramp(COMMANDS), 0.04, dt=0.004)
    steps = np.diff(movement.times)
    assert steps.max() <= 0.004 + 1e-12
    # 0 .. 17 .. 30 .. 34 .. 40 ms
    assert steps == pytest.approx([0.0034] * 5 + [0.00325] * 4 + [0.004] + [0.003] * 2)
    bare = scene.simulate(None, 0.05, dt=0.007)
    assert np.diff(bare.times) == pytest.approx([0.00625] * 8)


@pytest.mark.parametrize("delay", [0.017, 0.004])
def test_steps_longer_than_the_delay_are_divided(body: Speaker, delay: float) -> None:
    scene = Scene(body, fixed=["left"], reflex=Reflex(delay=delay))
    movement = scene.simulate(Ramp(COMMANDS), 0.06, dt=0.05)
    assert np.diff(movement.times).max() <= delay / 1.5 + 1e-12
    simulation = scene.start(Ramp(COMMANDS), dt=0.05)
    assert simulation.step(0.06) == pytest.approx(0.06, abs=1e-9)
    assert simulation.positions == pytest.approx(movement.positions[-1], abs=1e-12)


def test_stepping_is_running(scene: Scene) -> None:
    """Steps from Python whose sums are corners only up to rounding (0.005 six times and 0.03)."""
    movement = scene.simulate(Ramp(COMMANDS), 0.06, dt=0.0025)
    simulation = scene.start(Ramp(COMMANDS), dt=0.0025)
    for _ in range(12):
        simulation.step(0.005)
    assert simulation.report.rescued == 0
    assert simulation.time == pytest.approx(0.06, abs=1e-9)
    # Other divisions of the same intervals: both within their time error.
    assert gap(simulation.positions, movement.positions[-1]) < 2e-6
    assert gap(simulation.positions, movement.positions[0]) > 1e-4


def test_accuracy_is_honoured(scene: Scene) -> None:
    schedule = Ramp(COMMANDS, duration=0.010)
    exact = scene.simulate(schedule, 0.1, dt=0.0002, accuracy="reference")
    tolerances, errors, steps = (1e-5, 1e-6, 1e-7), [], []
    for tolerance in tolerances:
        movement = scene.simulate(schedule, 0.1, accuracy=tolerance)
        frames = zip(movement.times, movement.positions, strict=True)
        errors.append(max(gap(frame, exact.at(time).positions) for time, frame in frames))
        steps.append(movement.report.steps)
        assert movement.report.error_estimate <= 1.5 * tolerance
        assert movement.report.steps == len(movement.times) - 1
    assert steps == sorted(steps)
    assert steps[-1] > 2 * steps[0]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.2 * errors[0]  # 0.07 seen
    # Local errors add up over the steps, and are damped.
    assert all(error < 10 * tolerance for error, tolerance in zip(errors, tolerances, strict=True))


def test_accuracy_names_are_ordered(scene: Scene) -> None:
    counts = [scene.simulate(Ramp(COMMANDS), 0.06, accuracy=a).report.steps for a in ("draft", "standard", "reference")]
    assert counts[0] < counts[1] < counts[2]


def test_jumps(scene: Scene) -> None:
    """A jump is the limit of steep ramps."""
    rest = MotorCommands({"upper": 1.0})
    jump = Schedule([0.0, 0.020, 0.020, 0.1], [rest, rest, COMMANDS, COMMANDS])
    jumped = scene.simulate(jump, 0.06, dt=0.001)
    assert has_steps_at(jumped, [0.020, 0.037])
    assert jumped.forces["upper"].loc[:0.0199].max() < 0.5 * jumped.forces["upper"].max()
    at_once = scene.simulate(Ramp(COMMANDS, duration=0.0, onset=0.020), 0.06, dt=0.001)
    # The other schedule has a corner at 0 as well, whose echo divides the steps otherwise.
    assert gap(at_once.positions[-1], jumped.positions[-1]) < 1e-6
    gaps = []
    for duration in (0.008, 0.004, 0.002, 0.001):
        steep = scene.simulate(Ramp(COMMANDS, duration=duration, onset=0.020), 0.06, dt=0.001)
        gaps.append(gap(steep.at(0.06).positions, jumped.at(0.06).positions))
    assert gaps[0] > 1e-5
    assert gaps[3] < 0.2 * gaps[0]  # proportional to the duration
    assert gaps == sorted(gaps, reverse=True)


@pytest.mark.parametrize("options", [{}, {"dt": 0.004, "integrator": "BDF2"}, {"dt": 0.004}])
def test_jump_at_the_start(scene: Scene, options: dict[str, Any]) -> None:
    movement = scene.simulate(COMMANDS, 0.03, **options)
    ramped = scene.simulate(Ramp(COMMANDS, duration=0.0005), 0.03, dt=0.0005)
    assert gap(movement.positions[-1], ramped.positions[-1]) < 2e-4
    assert gap(movement.positions[-1], movement.positions[0]) > 1e-3


@pytest.mark.parametrize("reflex", [None, Reflex(delay=0.0), Reflex(), Reflex(delay=0.005, velocity_gain=0.0)])
@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2"])
def test_movements_end_in_the_equilibrium(body: Speaker, reflex: Reflex | None, integrator: str) -> None:
    damping = Damping(alpha=40.0, beta=0.003)  # settles ten times sooner than the paper's
    scene = Scene(body, fixed=["left"], reflex=reflex, damping=damping)
    end = scene.equilibrate(COMMANDS)
    movement = scene.simulate(Ramp(COMMANDS), 0.6, dt=0.005, integrator=integrator)
    assert gap(movement.positions[-1], movement.positions[0]) > 1e-3
    assert gap(movement.positions[-1], end.positions) < 1e-5
    assert movement.forces["upper"].iloc[-1] == pytest.approx(end.forces["upper"], abs=2e-3)
    assert movement.report.rescued == 0


def test_vowel_u_ends_in_its_equilibrium(pb: Speaker) -> None:
    """With a delay of 5 ms. At 17 ms, without contact, the loop through Sty keeps /u/ in a cycle (test_pb.py)."""
    scene = Scene(pb, mirror=True, contact=False, reflex=Reflex(delay=0.005))
    start = scene.equilibrate(dict.fromkeys(VOWELS["u"], 1.0))
    end = scene.equilibrate(VOWELS["u"], start=start)
    movement = scene.simulate(Ramp(VOWELS["u"]), 0.6, dt=0.005, initial=start)
    assert gap(end.positions, start.positions) > 5e-3
    assert gap(movement.positions[-1], end.positions) < 1e-5


def test_a_movement_goes_on(scene: Scene) -> None:
    whole = scene.simulate(Ramp(COMMANDS), 0.034, dt=0.001)
    simulation = scene.start(Ramp(COMMANDS), dt=0.001)
    first, second = simulation.run(0.017), simulation.run(0.034)
    assert first.times[-1] == second.times[0]
    assert np.array_equal(first.positions[-1], second.positions[0])
    assert np.array_equal(second.positions[-1], whole.positions[-1])
    with pytest.raises(InputError, match="the end must lie after the present time"):
        simulation.run(0.034)


@pytest.fixture(scope="module")
def tongue() -> Scene:
    return Scene(Speaker.reference(), mirror=True)


@pytest.fixture(scope="module")
def exact(tongue: Scene) -> Movement:
    return tongue.simulate(Ramp(VOWELS["u"]), 0.06, dt=0.00025, integrator="SDIRK2")


@pytest.mark.parametrize("accuracy", ["draft", "standard"])
@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2"])
def test_movements_state_their_error(tongue: Scene, exact: Movement, integrator: str, accuracy: str) -> None:
    """With walls and hyoid: the largest error at any node and frame is what the report says, within a factor."""
    movement = tongue.simulate(Ramp(VOWELS["u"]), 0.06, accuracy=accuracy, integrator=integrator)
    frames = zip(movement.times, movement.positions, strict=True)
    error = max(gap(frame, exact.at(float(time)).positions) for time, frame in frames)
    assert error < 2.0 * movement.report.accumulated_error < 10.0 * error
