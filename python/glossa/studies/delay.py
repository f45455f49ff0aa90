"""The delay of the reflex: what a movement owes to it (section II.C.1)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import xarray as xr

from glossa.checks import finite_number
from glossa.errors import InputError, SolveError
from glossa.motor.commands import vowel_commands
from glossa.motor.schedule import Ramp
from glossa.scene import Scene
from glossa.studies.failure import reason_of
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES, midsagittal_nodes
from glossa.studies.provenance import provenance
from glossa.studies.traces import LATE, even_times, force_traces, node_traces, peak_speeds

DELAYS = (0.005, 0.010, 0.015, 0.017, 0.020)
"""s; the paper varied from 5 to 20 ms and chose 17."""


def delay(
    scene: Scene,
    vowel: str = "i",
    delays: Sequence[float] = DELAYS,
    *,
    until: float = 0.2,
    interval: float = 0.001,
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """The movement from rest to a vowel with several delays of the reflex.

    Args:
        scene: of a speaker with the muscles of Table III and the contour "dorsum", with a reflex.
        vowel: of Table III; the commands ramp from the lengths at rest within 30 ms.
        delays: s, rising, not negative; two or more.
        until: end of the movements, s.
        interval: between samples, s.
        progress: called with a line of text before each run.

    Returns:
        Over ``delay`` (s): ``trace (…, time, node, axis)``, displacement of the six midsagittal nodes from rest, m;
        ``force (…, time, muscle)``, ``peak_force``, ``final_force (…, muscle)``, N; ``peak_speed (…, node)``, m/s;
        ``path_change (…, node)``, largest distance at any time from the movement with the scene's own delay (or the
        nearest to it), m; ``swing (…, node)``, m, how far a node still moves in the last 50 ms, from end to end of its
        range; ``reason``. NaN where a movement failed. The attribute ``reference_delay_s`` is that nearest delay.

    Raises:
        InputError: an unknown vowel, delays that do not rise, a scene without reflex, or a speaker that lacks a muscle
            or the contour.
        SolveInterrupted: Ctrl-C.
    """
    own = vowel_commands(vowel)
    if scene.reflex is None:
        raise InputError("the study of the delay needs a scene with a reflex")
    values = _checked(delays)
    times = even_times(until, interval)
    nodes = list(midsagittal_nodes(scene.speaker).values())
    muscles = list(scene.speaker.muscles)
    trace = np.full((len(values), len(times), len(nodes), 3), math.nan)
    force = np.full((len(values), len(times), len(muscles)), math.nan)
    peak = np.full((len(values), len(muscles)), math.nan)
    speed = np.full((len(values), len(nodes)), math.nan)
    reasons = np.full(len(values), "", dtype=object)
    for k, value in enumerate(values):
        if progress is not None:
            progress(f"delay {value * 1e3:g} ms")
        here = Scene(scene.speaker, **{**scene.options, "reflex": replace(scene.reflex, delay=value)})
        try:
            movement = here.simulate(Ramp(own), until)
        except SolveError as error:
            reasons[k] = reason_of(error)
            continue
        trace[k], force[k] = node_traces(movement, nodes, times), force_traces(movement, times)
        peak[k], speed[k] = movement.forces.to_numpy().max(axis=0), peak_speeds(movement, nodes)
    reference = int(np.abs(np.array(values) - scene.reflex.delay).argmin())
    late = trace[:, times >= until - min(LATE, until)]
    return xr.Dataset(
        {
            "trace": (("delay", "time", "node", "axis"), trace, {"units": "m"}),
            "force": (("delay", "time", "muscle"), force, {"units": "N"}),
            "peak_force": (("delay", "muscle"), peak, {"units": "N"}),
            "final_force": (("delay", "muscle"), force[:, -1], {"units": "N"}),
            "peak_speed": (("delay", "node"), speed, {"units": "m/s"}),
            "path_change": (
                ("delay", "node"),
                np.linalg.norm(trace - trace[reference], axis=3).max(axis=1),
                {"units": "m"},
            ),
            "swing": (("delay", "node"), np.linalg.norm(np.ptp(late, axis=1), axis=2), {"units": "m"}),
            "reason": (("delay",), reasons),
        },
        coords={
            "delay": ("delay", values, {"units": "s"}),
            "time": ("time", times, {"units": "s"}),
            "node": list(MIDSAGITTAL_NODES),
            "axis": ["x", "y", "z"],
            "muscle": muscles,
        },
        attrs=provenance(scene, "delay") | {"vowel": vowel, "reference_delay_s": values[reference]},
    )


def _checked(delays: Sequence[float]) -> list[float]:
    if not isinstance(delays, tuple | list | np.ndarray):
        raise InputError(f"delays must be a list of times in s, got {delays!r}")
    values = [finite_number(value, "delay (s)") for value in delays]
    if len(values) < 2 or any(b <= a for a, b in pairwise(values)) or values[0] < 0.0:
        raise InputError(f"delays must be two or more times in s, rising and not negative, got {values}")
    return values
