"""Extreme commands: everything at once, each muscle alone, antagonists against each other, commands that jump."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.checks import farthest, moved, sound

from glossa import MUSCLES, VOWELS, MotorCommands, Ramp, Scene, Schedule, Speaker

FASTEST = 1.0
"""Speed in m/s that no node of a tongue reaches when commands jump: 0.3 seen."""

ANTAGONISTS = [
    ("GGp", "HG"),
    ("Sty", "GGa"),
    ("SL", "IL"),
    ("Vert", "Trans"),
    ("GH", "MH"),
    ("Sty", "GGp"),
    ("SL", "Vert"),
]


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True)


def test_all_muscles_at_half_length(scene: Scene) -> None:
    """Hard: every muscle saturates or nearly so, tissue is stiffened tenfold almost everywhere and pressed against
    teeth and palate. Right: converged, and every muscle pulls."""
    posture = scene.equilibrate(dict.fromkeys(MUSCLES, 0.5))
    sound(posture)
    assert (posture.forces > 0.3).all()  # N; SL, the weakest, 0.5 seen


@pytest.mark.parametrize("muscle", MUSCLES)
def test_each_muscle_alone_at_two_fifths(scene: Scene, muscle: str) -> None:
    """Hard: nothing balances a muscle that wants to be less than half as long; elements between its fibres are
    flattened to J = 0.08 (Sty). Right: converged; it is shorter than at rest and alone pulls."""
    posture = scene.equilibrate({muscle: 0.4})
    sound(posture)
    assert posture.forces[muscle] > 0.1
    assert posture.forces.drop(muscle).abs().max() == 0.0
    speaker = scene.speaker
    rest, now = (lengths(speaker, muscle, positions) for positions in (speaker.nodes, posture.positions))
    assert now.mean() < 0.95 * rest.mean()


def lengths(speaker: Speaker, muscle: str, positions: np.ndarray) -> np.ndarray:
    """(fibres,) m."""
    fibres = speaker.muscles[muscle].fibres
    return np.array([np.linalg.norm(np.diff(positions[f], axis=0), axis=1).sum() for f in fibres])


@pytest.mark.parametrize("pair", ANTAGONISTS, ids="-".join)
def test_antagonists_at_full_force(scene: Scene, pair: tuple[str, str]) -> None:
    """Hard: two muscles pull against each other with all they have; what moves is the difference. Right: converged,
    both pull."""
    posture = scene.equilibrate(dict.fromkeys(pair, 0.5))
    sound(posture)
    assert (posture.forces[list(pair)] > 0.3).all()


def test_antagonists_of_a_block() -> None:
    """Hard: the two halves of a symmetric block pull with a hundred times its weight. Right: it shortens straight, to
    the last micrometre."""
    body = block((6, 4, 4), muscles={"upper": 60.0, "lower": 60.0})
    posture = Scene(body, fixed=["left"], gravity=None).equilibrate({"upper": 0.5, "lower": 0.5})
    sound(posture)
    image = posture.positions.reshape(7, 5, 5, 3)[:, :, ::-1] * [1.0, 1.0, -1.0] + [0.0, 0.0, 0.04]
    assert farthest(image.reshape(-1, 3), posture.positions) < 1e-6
    assert posture.displacements[:, 0].min() < -0.01


# Jumps


@pytest.mark.parametrize("commands", [VOWELS["a"], MotorCommands(dict.fromkeys(MUSCLES, 0.5))], ids=["a", "all 0.5"])
def test_commands_that_jump(scene: Scene, commands: MotorCommands) -> None:
    """Hard: all activations appear at once, at full delay, on a tongue at rest. Right: no failed step, no node faster
    than a tongue can be, and walls entered by a tenth of a millimetre at most on the way."""
    report = moved(scene.simulate(commands, 0.03, accuracy="draft"), fastest=FASTEST)
    assert report.penetration < 1e-4


@pytest.mark.slow
def test_jumps_between_vowels(scene: Scene) -> None:
    """Hard: from /i/ to /a/ and back in no time, every 50 ms. Right: no failed step; likewise a ramp of 0.1 ms, which
    ends within a tenth of a millimetre of the jump."""
    targets = [(0.05 * k, VOWELS["ia"[k % 2]]) for k in range(4)]
    jump, ramp = (scene.simulate(Schedule.through(targets, transition=transition), 0.2) for transition in (0.0, 1e-4))
    moved(jump, fastest=FASTEST)
    moved(ramp, fastest=FASTEST)
    assert farthest(jump.positions[-1], ramp.positions[-1]) < 1e-4


def test_jump_of_a_block_equals_its_steep_ramp() -> None:
    """Hard: across a jump the stiffness of active tissue jumps, too, and momentum with it. Right: what a ramp of ten
    microseconds does, to the shift in time."""
    scene = Scene(block((6, 4, 4), muscles={"upper": 6.0}), fixed=["left"])
    target = MotorCommands({"upper": 0.5})
    late = Schedule([0.0, 0.02, 0.02], [MotorCommands({"upper": 1.0})] * 2 + [target])
    jump = scene.simulate(late, 0.06, dt=5e-4)
    ramp = scene.simulate(Ramp(target, duration=1e-5, onset=0.02), 0.06, dt=5e-4)
    moved(jump, fastest=FASTEST)
    assert farthest(jump.at(0.06).positions, ramp.at(0.06).positions) < 5e-6
