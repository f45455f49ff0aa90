"""Second order in time, through the corners of the commands and their echoes after the reflex delay."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import FloatArray, block

from glossa import MotorCommands, Movement, Ramp, Reflex, Scene, Speaker

UNTIL = 0.1


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((4, 2, 2), muscles={"axial": 3.0})


def run(body: Speaker, delay: float, dt: float, integrator: str) -> Movement:
    scene = Scene(body, fixed=["left"], reflex=Reflex(delay=delay))
    schedule = Ramp(MotorCommands({"axial": 0.8}))
    return scene.simulate(schedule, UNTIL, dt=dt, integrator=integrator, accuracy="reference")


def error(movement: Movement, exact: Movement, times: FloatArray) -> float:
    """Largest difference of any node at times at which both have a step, mm."""
    assert np.isclose(movement.times[:, None], times, rtol=0, atol=1e-9).any(axis=0).all()
    gaps = [np.abs(movement.at(t).positions - exact.at(t).positions).max() for t in times]
    return 1e3 * float(max(gaps))


@pytest.mark.parametrize("delay", [0.017, 0.016, 0.0173])
def test_second_order(body: Speaker, delay: float) -> None:
    """A muscle that contracts at once under a ramp; 16 ms is a multiple of every step, 17 and 17.3 are not."""
    exact = run(body, delay, 0.000125, "SDIRK2")
    times = np.array([delay, 0.030, 0.030 + delay, 2 * delay, 0.030 + 2 * delay, UNTIL])
    assert exact.activations.max() > 0.01
    assert np.abs(exact.positions[-1] - exact.positions[0]).max() > 3e-3
    for integrator, longest in (("SDIRK2", 0.004), ("BDF2", 0.002)):
        runs = [run(body, delay, longest / parts, integrator) for parts in (1, 2, 4)]
        errors = [error(movement, exact, times) for movement in runs]
        steps = [len(movement.times) - 1 for movement in runs]  # intervals between corners are divided equally
        orders = np.log(np.divide(errors[:-1], errors[1:])) / np.log(np.divide(steps[1:], steps[:-1]))
        assert errors[0] > 1e-4
        assert orders[0] > 1.75  # 1.83 to 2.3 seen
        assert orders[1] > 1.9  # 1.95 to 2.15 seen from 2 to 1 ms


def test_backward_euler_is_first_order(body: Speaker) -> None:
    """So that the test above can fail."""
    exact = run(body, 0.017, 0.0005, "SDIRK2")
    times = np.array([0.030, UNTIL])
    coarse, fine = (error(run(body, 0.017, dt, "backward_euler"), exact, times) for dt in (0.004, 0.002))
    assert 0.6 < np.log2(coarse / fine) < 1.3
