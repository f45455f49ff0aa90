"""Ctrl-C stops a solve, which leaves its last good state and a scene that works."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.blocks import block

from glossa import Movement, Posture, Scene, SolveInterrupted, Speaker


@pytest.fixture(scope="module")
def scene() -> Scene:
    speaker: Speaker = block((4, 2, 2), muscles={"upper": 2.0})
    return Scene(speaker, fixed=["left"])


def interrupted(work: Callable[[], Any], after: float) -> SolveInterrupted:
    """Ctrl-C while ``work`` runs."""
    # A background job of a shell starts with SIGINT ignored: Python would then never see it.
    interrupt = signal.signal(signal.SIGINT, signal.default_int_handler)
    previous = signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, after)
    try:
        with pytest.raises(SolveInterrupted) as caught:
            work()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)
        signal.signal(signal.SIGINT, interrupt)
    return caught.value


def test_interrupted_movement() -> None:
    speaker = block((12, 8, 8), muscles={"upper": 8.0})
    scene = Scene(speaker, fixed=["left"])
    stop = interrupted(lambda: scene.simulate({"upper": 0.9}, 50.0, dt=0.002), 0.5)
    assert isinstance(stop, KeyboardInterrupt)
    assert isinstance(stop.movement, Movement)
    assert 0.0 < stop.movement.times[-1] < 50.0
    assert len(stop.movement.times) > 1
    assert stop.posture.time == stop.movement.times[-1]
    untouched = Scene(speaker, fixed=["left"]).simulate({"upper": 0.9}, 0.01, dt=0.002)
    again = scene.simulate({"upper": 0.9}, 0.01, dt=0.002)
    assert again.positions == pytest.approx(untouched.positions, abs=1e-8)


def test_interrupted_equilibrium() -> None:
    speaker = block((14, 10, 10), muscles={"upper": 8.0})
    scene = Scene(speaker, fixed=["left"])
    stop = interrupted(lambda: scene.equilibrate({"upper": 0.7}, accuracy="reference"), 0.05)
    assert isinstance(stop, KeyboardInterrupt)
    assert isinstance(stop.posture, Posture)
    assert stop.posture.report is not None
    assert stop.posture.report.status == "interrupted"
    assert np.isfinite(stop.posture.positions).all()
    finished = scene.equilibrate(accuracy="draft")
    assert finished.report is not None
    assert finished.report.converged


def test_interrupt_before_a_solve(scene: Scene) -> None:
    """An interrupt that has arrived already stops the first check, and the next solve is a fresh one."""
    stop = interrupted(lambda: [scene.simulate({"upper": 0.9}, 5.0, dt=0.001) for _ in range(100)], 0.05)
    assert "interrupted" in str(stop)
    assert scene.simulate({"upper": 0.9}, 0.01).report.converged
