"""Each effect, left out, is its own limit: off means what the smallest value means."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import FloatArray, block
from tests.verification.test_derivatives import soft_lengths

from glossa import VOWELS, Damping, MotorCommands, Muscle, Ramp, Reflex, Scene, Speaker, Stiffening

COMMANDS = MotorCommands({"upper": 0.85, "side": 0.97})
AT_REST = 0.7109 + 0.712 * np.arctan(0.43)
"""Factor of eq. 5 at rest, 1.00004: f1 + f2 atan(f3)."""


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((4, 3, 3), muscles={"upper": 4.0, "side": 3.0})


def solved(body: Speaker, **options: Any) -> tuple[FloatArray, FloatArray]:
    """Equilibrium and the end of a movement of 40 ms."""
    scene = Scene(body, fixed=["left"], **options)
    posture = scene.equilibrate(COMMANDS, accuracy="reference")
    movement = scene.simulate(Ramp(COMMANDS), 0.04, dt=0.004, accuracy="reference")
    return posture.positions, movement.positions[-1]


def gap(a: FloatArray, b: FloatArray) -> float:
    return float(np.abs(a - b).max())


def assert_same(first: Any, second: Any, tolerance: float = 0.0) -> None:
    for a, b in zip(first, second, strict=True):
        assert gap(a, b) <= tolerance


def assert_different(first: Any, second: Any, least: float = 1e-5) -> None:
    for a, b in zip(first, second, strict=True):
        assert gap(a, b) > least


def test_stiffening(body: Speaker) -> None:
    off = solved(body, stiffening=False)
    assert_same(off, solved(body, stiffening=Stiffening(peak_multiplier=1.0)), 1e-12)
    assert_same(off, solved(body, stiffening=Stiffening(gains={"upper": 0.0, "side": 0.0})), 1e-12)
    assert_different(off, solved(body, stiffening=True))
    factors = Scene(body, fixed=["left"], stiffening=False).equilibrate(COMMANDS).stiffening
    assert np.array_equal(np.asarray(factors), np.ones(len(body.hexahedra)))


def test_stiffening_is_equation_1(body: Speaker) -> None:
    """1 + sum of p1 A(f) over the fibres that pass an element; p1 A = 9 / n at saturation."""
    gain = 55.0
    gains = {"upper": gain, "side": 2.0 * gain}
    posture = Scene(body, fixed=["left"], stiffening=Stiffening(gains=gains)).equilibrate(COMMANDS)
    expected = np.ones(len(body.hexahedra))
    for name, muscle in body.muscles.items():
        for fibre, activation in zip(muscle.fibres, posture.activations[posture.fibre_slice(name)], strict=True):
            passed = (np.isin(body.hexahedra, fibre).sum(axis=1) >= 2) & np.isin(
                np.arange(len(body.hexahedra)), muscle.elements
            )
            expected[passed] += gains[name] * activation
    assert expected.max() > 1.5
    assert posture.stiffening == pytest.approx(expected, rel=1e-12)


def test_gravity(body: Speaker) -> None:
    off = solved(body, gravity=None)
    assert_same(off, solved(body, gravity=(0.0, 0.0, 0.0)))
    assert_different(off, solved(body, gravity="upright"))
    assert_same(solved(body, gravity="upright"), solved(body, gravity=(0.0, 0.0, -9.81)))
    assert_same(solved(body, gravity="supine"), solved(body, gravity=(9.81, 0.0, 0.0)))


def test_force_velocity() -> None:
    """In statics eq. 5 multiplies every force by 1.00004: the same as muscles stronger by that."""
    plain = block((4, 3, 3), muscles={"upper": 4.0, "side": 3.0})
    strong = block((4, 3, 3), muscles={"upper": 4.0 * AT_REST, "side": 3.0 * AT_REST})
    assert abs(AT_REST - 1.00004) < 5e-6
    scenes = {
        "on": Scene(plain, fixed=["left"]),
        "off": Scene(plain, fixed=["left"], force_velocity=False),
        "stronger": Scene(strong, fixed=["left"], force_velocity=False),
    }
    postures = {name: scene.equilibrate(COMMANDS, accuracy="reference") for name, scene in scenes.items()}
    assert gap(postures["on"].positions, postures["stronger"].positions) < 1e-11
    assert postures["on"].forces.to_numpy() == pytest.approx(postures["stronger"].forces.to_numpy(), rel=1e-9)
    assert 1e-9 < gap(postures["on"].positions, postures["off"].positions) < 1e-6
    moved = [scenes[name].simulate(Ramp(COMMANDS), 0.02, dt=0.004).positions[-1] for name in ("on", "off")]
    assert gap(*moved) > 1e-5  # in movement it matters


def test_reflex(body: Speaker) -> None:
    off = solved(body, reflex=None)
    assert_same(off, solved(body, reflex=Reflex(delay=0.0, velocity_gain=0.0)), 1e-12)
    short = solved(body, reflex=Reflex(delay=1e-3, velocity_gain=0.0))
    shorter = solved(body, reflex=Reflex(delay=2.5e-4, velocity_gain=0.0))
    assert gap(off[1], shorter[1]) < 0.5 * gap(off[1], short[1])
    full = solved(body)
    assert gap(off[0], full[0]) < 1e-11  # statics know no delay
    assert gap(off[1], full[1]) > 1e-4


def test_damping(body: Speaker) -> None:
    options: dict[str, Any] = {"fixed": ["left"]}
    none = Scene(body, damping=None, **options).simulate(None, 0.05, dt=0.001)
    zero = Scene(body, damping=Damping(alpha=0.0, beta=0.0), **options).simulate(None, 0.05, dt=0.001)
    full = Scene(body, **options).simulate(None, 0.05, dt=0.001)
    assert np.array_equal(none.positions, zero.positions)
    fallen = [-float((m.positions[-1] - m.positions[0])[:, 2].min()) for m in (none, full)]
    assert fallen[0] > 1.2 * fallen[1] > 1e-3


def test_silent_muscles(body: Speaker) -> None:
    """A muscle without a command is a muscle the speaker does not have, to the last bit."""
    alone = Speaker(
        body.nodes,
        body.hexahedra,
        muscles={"upper": body.muscles["upper"]},
        node_sets=dict(body.node_sets),
    )
    command = MotorCommands({"upper": 0.85})
    pairs = [Scene(speaker, fixed=["left"]) for speaker in (body, alone)]
    postures = [scene.equilibrate(command) for scene in pairs]
    assert np.array_equal(postures[0].positions, postures[1].positions)
    assert postures[0].forces["side"] == 0.0
    assert postures[0].forces["upper"] == postures[1].forces["upper"] > 0.1
    movements = [scene.simulate(Ramp(command), 0.02) for scene in pairs]
    assert np.array_equal(movements[0].positions, movements[1].positions)
    slack = pairs[0].equilibrate(command.with_(side=2.0))  # commanded, but never stretched to lambda
    assert slack.forces["side"] == 0.0
    assert gap(slack.positions, postures[0].positions) < 1e-8


def test_no_muscles_at_all(body: Speaker) -> None:
    bare = Speaker(body.nodes, body.hexahedra, node_sets=dict(body.node_sets))
    scenes = [Scene(speaker, fixed=["left"]) for speaker in (body, bare)]
    assert scenes[1].effects == ("elasticity", "gravity", "damping")
    assert np.array_equal(scenes[0].equilibrate().positions, scenes[1].equilibrate().positions)
    moved, alone = (scene.simulate(None, 0.02).positions for scene in scenes)
    assert np.array_equal(moved, alone)
    assert scenes[1].equilibrate().forces.empty


def test_rest_commands_of_a_vowel(reference: Speaker) -> None:
    """Without gravity, muscles at their rest length do nothing."""
    posture = Scene(reference, gravity=None).equilibrate(dict.fromkeys(VOWELS["i"], 1.0))
    assert np.abs(posture.displacements).max() < 1e-9
    assert posture.forces.max() < 1e-6


def test_one_fibre_pulls_as_equations_2_to_5_say() -> None:
    """Ends held: F = rho (exp(c (l - lambda)) - 1) times the factor of eq. 5, until it saturates at rho."""
    speaker = block((3, 1, 1))
    line = [0, 4, 8, 12]
    assert speaker.nodes[line, 0] == pytest.approx([0.0, 0.02, 0.04, 0.06])
    muscle = Muscle(range(3), [line], 7.0)
    body = Speaker(
        speaker.nodes, speaker.hexahedra, muscles={"line": muscle}, node_sets={"left": range(4), "right": range(12, 16)}
    )
    scene = Scene(body, fixed=["left", "right"], gravity=None)
    for fraction in (0.98, 0.9, 0.8, 0.72, 0.7, 0.4):
        posture = scene.equilibrate({"line": fraction}, accuracy="reference")
        lengths = soft_lengths(posture.positions[line].astype(complex), body.nodes[line]).real
        activation = float(lengths.sum()) - fraction * 0.06
        assert posture.activations[0] == pytest.approx(activation, rel=1e-9)
        level = min(np.expm1(40.0 * activation), 1.0)
        assert posture.forces["line"] == pytest.approx(7.0 * level * AT_REST, rel=1e-9)
    assert level == 1.0
