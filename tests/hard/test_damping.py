"""Damping where the tissue's tangent is indefinite: a tongue pressed against its walls.

Damping by the whole tangent feeds energy there: nodes of the blade's edge reach metres per second within a millisecond
and no step is short enough. Damping by the material takes energy from every motion.
"""

from __future__ import annotations

import numpy as np
import pytest

from glossa import VOWELS, Damping, Movement, Ramp, Scene, SolveError, Speaker

UNTIL = 0.3
FASTEST = 0.3
"""Speed in m/s that no node of a vowel's movement reaches."""


@pytest.fixture(scope="module")
def speaker() -> Speaker:
    return Speaker.reference()


def speeds(movement: Movement) -> np.ndarray:
    """(t,) of the fastest node, m/s."""
    return np.asarray(np.linalg.norm(movement.velocities, axis=2).max(axis=1))


@pytest.mark.parametrize("vowel", ["i", "a", "u"])
def test_vowels_move_on(speaker: Speaker, vowel: str) -> None:
    movement = Scene(speaker, mirror=True).simulate(Ramp(VOWELS[vowel]), UNTIL, accuracy="draft")
    assert speeds(movement).max() < FASTEST
    assert movement.report.rescued == 0
    assert movement.report.accumulated_error < 3e-4


def test_short_steps_change_little(speaker: Speaker) -> None:
    """Steps that resolve vibrations near 1 kHz find none."""
    scene = Scene(speaker, mirror=True)
    start = scene.simulate(Ramp(VOWELS["i"]), 0.11, accuracy="standard").at(0.11)
    coarse, fine = (scene.simulate(VOWELS["i"], 0.012, initial=start, dt=dt) for dt in (1e-3, 1e-4))
    assert speeds(fine).max() < FASTEST
    assert np.abs(coarse.positions[-1] - fine.positions[-1]).max() < 5e-5


@pytest.mark.slow
def test_damping_by_the_tangent_blows_up(speaker: Speaker) -> None:
    """So that the tests above can fail: 0.115 s is as far as it came."""
    scene = Scene(speaker, mirror=True, damping=Damping(law="tangent"))
    with pytest.raises(SolveError, match="no time step") as caught:
        scene.simulate(Ramp(VOWELS["i"]), UNTIL, accuracy="standard")
    assert caught.value.movement is not None
    assert speeds(caught.value.movement).max() > FASTEST
