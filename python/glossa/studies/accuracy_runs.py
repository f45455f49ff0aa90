"""The solves of an accuracy study, timed, and how far one lies from another."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError, SolveError
from glossa.motor.commands import vowel_commands
from glossa.motor.schedule import Ramp
from glossa.results import Movement, Posture, SolveReport
from glossa.scene import Scene
from glossa.studies.accuracy_choices import POSTURE, Run
from glossa.studies.acoustics import posture_formants
from glossa.studies.failure import reason_of
from glossa.studies.midsagittal_nodes import midsagittal_nodes
from glossa.studies.resolution import shared_nodes
from glossa.studies.traces import even_times, node_traces

INTERVAL = 0.001
"""Between the times at which movements are compared, s."""

LONG = 5.0
"""A run that takes longer is not repeated, s."""

COUNTS = ("iterations", "factorisations", "residuals", "steps")
"""Numbers of the report that are kept."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What a solve came to; of a failed one only the reason.

    Attributes:
        trace: (t, n, 3) displacements from rest, m; one time for a posture, and for another resolution than 1 only the
            nodes that it shares with that.
        ends: (k,) s, where its steps end; one for a posture.
        forces: (k, muscles) N, there.
        formants: (4,) Hz, at the end; NaN where there are none.
        counts: by name, see :data:`COUNTS`.
        cpu, wall: s, the shortest of the repetitions.
        stated: what a movement says of its own error in time, m; NaN for a posture.
        reason: why it failed, or empty.
    """

    trace: FloatArray | None
    ends: FloatArray
    forces: FloatArray | None
    formants: FloatArray
    counts: Mapping[str, int]
    cpu: float
    wall: float
    stated: float = math.nan
    reason: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Distance:
    """How far one outcome lies from another, at the worst time; forces at the ends of its steps.

    Between frames a movement's positions are smooth and count everywhere; its forces are known at the frames only.

    Attributes:
        nodes: (6,) at the midsagittal nodes, m; NaN throughout where the speaker has none.
        largest: of all nodes, m.
        forces: (muscles,) N.
        formants: (4,) Hz.
    """

    nodes: FloatArray
    largest: float
    forces: FloatArray
    formants: FloatArray


def distance(trace: FloatArray, forces: FloatArray, formants: FloatArray, nodes: list[int]) -> Distance:
    """Sizes of differences (t, n, 3), (k, muscles), (4,) of two outcomes."""
    away = np.linalg.norm(trace, axis=2).max(axis=0)
    return Distance(
        nodes=away[nodes] if nodes else np.full(6, math.nan),
        largest=float(away.max()),
        forces=np.abs(forces).max(axis=0),
        formants=np.abs(formants),
    )


class Solves:
    """Solves of one study, each made once."""

    def __init__(
        self,
        scene: Scene,
        until: float,
        landmarks: Any,
        repetitions: int,
        tell: Callable[[Run, Outcome], object],
    ) -> None:
        self._scene, self._until, self._landmarks = scene, until, landmarks
        self._repetitions, self._tell = repetitions, tell
        self._scenes: dict[tuple[int, tuple[tuple[str, Any], ...]], Scene] = {}
        self._speakers: dict[int, Speaker] = {1: scene.speaker}
        self._found: dict[Run, Outcome] = {}
        self.nodes = six_nodes(scene.speaker)

    def outcome(self, run: Run, *, timed: bool = True) -> Outcome:
        """Of a run; times count only where it is ``timed``, which repeats it.

        Raises:
            SolveInterrupted: Ctrl-C.
        """
        if run not in self._found:
            self._found[run] = self._solved(run, self._repetitions if timed else 1)
            self._tell(run, self._found[run])
        return self._found[run]

    def distance(self, one: Outcome, other: Outcome) -> Distance | None:
        """Of two outcomes; None where one of them failed."""
        if one.trace is None or other.trace is None or one.forces is None or other.forces is None:
            return None
        theirs = np.stack([np.interp(one.ends, other.ends, force) for force in other.forces.T], axis=1)
        return distance(one.trace - other.trace, one.forces - theirs, one.formants - other.formants, self.nodes)

    def _solved(self, run: Run, repetitions: int) -> Outcome:
        try:
            solve = self._solve_of(run)
            result, cpu, wall = _timed(solve, repetitions)
        except SolveError as error:
            return _failed(reason_of(error))
        if isinstance(result, Posture):
            return self._of_posture(run, result, cpu, wall)
        return self._of_movement(run, result, cpu, wall)

    def _solve_of(self, run: Run) -> Callable[[], Posture | Movement]:
        scene, own, options = self._scene_of(run), vowel_commands(run.vowel), dict(run.solve)
        if run.kind == POSTURE:
            return lambda: scene.equilibrate(own, **options)
        schedule = Ramp(own)
        return lambda: scene.simulate(schedule, self._until, **options)

    def _scene_of(self, run: Run) -> Scene:
        key = (run.resolution, run.scene)
        if not run.scene and run.resolution == 1:
            return self._scene
        if key not in self._scenes:
            self._scenes[key] = Scene(self._speaker(run.resolution), **{**self._scene.options, **dict(run.scene)})
        return self._scenes[key]

    def _speaker(self, resolution: int) -> Speaker:
        if resolution not in self._speakers:
            self._speakers[resolution] = Speaker.reference(resolution, self._landmarks)
        return self._speakers[resolution]

    def _of_posture(self, run: Run, posture: Posture, cpu: float, wall: float) -> Outcome:
        moved = posture.displacements
        return Outcome(
            trace=(moved if run.resolution == 1 else moved[shared_nodes(run.resolution)])[None],
            ends=np.zeros(1),
            forces=np.asarray(posture.forces.to_numpy(), dtype=np.float64)[None],
            formants=posture_formants(posture, run.vowel)[0],
            counts=_counts(posture.report),
            cpu=cpu,
            wall=wall,
        )

    def _of_movement(self, run: Run, movement: Movement, cpu: float, wall: float) -> Outcome:
        times = np.minimum(even_times(self._until, min(INTERVAL, self._until)), movement.times[-1])
        end = movement.at(float(movement.times[-1]))
        return Outcome(
            trace=node_traces(movement, range(len(movement.speaker.nodes)), times),
            ends=movement.times,
            stated=movement.report.accumulated_error,
            forces=np.asarray(movement.forces.to_numpy(), dtype=np.float64),
            formants=posture_formants(end, run.vowel)[0],
            counts=_counts(movement.report),
            cpu=cpu,
            wall=wall,
        )


def six_nodes(speaker: Speaker) -> list[int]:
    """The six midsagittal nodes; none where the speaker does not have them."""
    try:
        return list(midsagittal_nodes(speaker).values())
    except InputError:
        return []


def _timed(solve: Callable[[], Posture | Movement], repetitions: int) -> tuple[Posture | Movement, float, float]:
    """The result, and the shortest processor time and time by the clock, s."""
    cpu = wall = math.inf
    spent, result = 0.0, None
    for _ in range(repetitions):
        if spent > LONG:
            break
        used, begin = time.process_time(), time.perf_counter()
        result = solve()
        took = time.perf_counter() - begin
        cpu, wall, spent = min(cpu, time.process_time() - used), min(wall, took), spent + took
    assert result is not None
    return result, cpu, wall


def _counts(report: SolveReport | None) -> dict[str, int]:
    return {name: 0 if report is None else int(getattr(report, name)) for name in COUNTS}


def _failed(reason: str) -> Outcome:
    return Outcome(
        trace=None,
        ends=np.zeros(0),
        forces=None,
        formants=np.full(4, math.nan),
        counts=dict.fromkeys(COUNTS, 0),
        cpu=math.nan,
        wall=math.nan,
        reason=reason,
    )
