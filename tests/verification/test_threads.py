"""Results have the same bits for any number of threads."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import PASSIVE, block, furnished, hyoid_block, sheet

from glossa import VOWELS, MotorCommands, Movement, Posture, Ramp, Scene, Speaker


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


def contact_bits(found: Posture | Movement) -> list[bytes]:
    assert found.contact is not None
    assert found.contact.pressures.any()
    assert found.contact.drags.any()
    return [found.contact.pressures.tobytes(), found.contact.drags.tobytes()]


def test_contact() -> None:
    bowl = sheet(
        lambda x, y: 0.105 + 2.0 * ((x - 0.05) ** 2 + (y - 0.05) ** 2),
        (-0.02, -0.02),
        (0.12, 0.12),
        (30, 30),
        facing=-1,
    )
    body = furnished(block((10, 10, 8), (0.1, 0.1, 0.1)), walls={"bowl": bowl})
    shift = {"wall:bowl": (0.0, 0.0, -0.012)}
    scenes = [Scene(body, fixed=["bottom"], tissue=PASSIVE, friction=0.2, threads=n) for n in (1, 2, 3)]
    postures = [scene.equilibrate(prescribed=shift) for scene in scenes]
    assert bits(postures[0]) == bits(postures[1]) == bits(postures[2])
    assert contact_bits(postures[0]) == contact_bits(postures[1]) == contact_bits(postures[2])


@pytest.mark.parametrize("mirror", [False, True])
def test_hyoid_and_contact(mirror: bool) -> None:
    body = hyoid_block(muscles={"upper": 3.0}, between_walls=True)
    commands = MotorCommands({"upper": 0.85})
    found = []
    for threads in (1, 2, 3):
        scene = Scene(body, fixed=["right"], tissue=PASSIVE, friction=0.2, mirror=mirror, threads=threads)
        posture = scene.equilibrate(commands, loads={"top": (0.0, 0.0, 1.0)})
        movement = scene.simulate(Ramp(commands), 0.04, dt=0.004)
        assert posture.hyoid is not None
        assert movement.hyoid is not None
        poses = [posture.hyoid.rotation.tobytes(), movement.hyoid.rotations.tobytes()]
        everything = bits(posture) + contact_bits(posture) + movement_bits(movement) + contact_bits(movement) + poses
        found.append(everything)
    assert found[0] == found[1] == found[2]
