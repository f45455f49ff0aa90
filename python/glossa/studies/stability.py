"""Physical against numerical instability of the delayed reflex loop: rightmost roots about postures, and a chart.

Each posture is linearised with its delayed reflex (glossa/linear_motion.py). Delay d and velocity gain mu of the reflex
do not move an equilibrium; the gradient c of the force law (eq. 3) does, so that each c has its own. What oscillates
where a root has positive growth is the model, whatever the integrator; what oscillates elsewhere is the integrator.

Growth is that of small movements. Fibres that are hardly active have their full reflex gain and hardly any damping of
their own (eq. 5 damps in proportion to force); such a loop grows fast and stops growing as soon as the fibre falls
silent for a part of each cycle, with micrometres. ``linear_range`` tells how far.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from glossa.checks import not_negative_number, positive_number, whole_number
from glossa.data_files import data_path
from glossa.errors import InputError, SolveError
from glossa.linear_motion import LinearMotion
from glossa.motor.commands import MotorCommands, vowel_commands
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.failure import reason_of
from glossa.studies.machine import machine
from glossa.studies.provenance import solve_provenance
from glossa.studies.stability_basis import reduced_motion
from glossa.studies.stability_loci import LoopLoci, delay_margin, loop_loci, unstable_roots
from glossa.studies.stability_roots import SEEN, Root, rightmost_roots

DELAYS = (0.0, 0.005, 0.010, 0.017, 0.025, 0.035, 0.050)
"""s."""

VELOCITY_GAINS = (0.0, 0.005, 0.010, 0.020, 0.030, 0.050)
"""mu of eq. 2, s."""

FIRING_GRADIENTS = (40.0, 112.0)
"""c of eq. 3, 1/m: the paper's, and the value of the literature that it found unstable."""

COMMITTED = "results/stability.nc"
"""Data file with the study of the built-in speaker."""

BORDER = 61
"""Velocity gains at which the border of stability is drawn."""

CHAIN = 100.0
"""Hz: loop gains above 1 beyond this make a chain of unstable roots that only inertia ends."""

_DRIVING = 0.1  # of the strongest fibre's part in a root
_VALUES = {"growth": "1/s", "frequency": "Hz", "residual": "1", "linear_range": "m"}


@dataclass(frozen=True, kw_only=True)
class StabilityGrid:
    """Where roots are looked for, each list rising.

    Attributes:
        delays: d, s.
        velocity_gains: mu, s.
        firing_gradients: c, 1/m.
        roots: of each point.
    """

    delays: Sequence[float] = DELAYS
    velocity_gains: Sequence[float] = VELOCITY_GAINS
    firing_gradients: Sequence[float] = FIRING_GRADIENTS
    roots: int = 3

    def __post_init__(self) -> None:
        for name, check in (("delays", not_negative_number), ("velocity_gains", not_negative_number)):
            _rising(name, [check(value, name) for value in getattr(self, name)])
        _rising("firing_gradients", [positive_number(value, "firing_gradients") for value in self.firing_gradients])
        whole_number(self.roots, "roots", 1, 100)


def stability(
    scene: Scene,
    postures: str | Sequence[str] | Mapping[str, MotorCommands] = "i",
    grid: StabilityGrid | None = None,
    *,
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Rightmost roots of the delayed loop about equilibria.

    Args:
        scene: with a reflex; its delay, velocity gain and firing gradient give way to those of the grid.
        postures: vowels of Table III, or commands by name.
        grid: of d, mu and c.
        progress: called with a line of text before each equilibrium.

    Returns:
        Over ``posture``, ``firing_gradient`` (1/m), ``velocity_gain`` (s), ``delay`` (s) and ``root``, rightmost first,
        NaN where fewer converge: ``growth`` (1/s), ``frequency`` (Hz), ``residual`` of the characteristic equation of
        the whole body, ``muscle`` whose fibres have the largest part, ``linear_range``, motion of the fastest node (m)
        at which the first of the fibres that drive it falls silent. ``unstable``: number of all unstable roots, by the
        loci of the loop gain, NaN where it cannot be told. ``growth_beyond``: most that the loop gain lets roots grow
        of which the frequency is too high for the discretised delay, 1/s. ``chain_gain``: largest loop gain above
        100 Hz.
        ``border_delay`` (s): up to where no root is unstable, over ``border_gain`` (s). ``reason`` why an equilibrium
        has none.

    Raises:
        InputError: unknown vowels, or a scene without reflex.
        SolveInterrupted: Ctrl-C.
    """
    if scene.reflex is None:
        raise InputError("the study of stability needs a scene with a reflex")
    chosen = _commands(postures)
    wanted = grid or StabilityGrid()
    rows = []
    for name, commands in chosen.items():
        for c in wanted.firing_gradients:
            if progress is not None:
                progress(f"{name}, c = {c:g} per m")
            rows.append(_about(Scene(scene.speaker, **{**scene.options, "firing_gradient": c}), commands, wanted))
    by_posture = [
        xr.concat(rows[k : k + len(wanted.firing_gradients)], dim="firing_gradient")
        for k in range(0, len(rows), len(wanted.firing_gradients))
    ]
    result = xr.concat(by_posture, dim="posture")
    result = result.assign_coords(
        posture=list(chosen), firing_gradient=("firing_gradient", list(wanted.firing_gradients), {"units": "1/m"})
    )
    own = {"delay_s": scene.reflex.delay, "velocity_gain_s": scene.reflex.velocity_gain}
    result.attrs = {"study": "stability", **own, **solve_provenance(scene), **machine()}
    result.attrs["effects"] = ", ".join(scene.effects)
    result.attrs["commands"] = str({name: dict(commands) for name, commands in chosen.items()})
    return result


def posture_roots(scene: Scene, posture: Posture, count: int = 4) -> pd.DataFrame:
    """Rightmost roots about an equilibrium with the scene's own reflex, rightmost first.

    Args:
        scene: that the posture is an equilibrium of.
        posture: of :meth:`glossa.Scene.equilibrate`.
        count: of roots, complex pairs once.

    Returns:
        ``growth`` (1/s), ``frequency`` (Hz), ``muscle``, ``linear_range`` (m), ``residual``, as :func:`stability`.

    Raises:
        InputError: a posture that is no equilibrium of this scene.
    """
    motion = scene.linearise(posture)
    found = rightmost_roots(motion, reduced_motion(motion), motion.delay, motion.velocity_gain, count)
    rows = [
        (r.value.real, r.frequency, strongest_muscle(motion, r), linear_range(motion, r), r.residual) for r in found
    ]
    return pd.DataFrame(rows, columns=["growth", "frequency", "muscle", "linear_range", "residual"])


def committed_stability() -> xr.Dataset:
    """The study that comes with the package: the four vowels of the built-in speaker.

    Raises:
        InputError: its file is not there.
    """
    with xr.open_dataset(data_path(COMMITTED), engine="h5netcdf") as opened:
        return opened.load()


def check_stability(study: xr.Dataset) -> None:
    """Raises InputError unless this is a study of stability."""
    if study.attrs.get("study") != "stability":
        raise InputError(f"this needs a Dataset of studies.stability, got one of {study.attrs.get('study')!r}")


def _about(scene: Scene, commands: MotorCommands, grid: StabilityGrid) -> xr.Dataset:
    """Everything about one equilibrium."""
    shape = (len(grid.velocity_gains), len(grid.delays), grid.roots)
    values = {name: np.full(shape, math.nan) for name in _VALUES}
    muscles = np.full(shape, "", dtype=object)
    unstable, beyond = np.full(shape[:2], math.nan), np.full(shape[:2], math.nan)
    chain = np.full(shape[0], math.nan)
    gains = np.linspace(0.0, max(grid.velocity_gains[-1], 1e-3), BORDER)
    border = np.full(BORDER, math.nan)
    reason = ""
    try:
        motion = scene.linearise(scene.equilibrate(commands))
    except SolveError as error:
        reason = reason_of(error)
    else:
        loci = loop_loci(motion)
        border[:] = [delay_margin(loci, gain) for gain in gains]
        reduced = reduced_motion(motion)
        for i, gain in enumerate(grid.velocity_gains):
            chain[i] = loci.largest_gain(gain, CHAIN)
            for j, delay in enumerate(grid.delays):
                count = unstable_roots(loci, delay, gain)
                unstable[i, j] = math.nan if count is None else count
                beyond[i, j] = _growth_beyond(loci, delay, gain)
                for k, root in enumerate(rightmost_roots(motion, reduced, delay, gain, grid.roots)):
                    muscles[i, j, k] = strongest_muscle(motion, root)
                    found = (root.value.real, root.frequency, root.residual, linear_range(motion, root))
                    for name, value in zip(_VALUES, found, strict=True):
                        values[name][i, j, k] = value
    dims = ("velocity_gain", "delay", "root")
    return xr.Dataset(
        {name: (dims, array, {"units": _VALUES[name]}) for name, array in values.items()}
        | {
            "muscle": (dims, muscles.astype(str)),
            "unstable": (dims[:2], unstable),
            "growth_beyond": (dims[:2], beyond, {"units": "1/s"}),
            "chain_gain": (dims[:1], chain, {"units": "1"}),
            "border_delay": (("border_gain",), border, {"units": "s"}),
            "reason": ((), reason),
        },
        coords={
            "delay": ("delay", list(grid.delays), {"units": "s"}),
            "velocity_gain": ("velocity_gain", list(grid.velocity_gains), {"units": "s"}),
            "border_gain": ("border_gain", gains, {"units": "s"}),
        },
    )


def _growth_beyond(loci: LoopLoci, delay: float, velocity_gain: float) -> float:
    """|exp(-s d) (1 + mu s) h| = 1 at a root, and h falls to the right of the imaginary axis."""
    if delay == 0.0:
        return -math.inf
    gain = loci.largest_gain(velocity_gain, SEEN / (2.0 * math.pi * delay))
    return math.log(gain) / delay if gain > 0.0 else -math.inf


def strongest_muscle(motion: LinearMotion, root: Root) -> str:
    """The muscle whose fibres' forces have the largest part in a root; empty without fibres."""
    parts = _parts(motion, root)
    sums = {name: float(parts[np.array(motion.muscles) == name].sum()) for name in dict.fromkeys(motion.muscles)}
    return max(sums, key=lambda name: sums[name]) if sums else ""


def linear_range(motion: LinearMotion, root: Root) -> float:
    """Motion of the fastest node (m) at which the first fibre that drives a root falls silent; inf without fibres."""
    parts = _parts(motion, root)
    driving = parts > _DRIVING * parts.max(initial=0.0)
    if not driving.any():
        return math.inf
    share = float((motion.activations[driving] / np.abs(root.activations[driving])).min())
    moved = motion.nodes_of(root.shape.real) ** 2 + motion.nodes_of(root.shape.imag) ** 2
    return share * math.sqrt(float(moved.sum(axis=1).max()))


def _parts(motion: LinearMotion, root: Root) -> Any:
    return np.abs(root.activations) * np.linalg.norm(motion.pulls, axis=0)


def _commands(postures: str | Sequence[str] | Mapping[str, MotorCommands]) -> dict[str, MotorCommands]:
    if isinstance(postures, Mapping):
        found = {str(name): MotorCommands(commands) for name, commands in postures.items()}
    else:
        found = {name: vowel_commands(name) for name in ([postures] if isinstance(postures, str) else postures)}
    if not found:
        raise InputError("no posture is given")
    return found


def _rising(name: str, values: Sequence[float]) -> None:
    if not values or any(b <= a for a, b in pairwise(values)):
        raise InputError(f"{name} must be one or more numbers that rise, got {list(values)}")
