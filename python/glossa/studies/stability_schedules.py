"""Movements to random targets in several time steps: do they end where the spectrum of the delayed loop says?

A movement to constant commands ends in the equilibrium of its target where every root of the loop about it decays, and
in a cycle where one grows, however long its time steps are. What differs between steps is the integrator's.

The equilibrium is the one that the movement has come to: a target may have a second one, and friction as many as there
are ways to it. It is solved from the end of the movement in the shortest steps.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr

from glossa.anatomy.arrays import FloatArray
from glossa.checks import positive_number, whole_number
from glossa.data_files import data_path
from glossa.errors import InputError, SolveError
from glossa.motor.commands import VOWELS, MotorCommands
from glossa.motor.schedule import Ramp
from glossa.results import Movement, Posture
from glossa.scene import Scene
from glossa.studies.failure import reason_of
from glossa.studies.machine import machine
from glossa.studies.provenance import solve_provenance
from glossa.studies.stability import posture_roots
from glossa.studies.traces import even_times, node_traces

STEPS = (0.001, 0.002, 0.005, 0.010)
"""s."""

COMMITTED = "results/stability_movements.nc"
"""Data file with fifty ramps of the built-in speaker under several conditions."""

LATE = 0.25
"""End of a movement in which its cycle is measured, s."""

SPREAD = 0.1
"""Of the random commands about those of a vowel, relative."""

DURATIONS = (0.020, 0.100)
"""Of the ramps, s."""

_SAMPLE = 0.0005  # s, between samples of a cycle
_PADDING = 16  # of the transform from which a frequency is read
_MEASURES = {"distance": "m", "apart": "m", "swing": "m", "frequency": "Hz", "seconds": "s"}
_ROOT = {"growth": "1/s", "root_frequency": "Hz", "linear_range": "m", "residual": "1"}


@dataclass(frozen=True)
class RandomRamp:
    """A ramp from rest to random commands about those of a vowel."""

    vowel: str
    target: MotorCommands
    duration: float


def random_ramps(count: int, seed: int, vowels: Sequence[str] = tuple(VOWELS)) -> list[RandomRamp]:
    """Ramps of 20 to 100 ms to commands within 10 % of a vowel's, the vowels in turn.

    Args:
        count: how many.
        seed: of the random numbers; the first ramps of a longer list are those of a shorter one.
        vowels: of Table III.

    Raises:
        InputError: no ramp or no vowel is asked for.
    """
    whole_number(count, "count", 1, 100_000)
    if not vowels:
        raise InputError("random_ramps needs a vowel")
    rng = np.random.default_rng(whole_number(seed, "seed", 0, 2**32 - 1))
    ramps = []
    for k in range(count):
        vowel = vowels[k % len(vowels)]
        own = VOWELS[vowel]
        share = 1.0 + rng.uniform(-SPREAD, SPREAD, len(own))
        target = MotorCommands(dict(zip(own, (np.array(list(own.values())) * share).tolist(), strict=True)))
        ramps.append(RandomRamp(vowel, target, float(rng.uniform(*DURATIONS))))
    return ramps


def movements_in_steps(
    scene: Scene,
    ramps: Sequence[RandomRamp],
    steps: Sequence[float] = STEPS,
    *,
    until: float = 1.0,
    integrator: str | None = None,
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Every ramp in every step, and the rightmost root about the equilibrium it comes to.

    Args:
        scene: with a reflex.
        ramps: of :func:`random_ramps`.
        steps: s, rising.
        until: end of the movements, s; longer than ``LATE``.
        integrator: as for :meth:`glossa.Scene.simulate`.
        progress: called with a line of text before each ramp.

    Returns:
        Over ``ramp`` and ``step`` (s): ``distance`` of the node farthest from its place in the equilibrium at the end,
        m; ``apart``, the same from its place at the end of the movement in the shortest steps; ``swing``, largest range
        of a node in the last 0.25 s, m; ``frequency`` of that node there, Hz (the node of the shortest step counts; NaN
        below a nanometre); ``seconds`` of processor time; ``reason``. Over ``ramp``:
        ``growth`` (1/s) and ``root_frequency`` (Hz) of the rightmost root, its ``muscle`` and ``linear_range`` (m);
        ``other_equilibrium``: how far the equilibrium found from rest is from the one the movement comes to, m;
        ``vowel``, ``duration`` (s), ``equilibrium_reason``. NaN where something failed.

    Raises:
        InputError: no ramp, steps that do not rise, or a movement that is too short.
        SolveInterrupted: Ctrl-C.
    """
    values = [positive_number(step, "steps (s)") for step in steps]
    if not values or any(b <= a for a, b in pairwise(values)) or not ramps:
        raise InputError(f"steps must be one or more times in s that rise, and there must be a ramp; got {list(steps)}")
    if positive_number(until, "until (s)") <= LATE:
        raise InputError(f"until must be longer than {LATE:g} s, got {until!r} s")
    rows = []
    for number, ramp in enumerate(ramps):
        if progress is not None:
            progress(f"ramp {number + 1} of {len(ramps)}, to {ramp.vowel}")
        rows.append(_row(scene, ramp, values, until, integrator))
    result = xr.concat(rows, dim="ramp").assign_coords(step=("step", values, {"units": "s"}))
    result.attrs = {
        "study": "movements_in_steps",
        "until_s": until,
        "integrator": integrator or ("BDF2" if scene.contact else "SDIRK2"),
        "effects": ", ".join(scene.effects),
        **solve_provenance(scene),
        **machine(),
    }
    return result


def committed_movements() -> dict[str, xr.Dataset]:
    """The movements that come with the package, by condition, as :func:`movements_in_steps` returns them.

    Raises:
        InputError: their file is not there.
    """
    with xr.open_dataset(data_path(COMMITTED), engine="h5netcdf") as opened:
        loaded = opened.load()
    return {name: loaded.sel(condition=name, drop=True) for name in loaded["condition"].values.tolist()}


def agreement(study: xr.Dataset) -> xr.Dataset:
    """Whether movements end as the spectrum says, by ramp.

    Args:
        study: of :func:`movements_in_steps`.

    Returns:
        ``stable``: no root grows. ``farthest`` and ``apart``: where stable, largest distance from the equilibrium, and
        from the end in the shortest steps, over the steps, m.
        ``swing_change`` and ``frequency_change``: where unstable, relative change from the shortest step to the next.
    """
    stable = study["growth"] < 0.0
    first, second = study.isel(step=0), study.isel(step=min(1, study.sizes["step"] - 1))
    unstable = study["growth"] > 0.0
    return xr.Dataset(
        {
            "stable": stable,
            "farthest": study["distance"].max("step", skipna=False).where(stable),
            "apart": study["apart"].max("step", skipna=False).where(stable),
            "swing_change": (abs(second["swing"] / first["swing"] - 1.0)).where(unstable),
            "frequency_change": (abs(second["frequency"] / first["frequency"] - 1.0)).where(unstable),
        }
    ).drop_vars("step", errors="ignore")


def _row(scene: Scene, ramp: RandomRamp, steps: Sequence[float], until: float, integrator: str | None) -> xr.Dataset:
    movements: list[Movement | None] = []
    reasons, seconds = [], []
    for step in steps:
        begin = time.process_time()
        try:
            movements.append(scene.simulate(Ramp(ramp.target, ramp.duration), until, dt=step, integrator=integrator))
            reasons.append("")
        except SolveError as error:
            movements.append(None)
            reasons.append(reason_of(error))
        seconds.append(time.process_time() - begin)
    shortest = next((one for one in movements if one is not None), None)
    rest, root, trouble = _equilibrium(scene, ramp, shortest)
    node = 0 if shortest is None else _swinging(shortest)
    measured = {name: np.full(len(steps), math.nan) for name in _MEASURES}
    measured["seconds"][:] = seconds
    for k, movement in enumerate(movements):
        if movement is None or shortest is None:
            continue
        measured["apart"][k] = _farthest(movement.positions[-1], shortest.positions[-1])
        measured["swing"][k], measured["frequency"][k] = cycle(movement, node)
        if rest is not None:
            measured["distance"][k] = _farthest(movement.positions[-1], rest.positions)
    return xr.Dataset(
        {name: (("step",), array, {"units": _MEASURES[name]}) for name, array in measured.items()}
        | {name: ((), root[name], {"units": unit}) for name, unit in _ROOT.items()}
        | {
            "other_equilibrium": ((), root["other_equilibrium"], {"units": "m"}),
            "muscle": ((), trouble[1]),
            "reason": (("step",), np.array(reasons)),
            "equilibrium_reason": ((), trouble[0]),
            "vowel": ((), ramp.vowel),
            "duration": ((), ramp.duration, {"units": "s"}),
        }
    )


def _farthest(places: FloatArray, others: FloatArray) -> float:
    """Largest distance of a node from its other place, m."""
    return float(np.linalg.norm(places - others, axis=1).max())


def _equilibrium(
    scene: Scene, ramp: RandomRamp, movement: Movement | None
) -> tuple[Posture | None, dict[str, float], tuple[str, str]]:
    """The equilibrium that a movement has come to, its rightmost root, and (why there is none, the root's muscle)."""
    root = dict.fromkeys([*_ROOT, "other_equilibrium"], math.nan)
    if movement is None:
        return None, root, ("no movement", "")
    try:
        posture = scene.equilibrate(ramp.target, start=movement.at(float(movement.times[-1])))
    except SolveError as error:
        return None, root, (reason_of(error), "")
    roots = posture_roots(scene, posture, 2)
    muscle = ""
    if len(roots):
        first = roots.rename(columns={"frequency": "root_frequency"}).iloc[0]
        root |= {name: float(first[name]) for name in _ROOT}
        muscle = str(first["muscle"])
    try:
        other = scene.equilibrate(ramp.target)
        root["other_equilibrium"] = _farthest(other.positions, posture.positions)
    except SolveError:
        pass
    return posture, root, ("", muscle)


def cycle(movement: Movement, node: int) -> tuple[float, float]:
    """Range (m) and frequency (Hz) of a node in the last quarter of a second, along the line it mostly moves on.

    The frequency is where the spectrum, under a Hann window, is largest; NaN where the node moves by less than 1 nm.
    """
    end = float(movement.times[-1])
    trace = node_traces(movement, [node], end - LATE + even_times(LATE, _SAMPLE))[:, 0]
    trace = trace - trace.mean(axis=0)
    line = trace @ np.linalg.svd(trace, full_matrices=False)[2][0]
    swing = float(np.ptp(line))
    if swing < 1e-9:
        return swing, math.nan
    return swing, _frequency(line)


def _frequency(values: FloatArray) -> float:
    """Largest peak of the spectrum, Hz, by a parabola through its logarithm."""
    drift = np.polyval(np.polyfit(np.arange(len(values)), values, 2), np.arange(len(values)))
    window = np.hanning(len(values))
    power = np.abs(np.fft.rfft((values - drift) * window, _PADDING * len(values)))
    k = int(np.clip(power.argmax(), 1, len(power) - 2))
    a, b, c = np.log(power[k - 1 : k + 2] + 1e-300)
    shift = 0.5 * (a - c) / (a - 2.0 * b + c) if a - 2.0 * b + c < 0.0 else 0.0
    return float((k + shift) / (_PADDING * len(values) * _SAMPLE))


def _swinging(movement: Movement) -> int:
    """The node with the largest range in the last quarter of a second."""
    late = movement.positions[movement.times >= movement.times[-1] - LATE]
    return int(np.linalg.norm(np.ptp(late, axis=0), axis=1).argmax())
