"""Every way in which a solve can end (``cpp/solver/report.hpp``), provoked."""

from __future__ import annotations

import signal
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.bodies import layered_bar, over_floor
from tests.hard.checks import sound

from glossa import MotorCommands, Posture, Scene, SolveError, SolveInterrupted, Speaker, Stiffening, Yeoh

FORCE = {"upper": 0.6}


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((6, 4, 4), muscles={"upper": 6.0})


@pytest.fixture(scope="module")
def scene(body: Speaker) -> Scene:
    return Scene(body, fixed=["left"])


def refused(scene: Scene, status: str, **arguments: Any) -> SolveError:
    """The refusal of an equilibrium, with the evidence that it has to carry; the scene works afterwards as before."""
    before = scene.equilibrate().positions
    with pytest.raises(SolveError) as caught:
        scene.equilibrate(**arguments)
    error = caught.value
    assert (error.status, error.report.status, error.report.converged) == (status, status, False)
    assert isinstance(error.posture, Posture)
    assert f"no equilibrium: {status}" in str(error)
    assert np.array_equal(scene.equilibrate().positions, before)
    return error


def test_converged(scene: Scene) -> None:
    report = sound(scene.equilibrate(FORCE))
    assert report.status == "converged"
    assert report.residuals_by_iteration[0] > 1e3 * report.residual


def test_iteration_limit(scene: Scene) -> None:
    """One iteration, and one more with the stiffening held, are not enough."""
    error = refused(scene, "iteration_limit", commands=FORCE, max_iterations=1)
    assert error.report.iterations == 2
    assert error.report.least_jacobian > 0.0
    sound(scene.equilibrate(FORCE, start=error.posture))  # the last good state is a start


def test_stalled() -> None:
    """No step is short enough to lower an energy of which the soft half is less than the rounding of the stiff one."""
    bar = layered_bar(["stiff"] * 4 + [""] * 4)
    scene = Scene(bar, fixed=["left"], stiffening=Stiffening(gains={"stiff": 1e12}))
    refused(scene, "stalled", commands={"stiff": 0.5}, loads={"right": (0.0, 0.0, -0.005)})


def test_inverted_start(scene: Scene, body: Speaker) -> None:
    error = refused(scene, "inverted", start=body.nodes * [-1.0, 1.0, 1.0])
    assert error.report.least_jacobian < 0.0
    assert error.report.iterations == 0


def test_inverted_on_the_way(body: Speaker) -> None:
    """The near end of the block is to go where its inner nodes are held: an element would have to turn inside out."""
    grid = np.flatnonzero(np.isclose(body.nodes[:, 0], 0.01))
    held = Speaker(
        body.nodes,
        body.hexahedra,
        muscles=dict(body.muscles),
        node_sets={**body.node_sets, "second": grid.astype(np.int32)},
    )
    error = refused(Scene(held, fixed=["left"]), "inverted", prescribed={"second": (-0.02, 0.0, 0.0)})
    assert error.report.least_jacobian > 0.0  # the last good state is not inverted


def test_penetrated(body: Speaker) -> None:
    """A start one centimetre behind a wall, from where the way out is not known."""
    scene = Scene(over_floor(body, 0.0005), fixed=["left"])
    start = body.nodes - np.where(body.nodes[:, :1] > 0.0, 1.0, 0.0) * [0.0, 0.0, 0.0105]
    assert refused(scene, "penetrated", start=start).report.iterations == 0


def test_indefinite(scene: Scene, body: Speaker) -> None:
    """The start has the element pressures of tissue a million times as stiff and says that it were of this one: no
    shift of the tangent outweighs them. Without that lie they are left behind (``test_tissue.py``)."""
    stiff = Scene(body, fixed=["left"], tissue=Yeoh(1037e6, 486e6))
    bent = stiff.equilibrate(prescribed={"right": (-0.012, 0.0, 0.003)})
    refused(scene, "indefinite", commands=FORCE, start=replace(bent, tissue=scene.tissue))
    sound(scene.equilibrate(FORCE, start=bent))


def test_stalled_movement() -> None:
    """Nothing slows a muscle that throws a block around with a thousand times its weight: no 10 ms step, nor a
    hundredth of one, can be solved."""
    body = block((6, 4, 4), muscles={"upper": 600.0})
    scene = Scene(body, fixed=["left"], damping=None, reflex=None, force_velocity=False)
    with pytest.raises(SolveError, match=r"no time step from 0 s on could be solved \(stalled\)") as caught:
        scene.simulate(MotorCommands({"upper": 0.5}), 0.05, dt=0.01)
    assert caught.value.status == caught.value.report.status == "stalled"
    assert caught.value.movement.times.tolist() == [0.0]
    assert np.array_equal(caught.value.posture.positions, body.nodes)


def test_interrupted() -> None:
    """Ctrl-C in the middle of a solve; what is left of scenes and movements: ``tests/test_interruption.py``."""
    scene = Scene(block((14, 10, 10), muscles={"upper": 8.0}), fixed=["left"])
    before = signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(SolveInterrupted) as caught:
            scene.equilibrate(FORCE, accuracy="reference")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        signal.signal(signal.SIGINT, usual)
    assert caught.value.posture.report.status == "interrupted"
