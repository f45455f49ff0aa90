"""Thousands of equilibria in one process: memory stays flat and results stay the same."""

from __future__ import annotations

import gc
from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block
from tests.hard import random_commands as drawn
from tests.hard.bodies import over_floor

from glossa import MUSCLES, MotorCommands, Scene, SolveError, Speaker

MEBIBYTE = 2**20


def resident() -> int:
    """Memory of this process in bytes."""
    status = Path("/proc/self/status")
    if not status.exists():
        pytest.skip("no /proc here to read the resident memory from")
    gc.collect()
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmRSS:"))
    return int(line.split()[1]) * 1024


def solve_block(scene: Scene, rng: np.random.Generator) -> bool:
    """One equilibrium of random commands and loads, and now and then a movement; whether it converged."""
    commands = {"upper": rng.uniform(0.4, 1.2), "lower": rng.uniform(0.4, 1.2)}
    load = {"right": rng.uniform(-0.2, 0.2, 3)}
    try:
        scene.equilibrate(commands, loads=load, max_iterations=60)
        if rng.random() < 0.02:
            scene.simulate(MotorCommands(commands), 0.01, dt=2e-3)
    except SolveError:
        return False
    return True


def soak(scene: Scene, count: int, seed: int) -> int:
    """How many of ``count`` converge."""
    rng = np.random.default_rng(seed)
    return sum(solve_block(scene, rng) for _ in range(count))


def body() -> Speaker:
    return over_floor(block((4, 2, 2), muscles={"upper": 2.0, "lower": 2.0}), 5e-4)


def test_short_soak_of_a_block() -> None:
    """Right: 200 random equilibria; the first of them again, to the last bit."""
    scene = Scene(body(), fixed=["left"])
    first = scene.equilibrate({"upper": 0.7}).positions
    assert soak(scene, 200, 3) >= 196
    assert np.array_equal(scene.equilibrate({"upper": 0.7}).positions, first)


@pytest.mark.slow
def test_soak_of_a_block() -> None:
    """Hard: what one solve in a thousand leaves behind adds up. Right: memory after 6,000 equilibria is that after the
    first 1,000, to 8 MB; scenes that come and go, too, leave nothing."""
    scene = Scene(body(), fixed=["left"])
    soak(scene, 1000, 4)
    before = resident()
    assert soak(scene, 5000, 5) >= 4900
    assert resident() - before < 8 * MEBIBYTE
    for _ in range(20):
        soak(Scene(body(), fixed=["left"]), 1, 6)
    before = resident()
    for _ in range(200):
        soak(Scene(body(), fixed=["left"]), 1, 6)
    assert resident() - before < 8 * MEBIBYTE


@pytest.mark.slow
def test_soak_of_the_speaker(reference: Speaker) -> None:
    """Hard: as above, with contact, hyoid and every set of commanded muscles, each of which keeps a system for re-use.
    Right: 300 equilibria, memory of the last 200 flat."""
    scene = Scene(reference, mirror=True)
    rng = np.random.default_rng(7)
    low, high = drawn.RANGES["common"]

    def solve(count: int) -> None:
        for _ in range(count):
            named = [muscle for muscle in MUSCLES if rng.random() < 0.8]
            scene.equilibrate({muscle: rng.uniform(low, high) for muscle in named}, accuracy="draft")

    solve(100)
    before = resident()
    solve(200)
    assert resident() - before < 32 * MEBIBYTE
