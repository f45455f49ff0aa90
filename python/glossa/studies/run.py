"""Many equilibria as one study: in this process or on any executor, kept in a store, as a Dataset."""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from glossa import _core
from glossa.anatomy.shape import shape_parameters
from glossa.anatomy.speaker import Speaker
from glossa.checks import flag, instance, items
from glossa.errors import InputError, SolveError, SolveInterrupted
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.evaluation import Bench, Record, Setup, built_in_resolution, lost, scene_key
from glossa.studies.executors import Tasks, check_executor
from glossa.studies.measurement import Layout
from glossa.studies.provenance import STUDIED_ACCURACY, effective_options, solve_provenance
from glossa.studies.store import Store
from glossa.studies.study_dataset import check_labels, layout_dict, study_dataset
from glossa.studies.study_point import Point, canonical, plain

__all__ = ["Point", "Progress", "run_points", "study_header"]

log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a study is.

    Attributes:
        done: finished points, failed ones and those of earlier runs included.
        total: points of the study.
        failed: finished points without equilibrium.
        resumed: points that earlier runs had finished.
        seconds: since this run began.
    """

    done: int
    total: int
    failed: int
    resumed: int
    seconds: float

    @property
    def rate(self) -> float:
        """Points per second of this run; NaN before the first."""
        new = self.done - self.resumed
        return new / self.seconds if new and self.seconds > 0.0 else math.nan

    @property
    def remaining(self) -> float:
        """Seconds left at this rate; NaN while it is unknown."""
        return (self.total - self.done) / self.rate if self.done < self.total else 0.0


def run_points(
    scene: Scene,
    points: Sequence[Point],
    *,
    store: str | Path | None = None,
    executor: Executor | None = None,
    start: Posture | None = None,
    progress: Callable[[Progress], object] | None = None,
    positions: bool = False,
    retry_failed: bool = False,
    design: Mapping[str, Any] | None = None,
    label_units: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """The equilibrium of every point, and its formants where it has lips.

    Each point starts from the same posture, and from rest if it fails from there, so that results have the same bits in
    any order, on any worker (of the same kind of processor: see the attribute ``kernel``), in one run or several.

    Args:
        scene: what points share; their ``scene`` and ``shape`` change it.
        points: at least one.
        store: file that keeps finished points (see :mod:`glossa.studies.store`). If it is there, the study goes on
            where it was stopped, by whatever.
        executor: any that returns ``concurrent.futures.Future``: process or thread pools (:func:`worker_pool`), Dask's
            ``client.get_executor()``, ...; None: this process, one after the other. Threads have scenes of their own.
        start: posture of the scene's speaker to start from; None: rest.
        progress: called in this thread at the beginning and whenever points have finished.
        positions: keep the positions of all nodes, too.
        retry_failed: compute points again that failed in an earlier run; else they count as finished.
        design: how the points were chosen (method, seed, ...), for the attribute ``design``.
        label_units: units of labels, for the attributes of their coordinates.

    Returns:
        Dataset over ``point`` (and ``muscle``, ``node``, ``axis``, ``formant``, ``wall``, ``count``), labels as
        coordinates: ``status`` ("converged"; a status of :class:`glossa.SolveReport`; "refused": no such speaker or
        scene; "error"; "lost": its workers died), ``reason``, ``acoustic_reason``, ``started`` (from the "start" given
        or from "rest"; empty: nothing was solved), ``iterations`` and ``seconds`` (of both solves where the first
        failed), ``worker``; ``forces`` N, ``displacement`` m of the six midsagittal nodes, ``formants`` and
        ``bandwidths`` Hz, ``tract_length`` m, ``contact_area`` m2, ``contact_force`` N, ``hyoid_displacement`` m,
        ``commands``, lips; of the solve that converged ``residual`` over the force scale, ``least_jacobian``,
        ``penetration`` m and ``effort``, counts of its report.
        Points that failed are there, with NaN. Attributes: provenance.

    Raises:
        InputError: wrong points, start or executor; a store that is not this study's.
        SolveInterrupted: Ctrl-C; ``study`` and the store hold what has finished.
        SolveError: the executor broke down; likewise.
    """
    chosen = _checked_points(scene, points)
    layout = Layout.of(scene.speaker, positions=flag(positions, "positions"))
    check_labels(chosen, layout)
    _check_start(scene, start, chosen)
    if executor is not None:
        check_executor(executor)
    header = study_header(scene, chosen, layout, start=start, design=design or {}, label_units=label_units or {})
    setup = Setup(scene=scene, start=start, positions=bool(positions))
    with contextlib.ExitStack() as stack:
        kept = None if store is None else stack.enter_context(Store(store, header))
        run = _Run(setup, chosen, layout, kept, progress, retry_failed=flag(retry_failed, "retry_failed"))
        try:
            run.in_this_process() if executor is None else run.on(executor)
        except KeyboardInterrupt as stop:
            words = f"study interrupted: {len(run.records)} of {len(chosen)} points are finished"
            data = study_dataset(header, run.records.values())
            raise SolveInterrupted(f"{words}{_where(store)}", study=data) from stop
        except SolveError as error:
            error.study = study_dataset(header, run.records.values())
            raise
    return study_dataset(header, run.records.values())


def _where(store: str | Path | None) -> str:
    return "; .study holds them" if store is None else f" and kept in {store}"


class _Run:
    """Points to compute, and those finished."""

    def __init__(
        self,
        setup: Setup,
        points: Sequence[Point],
        layout: Layout,
        store: Store | None,
        progress: Callable[[Progress], object] | None,
        *,
        retry_failed: bool,
    ) -> None:
        self._setup, self._layout, self._store, self._progress = setup, layout, store, progress
        self.records: dict[int, Record] = {}
        for record in [] if store is None else store.records():
            if not (retry_failed and record.failed):
                self.records[record.number] = record
        self._total, self._resumed = len(points), len(self.records)
        self._begin = time.monotonic()
        groups: dict[str, list[tuple[int, Point]]] = {}
        for number, point in enumerate(points):
            if number not in self.records:
                groups.setdefault(scene_key(point), []).append((number, point))
        self._groups = list(groups.values())

    def in_this_process(self) -> None:
        self._tell()
        bench = Bench(self._setup)
        for group in self._groups:
            for number, point in group:
                self._take([bench.evaluate(number, point)])

    def on(self, executor: Executor) -> None:
        self._tell()
        if self._groups:
            Tasks(executor, self._setup.packed(), self._groups, take=self._take, lose=self._lose).run()

    def _take(self, records: Sequence[Record]) -> None:
        new = [record for record in records if record.number not in self.records]
        if self._store is not None:
            self._store.add(new)
        self.records |= {record.number: record for record in new}
        for record in new:
            if record.failed:
                log.warning("point %d: %s: %s", record.number, record.status, record.reason)
        self._tell()

    def _lose(self, number: int, reason: str) -> None:
        self._take([lost(number, reason, self._layout)])

    def _tell(self) -> None:
        if self._progress is not None:
            self._progress(
                Progress(
                    done=len(self.records),
                    total=self._total,
                    failed=sum(record.failed for record in self.records.values()),
                    resumed=self._resumed,
                    seconds=time.monotonic() - self._begin,
                )
            )


# Checks


def _checked_points(scene: Scene, points: Sequence[Point]) -> list[Point]:
    instance(scene, Scene, "scene")
    chosen = list(items(points, "points"))
    if not chosen:
        raise InputError("a study needs at least one point")
    muscles, options = scene.speaker.muscles, scene.options
    for number, point in enumerate(chosen):
        instance(point, Point, f"point {number}")
        for kind, names, known in (("muscle", point.commands, muscles), ("scene option", point.scene, options)):
            unknown = [name for name in names if name not in known]
            if unknown:
                words = ", ".join(known) or "none"
                raise InputError(f"point {number}: unknown {kind} {unknown[0]!r}; there are {words}")
    _check_shapes(scene.speaker, chosen)
    _check_sounds(scene.speaker, chosen)
    return chosen


def _check_shapes(speaker: Speaker, points: Sequence[Point]) -> None:
    if not any(point.shape for point in points):
        return
    known = shape_parameters()
    for number, point in enumerate(points):
        for name, value in point.shape.items():
            if name not in known:
                raise InputError(f"point {number}: unknown shape parameter {name!r}; there are {', '.join(known)}")
            low, high = known[name].room
            if not low <= value <= high:
                raise InputError(f"point {number}: {name} must lie between {low:g} and {high:g}, got {value!r}")
    if Speaker.reference(built_in_resolution(speaker)).fingerprint != speaker.fingerprint:
        raise InputError(
            f"shape parameters change the built-in speaker, and the scene has another one ({speaker.name!r})"
        )


def _check_sounds(speaker: Speaker, points: Sequence[Point]) -> None:
    if not speaker.walls and any(point.lips is not None for point in points):
        raise InputError("points with lips need a speaker with walls, to have a vocal tract; leave lips out")


def _check_start(scene: Scene, start: Posture | None, points: Sequence[Point]) -> None:
    if instance(start, Posture, "start", optional=True) is None:
        return
    assert start is not None
    if start.speaker.fingerprint != scene.speaker.fingerprint:
        raise InputError("start: this posture belongs to another speaker")
    if any(point.shape for point in points):
        raise InputError("start: points with shape parameters have other speakers and start from rest; leave start out")


# Identity


def study_header(
    scene: Scene,
    points: Sequence[Point],
    layout: Layout,
    *,
    start: Posture | None,
    design: Mapping[str, Any],
    label_units: Mapping[str, str],
) -> dict[str, Any]:
    """What identifies a study, and the attributes of its Dataset; plain values for JSON."""
    listed = [point.as_dict() for point in points]
    begin = _start_hash(start)
    attributes = {
        "glossa": "study",
        **solve_provenance(scene),
        "start": "rest" if start is None else "posture",
        "start_commands": canonical(None if start is None or start.commands is None else dict(start.commands)),
        "accuracy": STUDIED_ACCURACY,
        "points_sha256": hashlib.sha256(canonical(listed).encode()).hexdigest(),
        "design": canonical(design),
    }
    return {
        "speaker_fingerprint": scene.speaker.fingerprint,
        "glossa_version": _core.__version__,
        "scene": json.loads(canonical(effective_options(scene))),
        "start": begin,
        "layout": layout_dict(layout),
        "points": listed,
        "label_units": plain(label_units),
        "attributes": attributes,
    }


def _start_hash(start: Posture | None) -> str | None:
    """Hash of what an equilibrium takes from the posture it starts from."""
    if start is None:
        return None
    digest = hashlib.sha256()
    pressed = None if start.contact is None else start.contact.pressures
    shifts = start.wall_displacements.values()
    for array in (start.positions, start.pressure, pressed, *shifts):
        if array is not None:
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    digest.update(canonical(list(start.wall_displacements)).encode())
    return digest.hexdigest()
