"""Results have the same bits for any number of threads."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from glossa import VOWELS, Movement, Posture, Scene, Speaker


def bits(posture: Posture) -> list[bytes]:
    names = ("positions", "activations", "fibre_forces", "pressure", "stiffening", "support_forces")
    return [np.asarray(getattr(posture, name)).tobytes() for name in names]


def movement_bits(movement: Movement) -> list[bytes]:
    names = ("times", "positions", "velocities", "activations", "fibre_forces")
    return [getattr(movement, name).tobytes() for name in names]


@pytest.mark.parametrize("mirror", [False, True])
def test_speaker(reference: Speaker, mirror: bool) -> None:
    one, *others = (Scene(reference, threads=n, mirror=mirror) for n in (1, 2, 3))
    wanted = one.equilibrate(VOWELS["i"])
    moved = one.simulate(VOWELS["i"], 0.012, dt=0.004)
    assert np.abs(wanted.displacements).max() > 1e-3
    assert np.abs(moved.positions[-1] - moved.positions[0]).max() > 1e-4
    for scene in others:
        assert bits(scene.equilibrate(VOWELS["i"])) == bits(wanted)
        assert movement_bits(scene.simulate(VOWELS["i"], 0.012, dt=0.004)) == movement_bits(moved)


def test_large_block() -> None:
    speaker = block((16, 10, 10), muscles={"upper": 8.0})
    postures = [Scene(speaker, fixed=["left"], threads=n).equilibrate({"upper": 0.9}) for n in (1, 2, 3)]
    assert np.abs(postures[0].displacements).max() > 1e-3
    assert bits(postures[0]) == bits(postures[1]) == bits(postures[2])
