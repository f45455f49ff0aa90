"""Movements in very short and very long steps, for seconds, and back to where they came from."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.bodies import over_floor
from tests.hard.checks import farthest, moved

from glossa import VOWELS, MotorCommands, Movement, Ramp, Scene, Schedule, Speaker

FASTEST = 0.5
"""Speed in m/s that no node reaches in these movements."""

SETTLED = 0.1
"""The same half a second after the commands have come to rest: 0.01 to 0.08 seen, where the reflex oscillates."""

STEPS = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2)


def test_steps_from_a_tenth_of_a_millisecond_to_twenty() -> None:
    """Hard: 20 ms are longer than the reflex delay and than the movement's fastest part; the commands jump. Right: all
    converge, on the same movement, within 0.01 mm, and shorter steps come nearer."""
    scene = Scene(block((6, 4, 4), muscles={"upper": 6.0, "lower": 6.0}), fixed=["left"])
    commands = MotorCommands({"upper": 0.5, "lower": 1.2})
    ends = {}
    for step in STEPS:
        movement = scene.simulate(commands, 0.03, dt=step)
        moved(movement, fastest=FASTEST)
        ends[step] = movement.positions[-1]
    errors = [farthest(ends[step], ends[STEPS[0]]) for step in STEPS[1:]]
    assert errors[-1] < 2e-5  # 0.008 mm seen
    assert all(fine <= coarse for fine, coarse in pairwise(errors))
    assert errors[0] < errors[-1] / 30.0  # 70 seen


@pytest.mark.slow
@pytest.mark.parametrize("vowel", ["i", "a", "u"])
@pytest.mark.parametrize("step", [1e-4, 1e-3, 5e-3, 2e-2])
def test_steps_of_vowels(reference: Speaker, vowel: str, step: float) -> None:
    """Hard: the same with teeth and palate, at steps that take the tongue into contact at once. Right: no step fails
    for good, no node is faster than in short steps."""
    movement = Scene(reference, mirror=True).simulate(Ramp(VOWELS[vowel]), 0.06, dt=step)
    moved(movement, fastest=FASTEST)


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", ["draft", "standard"])
@pytest.mark.parametrize("vowel", ["i", "a", "u"])
def test_two_seconds(reference: Speaker, vowel: str, accuracy: str) -> None:
    """Hard: errors have sixty relaxation times to add up, and the reflex loop, at the border of its stability, to
    build up; in steps of 10 ms what is left of a residual becomes the next step's momentum. Right: no node jumps, and
    the last half second oscillates no more than the one before, within two millimetres."""
    movement = Scene(reference, mirror=True).simulate(Ramp(VOWELS[vowel]), 2.0, accuracy=accuracy)
    moved(movement, fastest=FASTEST)
    settled = movement.times > 0.5
    assert np.linalg.norm(movement.velocities[settled], axis=2).max() < SETTLED
    earlier, last = (swing(movement, begin) for begin in (1.0, 1.5))
    assert last < 1.5 * earlier + 5e-5
    assert last < 2e-3


def swing(movement: Movement, begin: float) -> float:
    """m, farthest that a node moves from its mean within half a second."""
    inside = (movement.times >= begin) & (movement.times <= begin + 0.5)
    frames = movement.positions[inside]
    return float(np.linalg.norm(frames - frames.mean(axis=0), axis=2).max())


# Back to the same place


def returns(scene: Scene, cycle: list[MotorCommands], times: int, hold: float) -> np.ndarray:
    """(times,) m, how far the first target of each cycle is from where the first cycle reached it."""
    targets = [(hold * k, cycle[k % len(cycle)]) for k in range(times * len(cycle) + 1)]
    movement = scene.simulate(Schedule.through(targets, transition=0.03), hold * len(targets), accuracy="draft")
    moved(movement, fastest=FASTEST)
    ends = [movement.at(hold * (k * len(cycle) + 1)).positions for k in range(times + 1)]
    return np.array([farthest(end, ends[0]) for end in ends[1:]])


def rubbed(friction: float) -> np.ndarray:
    body = over_floor(block((6, 4, 4), muscles={"upper": 6.0, "lower": 6.0}), 2e-4)
    scene = Scene(body, fixed=["left"], friction=friction, gravity=(0.0, 0.0, -30.0), reflex=None)
    there, back = (MotorCommands({"upper": a, "lower": b}) for a, b in ((1.0, 0.8), (1.05, 0.95)))
    return returns(scene, [there, back], 3, 0.25)


def test_cycles_of_a_block_on_a_floor() -> None:
    """Hard: a block slides on a floor and back, three times. Right: without friction it returns to the same place;
    friction leaves it elsewhere after the first slide, and there it stays."""
    smooth, rough = rubbed(0.0), rubbed(0.3)
    assert smooth.max() < 2e-5
    assert rough[0] > 5.0 * smooth.max()
    assert np.abs(np.diff(rough)).max() < 5e-5


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_cycles_of_vowels(reference: Speaker, friction: float) -> None:
    """Hard: /i/ /a/ /u/, three times over: walls touched and left again. Right: without friction the /i/ that comes
    from /u/ differs from the one that comes from rest by what contact leaves open, 0.16 mm, with friction by 1 mm; and
    every later /i/ is that second one."""
    apart = returns(Scene(reference, mirror=True, friction=friction), [VOWELS[v] for v in "iau"], 3, 0.15)
    low, high = (0.0, 3e-4) if friction == 0.0 else (5e-4, 2e-3)
    assert low <= apart.min()
    assert apart.max() < high
    assert np.abs(np.diff(apart)).max() < (1e-6 if friction == 0.0 else 5e-5)  # 2e-8 and 5e-6 seen
