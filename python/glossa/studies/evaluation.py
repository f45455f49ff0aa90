"""Points of a study, computed: in this process or, sent as bytes, in another one.

A worker keeps the scenes of the last few studies it has seen, so that a study is sent to it once. Each thread keeps
its own: solvers are not shared.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import socket
import threading
import time
import zlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError, SolveError
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.failure import reason_of
from glossa.studies.measurement import Layout, heard, measured
from glossa.studies.study_point import Point, canonical
from glossa.tract import area_function

log = logging.getLogger(__name__)

CONVERGED = "converged"
REFUSED = "refused"
"""Status of a point whose speaker or scene cannot be made."""
ERROR = "error"
"""Status of a point at which something failed that should not."""
LOST = "lost"
"""Status of a point whose workers died, again and again."""

START, REST = "start", "rest"
"""Where the solve that a record tells of began: the study's posture, or rest."""

_STUDIES, _SCENES, _SPEAKERS = 2, 4, 2  # kept by a thread
_HEXAHEDRA = 768  # of the built-in speaker at resolution 1


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """One finished point.

    Attributes:
        number: of the point, from 0.
        status: "converged"; a status of :class:`glossa.SolveReport`; "refused" where speaker or scene cannot be made;
            "error"; "lost".
        reason: why it has not converged, else empty.
        acoustic_reason: why formants are missing, else empty.
        started: :data:`START` or :data:`REST`; empty where nothing was solved.
        iterations: Newton iterations, of both solves where the first had failed.
        seconds: all it took, speaker and scene included where they had to be made.
        worker: host and process.
        finished: s since 1970.
        values: (size,) in the order of :class:`Layout`; NaN where not measured, and throughout where not converged.
    """

    number: int
    status: str
    reason: str
    acoustic_reason: str
    started: str
    iterations: int
    seconds: float
    worker: str
    finished: float
    values: FloatArray

    @property
    def failed(self) -> bool:
        """Whether the point has no equilibrium."""
        return self.status != CONVERGED


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What every point of a study shares: scene, posture to start from or None, whether all positions are kept."""

    scene: Scene
    start: Posture | None
    positions: bool

    def packed(self) -> bytes:
        """For :func:`evaluate_packed`, without what a start does not need.

        Raises:
            InputError: a scene that cannot be pickled.
        """
        start = self.start
        if start is not None:
            start = replace(start, hyoid=None, support_forces=None, stiffening=None, report=None)
        try:
            content = pickle.dumps((self.scene, start, self.positions), protocol=pickle.HIGHEST_PROTOCOL)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            raise InputError(f"this scene cannot be sent to other processes: {error}") from error
        return zlib.compress(content, 1)


_Kept = TypeVar("_Kept")


class _Few(OrderedDict[Hashable, Any]):
    """The values used last, at most ``most`` of them."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self.most = most

    def get_or_make(self, key: Hashable, make: Callable[[], _Kept]) -> _Kept:
        """The value of a key, made if it is not there."""
        if key in self:
            self.move_to_end(key)
        else:
            while len(self) >= self.most:
                self.popitem(last=False)
            self[key] = make()
        value: _Kept = self[key]
        return value


@dataclass(frozen=True, kw_only=True, eq=False)
class _Solved:
    """An equilibrium, or why there is none; the rest as in :class:`Record`."""

    posture: Posture | None
    status: str
    reason: str
    started: str
    iterations: int


class Bench:
    """Computes points of one study, in one thread.

    A point that fails from the study's posture is solved again from rest: friction and folds at the teeth make a few
    starts lead nowhere that others do not.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._layout = Layout.of(setup.scene.speaker, positions=setup.positions)
        self._scenes, self._speakers = _Few(_SCENES), _Few(_SPEAKERS)

    def evaluate(self, number: int, point: Point) -> Record:
        """The point, whatever happens at it.

        Raises:
            SolveInterrupted, KeyboardInterrupt: Ctrl-C.
        """
        begin = time.perf_counter()
        status, reason, acoustic_reason, started, iterations = CONVERGED, "", "", "", 0
        values: dict[str, FloatArray] = {}
        try:
            solved = self._solved(point)
            status, reason, started, iterations = solved.status, solved.reason, solved.started, solved.iterations
            if solved.posture is not None:
                values = measured(solved.posture, positions=self._setup.positions)
                if point.lips is not None:
                    sound, acoustic_reason = _sound(solved.posture, point)
                    values |= sound
        except InputError as error:
            status, reason = REFUSED, str(error)
        except Exception as error:  # a study of thousands outlives what nobody thought of
            log.exception("point %d", number)
            status, reason, values = ERROR, f"{type(error).__name__}: {error}", {}
        return Record(
            number=number,
            status=status,
            reason=reason,
            acoustic_reason=acoustic_reason,
            started=started,
            iterations=iterations,
            seconds=time.perf_counter() - begin,
            worker=this_worker(),
            finished=time.time(),
            values=self._layout.flat(values),
        )

    def _solved(self, point: Point) -> _Solved:
        """The equilibrium from the study's posture, else from rest; if both fail, what the solve from rest says."""
        scene, iterations = self._scene(point), 0
        if self._setup.start is not None:
            first = _attempt(scene, point, self._setup.start)
            if first.posture is not None:
                return first
            iterations = first.iterations
        last = _attempt(scene, point, None)
        return replace(last, iterations=iterations + last.iterations)

    def _scene(self, point: Point) -> Scene:
        base = self._setup.scene
        if not point.scene and not point.shape:
            return base

        def make() -> Scene:
            speaker = base.speaker
            if point.shape:
                shape = canonical(point.shape)
                speaker = self._speakers.get_or_make(shape, lambda: shaped(base.speaker, point.shape))
            return Scene(speaker, **{**base.options, **point.scene})

        return self._scenes.get_or_make(scene_key(point), make)


def _attempt(scene: Scene, point: Point, start: Posture | None) -> _Solved:
    started = REST if start is None else START
    try:
        posture = scene.equilibrate(point.commands, start=start)
    except SolveError as error:
        iterations = 0 if error.report is None else error.report.iterations
        return _Solved(
            posture=None, status=error.status, reason=reason_of(error), started=started, iterations=iterations
        )
    iterations = 0 if posture.report is None else posture.report.iterations
    return _Solved(posture=posture, status=CONVERGED, reason="", started=started, iterations=iterations)


def _sound(posture: Posture, point: Point) -> tuple[dict[str, FloatArray], str]:
    """What is heard; and why formants are missing: an open tract, or damping."""
    try:
        return heard(area_function(posture, point.lips))
    except (InputError, SolveError) as error:
        return {}, reason_of(error)


def scene_key(point: Point) -> str:
    """Equal for points that share speaker and scene."""
    return canonical([point.shape, point.scene])


def shaped(speaker: Speaker, shape: Mapping[str, float]) -> Speaker:
    """The built-in speaker with shape parameters, at the resolution of ``speaker``, which has to be built in.

    Raises:
        InputError: unknown parameters, values out of limits, or such as give no sound speaker.
    """
    return Speaker.reference(built_in_resolution(speaker), {"shape": dict(shape)})


def built_in_resolution(speaker: Speaker) -> int:
    """Resolution of a speaker by its number of hexahedra, as if it were the built-in one."""
    return max(1, round(float(np.cbrt(len(speaker.hexahedra) / _HEXAHEDRA))))


def this_worker() -> str:
    """Host and process."""
    return f"{socket.gethostname()}:{os.getpid()}"


_local = threading.local()


def evaluate_packed(study: str, setup: bytes | None, points: bytes, task: str = "") -> list[Record] | None:
    """In a worker: the points of a task; None where the study is needed and was not sent.

    Args:
        study: name of the setup, :func:`study_name`.
        setup: of :meth:`Setup.packed`; None: the worker should have it.
        points: pickled sequence of (number, :class:`Point`).
        task: differs between tasks, so that an executor that remembers results computes anew.
    """
    del task
    benches: _Few | None = getattr(_local, "benches", None)
    if benches is None:
        benches = _local.benches = _Few(_STUDIES)
    if setup is None and study not in benches:
        return None
    bench = benches.get_or_make(study, lambda: _unpacked(setup))
    listed: Sequence[tuple[int, Point]] = pickle.loads(points)
    return [bench.evaluate(number, point) for number, point in listed]


def study_name(setup: bytes) -> str:
    """Of a packed setup: equal for equal ones."""
    return hashlib.sha256(setup).hexdigest()


def _unpacked(setup: bytes | None) -> Bench:
    assert setup is not None
    scene, start, positions = pickle.loads(zlib.decompress(setup))
    return Bench(Setup(scene=scene, start=start, positions=positions))


def lost(number: int, reason: str, layout: Layout) -> Record:
    """The record of a point that no worker survived."""
    return Record(
        number=number,
        status=LOST,
        reason=reason,
        acoustic_reason="",
        started="",
        iterations=0,
        seconds=float("nan"),
        worker="",
        finished=time.time(),
        values=np.full(layout.size, np.nan),
    )
