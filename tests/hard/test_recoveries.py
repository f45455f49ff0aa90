"""Each recovery of the solver, and a case that fails without it.

The core has no switches for them: :func:`tests.hard.plain_newton.plain_newton` does without one at a time, from the
same pieces. Where it cannot, the case tells by its report that the recovery was needed.
"""

from __future__ import annotations

import pytest
from tests.blocks import block
from tests.hard.bodies import over_floor, over_tooth
from tests.hard.checks import farthest, moved, sound
from tests.hard.plain_newton import plain_newton

from glossa import MotorCommands, Scene, SolveError, Stiffening, Yeoh


@pytest.fixture(scope="module")
def strong() -> Scene:
    """A block whose muscle could lift ten tongues."""
    return Scene(block((6, 4, 4), muscles={"upper": 60.0}), fixed=["left"], stiffening=False)


@pytest.fixture(scope="module")
def heavy() -> Scene:
    """A block more than five times as heavy as on earth: it bends down by more than its length."""
    return Scene(block((6, 4, 4)), fixed=["left"], gravity=(0.0, 0.0, -55.0))


def test_shorter_steps_against_inversion(heavy: Scene) -> None:
    """Hard: the first full Newton steps turn elements inside out. Right: steps as long as elements allow."""
    posture = heavy.equilibrate()
    sound(posture)
    assert plain_newton(heavy, {}, shorten=False).why == "inverted"
    own = plain_newton(heavy, {})
    assert own.converged
    assert farthest(own.positions, posture.positions) < 1e-7


def test_shorter_steps_at_a_wall() -> None:
    """Hard: a full step carries the body far into a floor that it did not touch before, and the next one out of it
    again. Right: steps that lower the energy; the report counts those cut."""
    scene = Scene(over_floor(block((6, 4, 4), muscles={"upper": 6.0}), 0.0005), fixed=["left"], friction=0.0)
    assert sound(scene.equilibrate({"upper": 0.8})).line_search > 0
    assert plain_newton(scene, {"upper": 0.8}, shorten=False).why == "inverted"
    assert plain_newton(scene, {"upper": 0.8}).converged


def test_renewed_factors(strong: Scene) -> None:
    """Hard: half of the muscle's length goes, so that the tangent of the start says nothing about the end. Right: as
    many factorisations as it takes; a frozen factor serves near the solution only."""
    posture = strong.equilibrate({"upper": 0.5})
    report = sound(posture)
    assert report.factorisations > 5
    assert report.quasi_newton > report.iterations / 4
    assert plain_newton(strong, {"upper": 0.5}, renew=False).why == "limit"
    assert farthest(plain_newton(strong, {"upper": 0.5}).positions, posture.positions) < 1e-7


def test_shifted_tangents(heavy: Scene) -> None:
    """Hard: on the way the body hangs from a stretched upper side and the tangent is indefinite: its Newton step would
    lead uphill. Right: a shifted factor, counted."""
    assert sound(heavy.equilibrate()).indefinite > 0
    assert plain_newton(heavy, {}, cure=False).why == "indefinite"


@pytest.mark.parametrize("angle", [90.0, 60.0])
def test_dropped_curvature_of_walls(angle: float) -> None:
    """Hard: a body comes to rest on an edge, whose curved distance makes tangents indefinite. Right: the negative part
    of the curvature stays out until it helps. Plain Newton, which keeps it, meets an indefinite tangent."""
    body = over_tooth(block((6, 4, 4), muscles={"upper": 6.0}), angle, x=0.04, clearance=0.0005)
    scene = Scene(body, fixed=["left"], friction=0.0, gravity=(0.0, 0.0, -20.0))
    report = sound(scene.equilibrate({"upper": 0.8}))
    assert report.indefinite == 0
    assert plain_newton(scene, {"upper": 0.8}, cure=False).why == "indefinite"


def runaway(max_iterations: int) -> int:
    """Iterations for soft tissue that its own strong muscles stiffen a thousandfold."""
    body = block((5, 2, 2), (0.05, 0.02, 0.02), muscles={"upper": 60.0, "lower": 60.0})
    cadaver, stiffening = Yeoh(192.0, 90.0), Stiffening(peak_multiplier=1000.0)
    scene = Scene(body, fixed=["left"], tissue=cadaver, stiffening=stiffening)
    return sound(scene.equilibrate({"upper": 0.9, "lower": 0.9}, max_iterations=max_iterations)).iterations


def test_held_stiffening() -> None:
    """Hard: stiffer tissue gives way less, so that activation and stiffness answer each other for ever where each
    follows the other at every iteration. Right: factors held until the energy is minimised. ``max_iterations`` counts
    for each way: that more are taken tells that the first has failed, however many it was given."""
    for limit in (100, 400):
        assert limit < runaway(limit) < limit + 60


def test_rescued_time_steps() -> None:
    """Hard: without damping, reflex and force-velocity law a strong muscle slams a block through 10 ms steps. Right:
    shorter steps, counted. A muscle ten times as strong fails at the first step, and says so."""

    def scene(capacity: float) -> Scene:
        body = block((6, 4, 4), muscles={"upper": capacity})
        return Scene(body, fixed=["left"], damping=None, reflex=None, force_velocity=False)

    commands = MotorCommands({"upper": 0.5})
    assert moved(scene(60.0).simulate(commands, 0.02, dt=0.01), fastest=100.0).rescued > 0
    with pytest.raises(SolveError, match="no time step from 0 s on could be solved") as caught:
        scene(600.0).simulate(commands, 0.02, dt=0.01)
    assert caught.value.report.rescued > 0
    assert moved(scene(600.0).simulate(commands, 0.001, dt=1e-5), fastest=1000.0).rescued == 0


def test_a_start_that_misleads() -> None:
    """Hard: a posture under other loads is no guess at all. Right: what is found does not depend on it."""
    scene = Scene(block((6, 4, 4), muscles={"upper": 6.0}), fixed=["left"])
    far = scene.equilibrate(prescribed={"right": (-0.03, 0.01, 0.02)})
    found = scene.equilibrate({"upper": 0.6}, start=far)
    sound(found)
    assert farthest(found.positions, scene.equilibrate({"upper": 0.6}).positions) < 1e-7
