"""Growth rate and frequency of a movement about an equilibrium, measured along the shape of a root."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd

from glossa.checks import positive_number
from glossa.errors import InputError
from glossa.linear_motion import ComplexArray, LinearMotion
from glossa.motor.commands import MotorCommands
from glossa.motor.schedule import Schedule
from glossa.results import Movement, Posture
from glossa.scene import Scene
from glossa.studies.stability_basis import reduced_motion
from glossa.studies.stability_roots import Root, rightmost_roots

PULSE = 0.010
"""s, from the start of a disturbance to its end."""

_LEAST_FRAMES = 5
_SHAPES = 8  # of roots that a movement is made of


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Of amplitude(t) = a exp(s t).

    Attributes:
        growth: real part of s, 1/s.
        frequency: Hz.
        misfit: largest distance of the logarithm of the amplitude, or the phase (rad), from a straight line.
    """

    growth: float
    frequency: float
    misfit: float


def growth_in_steps(
    scene: Scene,
    posture: Posture,
    steps: Sequence[float] = (0.002, 0.001, 0.0005),
    *,
    size: float = 1e-5,
    until: float = 0.6,
    integrator: str = "SDIRK2",
) -> pd.DataFrame:
    """Growth and frequency of a slightly disturbed equilibrium in several time steps, beside its rightmost root.

    The root is the rightmost that oscillates; its growth is measured in the last third of the movement.

    Args:
        scene: with a reflex, that the posture is an equilibrium of.
        posture: with commands.
        steps: s.
        size: of the disturbance, as a share of the commands.
        until: end of the movements, s.
        integrator: as for :meth:`glossa.Scene.simulate`.

    Returns:
        By step (s), and "root": ``growth`` (1/s), ``frequency`` (Hz), ``misfit``.

    Raises:
        InputError: no root that oscillates, or as for :func:`disturbed`.
        SolveError: a step failed.
    """
    motion = scene.linearise(posture)
    roots = rightmost_roots(motion, reduced_motion(motion), motion.delay, motion.velocity_gain, _SHAPES)
    first = next((root for root in roots if root.frequency > 0.0), None)
    if first is None:
        raise InputError(f"none of the {len(roots)} rightmost roots about this posture oscillates")
    shapes = [_on_nodes(motion, root) for root in [first, *(root for root in roots if root is not first)]]
    rows = {}
    for step in steps:
        movement = disturbed(scene, posture, until, size=size, dt=step, integrator=integrator)
        rows[f"{step:g}"] = asdict(measured_root(movement, shapes, (until * 2.0 / 3.0, until)))
    rows["root"] = {"growth": first.value.real, "frequency": first.frequency, "misfit": 0.0}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("step")


def _on_nodes(motion: LinearMotion, root: Root) -> ComplexArray:
    """(n, 3) shape of a root on the speaker's nodes; real for a real root."""
    shape = motion.nodes_of(root.shape.real).astype(complex)
    if root.frequency > 0.0:
        shape.imag = motion.nodes_of(root.shape.imag)
    return shape


def disturbed(
    scene: Scene,
    posture: Posture,
    until: float,
    *,
    size: float,
    dt: float,
    integrator: str | None = None,
) -> Movement:
    """Movement from an equilibrium whose commands are changed by a share of themselves, and changed back within 10 ms.

    Args:
        scene: that the posture is an equilibrium of.
        posture: with commands.
        until: end, s.
        size: share, small.
        dt: step, s.
        integrator: as for :meth:`glossa.Scene.simulate`.

    Raises:
        InputError: a posture without commands.
        SolveError: a step failed.
    """
    own = posture.commands
    if own is None:
        raise InputError("disturbed: this posture has no commands to disturb")
    pulse = MotorCommands({name: (1.0 - size) * value for name, value in own.items()})
    schedule = Schedule([0.0, 0.5 * PULSE, PULSE], [own, pulse, own])
    return scene.simulate(
        schedule, positive_number(until, "until"), dt=dt, accuracy="reference", initial=posture, integrator=integrator
    )


def measured_root(movement: Movement, shapes: Sequence[ComplexArray], window: tuple[float, float]) -> Measured:
    """Growth and frequency of the first of several shapes within a window of time.

    Velocities are fitted by Sum_k Re(z_k(t) shape_k) at every time: of a root, z_k = exp(s_k t). The shapes of other
    roots take their parts away. Real shapes belong to real roots. Velocities, because friction leaves a disturbed body
    in another place.

    Args:
        movement: about an equilibrium.
        shapes: (n, 3) each, complex.
        window: s, s.

    Raises:
        InputError: no shape, or fewer than five frames in the window.
    """
    inside = (movement.times >= window[0]) & (movement.times <= window[1])
    times = movement.times[inside]
    if len(times) < _LEAST_FRAMES or not len(shapes):
        raise InputError(f"{len(shapes)} shapes, {len(times)} frames from {window[0]:g} to {window[1]:g} s: too few")
    speeds = movement.velocities[inside].reshape(len(times), -1)
    flats = [shape.ravel() / np.abs(shape).max() for shape in shapes]
    axes = [flat.real for flat in flats] + [-flat.imag for flat in flats if flat.imag.any()]
    parts = np.linalg.lstsq(np.stack(axes, axis=1), speeds.T, rcond=None)[0]
    place = parts[0].astype(complex)
    place = place + 1j * parts[len(flats)] if flats[0].imag.any() else np.abs(place)
    logs, turns = np.log(np.abs(place)), np.unwrap(np.angle(place))
    growth, level = np.polyfit(times, logs, 1)
    speed, phase = np.polyfit(times, turns, 1)
    misfit = max(np.abs(logs - growth * times - level).max(), np.abs(turns - speed * times - phase).max())
    return Measured(
        growth=float(growth),
        frequency=abs(float(speed)) / (2.0 * np.pi),
        misfit=float(misfit),
    )
