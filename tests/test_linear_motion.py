"""The linearised equation of motion against the forces that it is the derivative of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.blocks import block, hyoid_block

from glossa import Damping, InputError, Posture, Reflex, Scene, _core

COMMANDS = {"axial": 0.85}


def on_hyoid(**options: Any) -> Scene:
    return Scene(hyoid_block(muscles={"axial": 3.0}, between_walls=True), fixed=["right"], **options)


SCENES: dict[str, Callable[[], Scene]] = {
    "block": lambda: Scene(block((3, 2, 2), muscles={"axial": 4.0}), fixed=["left"]),
    "mirrored": lambda: Scene(block((3, 2, 2), muscles={"axial": 4.0}, centred=True), fixed=["left"], mirror=True),
    "damping by the tangent": lambda: Scene(
        block((3, 2, 2), muscles={"axial": 4.0}), fixed=["left"], damping=Damping(law="tangent")
    ),
    "Q1": lambda: Scene(block((3, 2, 2), muscles={"axial": 4.0}), fixed=["left"], element="Q1"),
    "Q2P1": lambda: Scene(block((4, 2, 2), muscles={"axial": 4.0}), fixed=["left"], element="Q2P1"),
    "contact and hyoid": lambda: on_hyoid(friction=0.0),
    "mirrored, contact and hyoid": lambda: on_hyoid(friction=0.0, mirror=True),
}


def core_of(scene: Scene, posture: Posture) -> _core.LinearMotion:
    body = scene._body
    pressure, drag = body.restrict_contact(posture.contact)
    return _core.LinearMotion(
        scene._solver,
        fractions=scene._fractions(posture.commands),
        positions=body.restrict_positions(posture.positions, "posture"),
        contact_pressure=pressure,
        contact_drag=drag,
    )


def difference(force: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """Central, of fourth order."""
    near, far = force(step) - force(-step), force(2.0 * step) - force(-2.0 * step)
    return np.asarray((8.0 * near - far) / (12.0 * step))


@pytest.mark.parametrize("name", SCENES)
def test_matrices_are_derivatives_of_the_forces(name: str) -> None:
    scene = SCENES[name]()
    posture = scene.equilibrate(COMMANDS)
    motion, core = scene.linearise(posture), core_of(scene, posture)
    if "contact" in name:
        assert posture.contact is not None
        assert (posture.contact.pressures > 0.0).sum() > 3
    rng = np.random.default_rng(1)
    still, active = np.zeros(motion.size), core.activation
    move, pull = rng.normal(size=motion.size), rng.normal(size=len(active))
    found = {
        "stiffness": (difference(lambda h: core.force(h * move, still, active), 3e-8), motion.stiffness @ move),
        "damping": (difference(lambda h: core.force(still, h * move, active), 1e-4), motion.damping @ move),
        "pulls": (difference(lambda h: core.force(still, still, active + h * pull), 1e-5), motion.pulls @ pull),
    }
    for what, (numeric, exact) in found.items():
        assert np.abs(numeric).max() > 0.1, what
        # Cancellation in the differences: 4e-8 seen.
        assert np.abs(exact - numeric).max() < 1e-6 * np.abs(numeric).max(), what


def test_gradients_are_derivatives_of_the_lengths() -> None:
    scene = on_hyoid(friction=0.0)
    posture = scene.equilibrate(COMMANDS)
    motion = scene.linearise(posture)
    move = np.random.default_rng(2).normal(size=motion.size)
    nodes = motion.nodes_of(move)
    fibres = scene.speaker.muscles["axial"].fibres

    def lengths(h: float) -> np.ndarray:
        moved = posture.positions + h * nodes
        return np.array([np.linalg.norm(np.diff(moved[path], axis=0), axis=1).sum() for path in fibres])

    numeric = difference(lengths, 1e-5)
    assert len(motion.muscles) == len(fibres)
    # The core softens short segments by 1e-4 of their length.
    assert np.abs(motion.gradients.T @ move - numeric).max() < 1e-3 * np.abs(numeric).max()


def test_mass_is_that_of_the_body() -> None:
    """A displacement that grows evenly from the held face has a third of the body's mass."""
    scene = Scene(block((3, 2, 2), (0.06, 0.04, 0.04)), fixed=["left"], gravity=None)
    motion = scene.linearise(scene.equilibrate(None))
    along = scene.speaker.nodes[:, 0] / 0.06
    moved = np.zeros(motion.size)
    for k in range(motion.size):
        unit = np.zeros(motion.size)
        unit[k] = 1.0
        field = motion.nodes_of(unit)
        moved[k] = along @ field[:, 0]
    mass = 1040.0 * 0.06 * 0.04 * 0.04
    assert moved @ (motion.mass @ moved) == pytest.approx(mass / 3.0, rel=1e-9)
    assert motion.muscles == ()
    assert motion.pulls.shape == (motion.size, 0)


def test_a_reflex_at_once_has_no_delay() -> None:
    body = block((2, 1, 1), muscles={"axial": 4.0})
    for reflex, expected in ((None, (0.0, 0.0)), (Reflex(delay=0.02, velocity_gain=0.03), (0.02, 0.03))):
        scene = Scene(body, fixed=["left"], reflex=reflex)
        motion = scene.linearise(scene.equilibrate(COMMANDS))
        assert (motion.delay, motion.velocity_gain) == expected


def test_friction_makes_touching_points_stick() -> None:
    """The tangential stiffness comes on top, and nothing else changes."""
    stiff, slippery = on_hyoid(friction=0.3), on_hyoid(friction=0.0)
    posture = slippery.equilibrate(COMMANDS)
    loose = slippery.linearise(posture)
    tight = stiff.linearise(stiff.equilibrate(COMMANDS, start=posture))
    extra = (tight.stiffness - loose.stiffness).toarray()
    # The two equilibria differ by some micrometres.
    assert np.linalg.eigvalsh(0.5 * (extra + extra.T))[-1] > 1e3
    changed = abs(tight.damping - loose.damping).max() / abs(loose.damping).max()
    assert changed < 0.05


def test_what_is_no_equilibrium_is_refused() -> None:
    scene = Scene(block((3, 2, 2), muscles={"axial": 4.0}), fixed=["left"])
    posture = scene.equilibrate(COMMANDS)
    movement = scene.simulate(COMMANDS, 0.02)
    with pytest.raises(InputError, match="moment of a movement"):
        scene.linearise(movement.at(0.01))
    weaker = Scene(scene.speaker, fixed=["left"], firing_gradient=20.0)
    with pytest.raises(InputError, match="no equilibrium of this scene"):
        weaker.linearise(posture)
    with pytest.raises(InputError, match="another speaker"):
        Scene(block((2, 2, 2)), fixed=["left"]).linearise(posture)


def test_arrays_that_do_not_fit_are_refused() -> None:
    scene = Scene(block((2, 1, 1), muscles={"axial": 4.0}), fixed=["left"])
    core = core_of(scene, scene.equilibrate(COMMANDS))
    good, active = np.zeros(len(core.unknowns)), core.activation
    with pytest.raises(InputError, match="velocity: one value per unknown"):
        core.force(good, good[1:], active)
    with pytest.raises(InputError, match="one value per active fibre"):
        core.force(good, good, active[1:])
    with pytest.raises(InputError, match="must be finite"):
        core.matrix(float("nan"), 0.0)
