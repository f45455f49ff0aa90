"""What gravity does to the tongue: section V of the paper, figs 12 and 13."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from glossa.anatomy.arrays import FloatArray
from glossa.checks import positive_number
from glossa.errors import InputError, SolveError
from glossa.motor.commands import VOWELS, MotorCommands
from glossa.motor.schedule import Ramp
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.acoustics import posture_formants
from glossa.studies.failure import reason_of
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES, midsagittal_nodes
from glossa.studies.points import hyoid_pose, tracked_nodes
from glossa.studies.provenance import provenance
from glossa.studies.traces import LATE, even_times, node_traces

DIRECTIONS: tuple[str, ...] = ("upright", "supine", "none")
"""Of gravity."""

CONTROLS: tuple[str, ...] = ("silent", "reflex")
"""No muscle force at all, and every command equal to the length at rest (section V.A)."""

CARDINALS: tuple[str, ...] = ("i", "u", "a")

Progress = Callable[[str], None]


def gravity(
    scene: Scene,
    vowels: Sequence[str] = CARDINALS,
    *,
    until: float = 1.0,
    vowel_until: float = 0.2,
    progress: Progress | None = None,
) -> xr.Dataset:
    """:func:`gravity_at_rest` and :func:`gravity_of_vowels` in one table; scenes differ in their gravity only.

    Args:
        scene: of a speaker with tip, dorsum and walls; its own gravity does not matter.
        vowels: of Table III.
        until: end of the movements of the tongue without commands, s.
        vowel_until: end of the movements to vowels, s.
        progress: called with a line of text before each run.

    Raises:
        InputError: impossible arguments.
        SolveInterrupted: Ctrl-C.
    """
    at_rest = gravity_at_rest(scene, until=until, progress=progress)
    of_vowels = gravity_of_vowels(scene, vowels, until=vowel_until, progress=progress)
    return xr.merge([at_rest, of_vowels], join="exact", compat="no_conflicts", combine_attrs="no_conflicts")


def gravity_at_rest(
    scene: Scene,
    *,
    until: float = 1.0,
    interval: float = 0.005,
    progress: Progress | None = None,
) -> xr.Dataset:
    """The tongue without motor commands under gravity: equilibrium, and movement from rest (section V.A).

    Args:
        scene: of a speaker with tip and dorsum.
        until: end of the movement, s (the paper: 1 s).
        interval: between samples of the movement, s.
        progress: called with a line of text before each run.

    Returns:
        Over ``control`` (silent, reflex) and ``gravity`` (upright, supine, none), displacements from rest in m:
        ``static (…, vertex, axis)`` of every node in equilibrium, ``final`` the same at the end of the movement,
        ``static_tip``, ``final_tip (…, axis)``, ``tip_trace (…, time, axis)``; ``static_hyoid``, ``final_hyoid (…,
        part, axis)``: displacement (m), rotation vector (rad) and centre at rest (m) of a mobile hyoid, NaN without;
        ``static_reason``, ``final_reason``: why there is no number, empty where there is one.

    Raises:
        InputError: impossible arguments.
        SolveInterrupted: Ctrl-C.
    """
    times = even_times(until, interval)
    tip = tracked_nodes(scene.speaker)["tip"]
    shape = (len(CONTROLS), len(DIRECTIONS))
    everything, axes = len(scene.speaker.nodes), 3
    found = {
        f"{how}{what}": np.full((*shape, *size), math.nan)
        for how in ("static", "final")
        for what, size in (("", (everything, axes)), ("_hyoid", (3, axes)))
    }
    traces = np.full((*shape, len(times), axes), math.nan)
    reasons = {how: np.full(shape, "", dtype=object) for how in ("static", "final")}
    for place in np.ndindex(shape):
        control, direction = CONTROLS[place[0]], DIRECTIONS[place[1]]
        if progress is not None:
            progress(f"{control}, {direction}")
        here = _turned(scene, direction)
        commands = None if control == "silent" else MotorCommands(dict.fromkeys(scene.speaker.muscles, 1.0))
        try:
            _keep(found, "static", place, here.equilibrate(commands))
        except SolveError as error:
            reasons["static"][place] = reason_of(error)
        try:
            movement = here.simulate(commands, until)
        except SolveError as error:
            reasons["final"][place] = reason_of(error)
            continue
        traces[place] = node_traces(movement, [tip], times)[:, 0]
        _keep(found, "final", place, movement.at(float(movement.times[-1])))
    return _rest_table(scene, found, traces, reasons, times, tip)


def _turned(scene: Scene, direction: str) -> Scene:
    """The same scene under another gravity."""
    return Scene(scene.speaker, **{**scene.options, "gravity": None if direction == "none" else direction})


def _keep(found: dict[str, FloatArray], how: str, place: tuple[int, ...], posture: Posture) -> None:
    found[how][place] = posture.displacements
    found[f"{how}_hyoid"][place] = hyoid_pose(posture)


def _rest_table(
    scene: Scene,
    found: dict[str, FloatArray],
    traces: FloatArray,
    reasons: dict[str, Any],
    times: FloatArray,
    tip: int,
) -> xr.Dataset:
    case = ("control", "gravity")
    dims = {"": ("vertex", "axis"), "_hyoid": ("part", "axis")}
    return xr.Dataset(
        {
            **{
                name: ((*case, *dims[name.removeprefix("static").removeprefix("final")]), values, {"units": "m"})
                for name, values in found.items()
            },
            "static_tip": ((*case, "axis"), found["static"][:, :, tip], {"units": "m"}),
            "final_tip": ((*case, "axis"), found["final"][:, :, tip], {"units": "m"}),
            "tip_trace": ((*case, "time", "axis"), traces, {"units": "m"}),
            **{f"{how}_reason": (case, words) for how, words in reasons.items()},
        },
        coords={
            "control": list(CONTROLS),
            "gravity": list(DIRECTIONS),
            "time": ("time", times, {"units": "s"}),
            "axis": ["x", "y", "z"],
            "part": ["displacement", "rotation", "centre"],
        },
        attrs=provenance(scene, "gravity"),
    )


@dataclass(frozen=True)
class _Spoken:
    """What one movement to a vowel, and its equilibrium, leave."""

    peak: FloatArray
    final: FloatArray
    swing: FloatArray
    static: FloatArray
    nodes: FloatArray
    formants: FloatArray
    reason: str


def gravity_of_vowels(
    scene: Scene,
    vowels: Sequence[str] = CARDINALS,
    *,
    until: float = 0.2,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Movements to vowels upright and supine, with the same commands and timing (section V.B).

    They start from the rest positions; the commands ramp from the lengths at rest within 30 ms.

    Args:
        scene: of a speaker with the muscles of Table III; formants need walls.
        vowels: of Table III.
        until: end of the movement, s.
        progress: called with a line of text before each run.

    Returns:
        Over ``vowel`` and ``position`` (upright, supine): ``peak_force``, ``final_force (…, acting)`` N of the
        movement, ``force_swing``, range of the force in its last 50 ms, N: large where the delayed reflex keeps it
        from settling, so that the final force is one moment of many; ``static_force``, N, of the equilibrium;
        ``final_nodes (…, node, axis)`` displacement of the six midsagittal nodes from rest in m, ``final_formants
        (…, formant)`` Hz, ``vowel_reason``. Over ``vowel``, supine against upright: ``peak_change``, ``final_change``,
        ``static_change (…, acting)`` in percent, NaN where the force upright is below 0.01 N, ``node_change
        (…, node)``, m, ``formant_change (…, formant)``, Hz.

    Raises:
        InputError: no vowel, an unknown one, or impossible arguments.
        SolveInterrupted: Ctrl-C.
    """
    names = list(vowels)
    unknown = [name for name in names if name not in VOWELS]
    if unknown or not names:
        raise InputError(f"vowels must be some of {', '.join(VOWELS)}, got {', '.join(map(str, unknown)) or 'none'}")
    end = positive_number(until, "until (s)")
    positions = DIRECTIONS[:2]
    scenes = {direction: _turned(scene, direction) for direction in positions}
    spoken = []
    for name in names:
        for direction, here in scenes.items():
            if progress is not None:
                progress(f"/{name}/, {direction}")
            spoken.append(_spoken(here, name, end))
    shape = (len(names), len(positions))

    def table(values: Sequence[Any]) -> Any:
        array = np.stack(values)
        return array.reshape(*shape, *array.shape[1:])

    case = ("vowel", "position")
    result = xr.Dataset(
        {
            "peak_force": ((*case, "acting"), table([one.peak for one in spoken]), {"units": "N"}),
            "final_force": ((*case, "acting"), table([one.final for one in spoken]), {"units": "N"}),
            "force_swing": ((*case, "acting"), table([one.swing for one in spoken]), {"units": "N"}),
            "static_force": ((*case, "acting"), table([one.static for one in spoken]), {"units": "N"}),
            "final_nodes": ((*case, "node", "axis"), table([one.nodes for one in spoken]), {"units": "m"}),
            "final_formants": ((*case, "formant"), table([one.formants for one in spoken]), {"units": "Hz"}),
            "vowel_reason": (case, np.array([one.reason for one in spoken], dtype=object).reshape(shape)),
        },
        coords={
            "vowel": names,
            "position": list(positions),
            "acting": list(scene.speaker.muscles),
            "node": list(MIDSAGITTAL_NODES),
            "axis": ["x", "y", "z"],
            "formant": [1, 2, 3, 4],
        },
        attrs=provenance(scene, "gravity") | {"vowel_until_s": end},
    )
    return result.assign(_changes(result))


FORCES = ("peak", "final", "static")
"""Of a movement: the largest force, and that at its end; and the force in equilibrium."""

LEAST_FORCE = 0.01
"""Force from which its change is told in percent, N: the last digit of Table II."""


def _changes(spoken: xr.Dataset) -> dict[str, xr.DataArray]:
    upright, supine = (spoken.sel(position=direction, drop=True) for direction in DIRECTIONS[:2])
    forces = {}
    for name in FORCES:
        before, after = upright[f"{name}_force"], supine[f"{name}_force"]
        change = (100.0 * (after / before.where(before >= LEAST_FORCE) - 1.0)).assign_attrs(units="%")
        forces[f"{name}_change"] = change
    moved = supine["final_nodes"] - upright["final_nodes"]
    return {
        **forces,
        "node_change": ((moved**2).sum("axis", skipna=False) ** 0.5).assign_attrs(units="m"),
        "formant_change": (supine["final_formants"] - upright["final_formants"]).assign_attrs(units="Hz"),
    }


def _spoken(scene: Scene, vowel: str, until: float) -> _Spoken:
    gap = np.full(len(scene.speaker.muscles), math.nan)
    nodes = list(midsagittal_nodes(scene.speaker).values())
    static = gap
    try:
        static = np.asarray(scene.equilibrate(VOWELS[vowel]).forces, dtype=np.float64)
        movement = scene.simulate(Ramp(VOWELS[vowel]), until)
    except SolveError as error:
        return _Spoken(
            gap, gap, gap, static, np.full((len(nodes), 3), math.nan), np.full(4, math.nan), reason_of(error)
        )
    forces = movement.forces.to_numpy()
    late = forces[movement.times >= movement.times[-1] - LATE]
    values, reason = posture_formants(movement.at(float(movement.times[-1])), vowel)
    moved = movement.positions[-1][nodes] - scene.speaker.nodes[nodes]
    return _Spoken(forces.max(axis=0), forces[-1], np.ptp(late, axis=0), static, moved, values, reason)
