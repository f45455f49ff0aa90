"""Tasks on an executor: a few ahead of every worker, taken as they finish."""

from __future__ import annotations

import math
import pickle
import signal
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from multiprocessing import get_context
from typing import Any

from glossa.checks import whole_number
from glossa.errors import InputError, SolveError
from glossa.studies.evaluation import Record, evaluate_packed, study_name
from glossa.studies.study_point import Point

_AIM = 0.5  # s of work in a task: what is lost with a worker, and against which its overhead counts
_RATE = 50.0  # tasks per second at most, for all workers
_LARGEST = 64  # points in a task
_AHEAD = 2  # tasks for every worker
_LOOK = 10.0  # s between looks at how many workers there are
_UNKNOWN = 16  # workers of an executor that does not tell

_Task = list[tuple[int, Point]]


def worker_pool(workers: int) -> ProcessPoolExecutor:
    """Processes of this machine, for ``executor`` of a study; Ctrl-C reaches the study only.

    They start afresh and import the main module: a script has to guard what it runs by ``__name__ == "__main__"``.

    Args:
        workers: how many.

    Raises:
        InputError: not a whole number from 1 to 1000.
    """
    count = whole_number(workers, "workers", 1, 1000)
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_ignore_interrupts)


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def check_executor(executor: Any) -> None:
    """Refuse what cannot take tasks.

    Raises:
        InputError: no method ``submit``, or a Dask client in place of its executor.
    """
    if hasattr(executor, "get_executor"):
        raise InputError(f"executor is a {type(executor).__name__}; pass its get_executor() instead")
    if not callable(getattr(executor, "submit", None)):
        raise InputError(
            f"executor must be a concurrent.futures.Executor (a process pool, client.get_executor() of Dask, ...), "
            f"got {executor!r}"
        )


class Tasks:
    """Points of a study on an executor.

    Points of one group share a scene and stay together. A task holds so many points that it takes about half a second
    (longer with more than 25 workers, whose tasks all pass through here); with a worker that dies go those it was
    computing, which the executor (Dask) or the next run computes again. The setup goes with a task until every worker
    has answered once, and to a worker that asks for it.

    Args:
        executor: whose ``submit`` returns a ``concurrent.futures.Future``.
        setup: of :meth:`Setup.packed`.
        groups: numbers and points.
        take: called in this thread with the records of finished tasks.
        lose: called with the number of a point that no worker survived, and why.
    """

    def __init__(
        self,
        executor: Executor,
        setup: bytes,
        groups: Sequence[Sequence[tuple[int, Point]]],
        *,
        take: Callable[[list[Record]], None],
        lose: Callable[[int, str], None],
    ) -> None:
        self._executor, self._setup, self._take, self._lose = executor, setup, take, lose
        self._study, self._run, self._submitted = study_name(setup), uuid.uuid4().hex, 0
        self._waiting = deque(deque(group) for group in groups if group)
        self._asked: deque[_Task] = deque()
        self._flying: dict[Future[list[Record] | None], _Task] = {}
        self._known = set[str]()
        self._seconds, self._finished = 0.0, 0
        self._workers, self._looked = 1, -math.inf

    def run(self) -> None:
        """Until every point is taken or lost.

        Raises:
            InputError: the executor takes no tasks.
            SolveError: it broke, or a worker cannot compute.
            KeyboardInterrupt: Ctrl-C here or in a worker. Tasks that finished before are taken in all three cases.
        """
        try:
            while self._waiting or self._asked or self._flying:
                self._fill()
                done, _ = wait(self._flying, return_when=FIRST_COMPLETED)
                self._collect(done)
        except BaseException:
            self._abandon()
            raise

    def _fill(self) -> None:
        if time.monotonic() - self._looked > _LOOK:
            self._workers, self._looked = _width(self._executor), time.monotonic()
        while self._asked:
            self._submit(self._asked.popleft(), self._setup)
        while self._waiting and len(self._flying) < _AHEAD * self._workers:
            group = self._waiting[0]
            task = [group.popleft() for _ in range(min(self._size(), len(group)))]
            if not group:
                self._waiting.popleft()
            self._submit(task, self._setup if len(self._known) < self._workers else None)

    def _submit(self, task: _Task, setup: bytes | None) -> None:
        self._submitted += 1
        name = f"{self._run}-{self._submitted}"
        try:
            future = self._executor.submit(evaluate_packed, self._study, setup, pickle.dumps(task), name)
        except BrokenExecutor as error:
            raise _broken(error) from error
        except RuntimeError as error:
            raise InputError(f"executor takes no tasks: {error}") from error
        if not isinstance(future, Future):
            raise InputError(
                f"executor: its submit() must return a concurrent.futures.Future, got {type(future).__name__}"
            )
        self._flying[future] = task

    def _size(self) -> int:
        """Points in the next task: about ``_AIM`` seconds of work, fewer towards the end, so that nobody idles."""
        if not self._finished:
            return 1
        left = sum(map(len, self._waiting))
        seconds = max(_AIM, self._workers / _RATE)
        aimed = int(seconds * self._finished / max(self._seconds, 1e-9))
        return max(1, min(aimed, _LARGEST, math.ceil(left / (_AHEAD * self._workers))))

    def _collect(self, done: Iterable[Future[list[Record] | None]]) -> None:
        """Take what has finished; the first fault is raised after that."""
        found: list[Record] = []
        try:
            for future in done:
                found += self._records(future)
        finally:
            if found:
                self._take(found)

    def _records(self, future: Future[list[Record] | None]) -> list[Record]:
        task = self._flying.pop(future)
        if future.cancelled():
            raise _broken(CancelledError("a task was cancelled"))
        error = future.exception()
        if error is not None:
            self._failed(error, task)
            return []
        records = future.result()
        if records is None:
            self._asked.append(task)
            return []
        self._finished += len(records)
        self._seconds += sum(record.seconds for record in records)
        self._known |= {record.worker for record in records}
        return records

    def _failed(self, error: BaseException, task: _Task) -> None:
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        if isinstance(error, BrokenExecutor | CancelledError):
            raise _broken(error) from error
        if type(error).__name__ != "KilledWorker":  # Dask's, which is not needed here otherwise
            raise SolveError(
                f"a worker cannot compute: {type(error).__name__}: {error} (is the same glossa installed there?)",
                status="executor",
            ) from error
        if len(task) > 1:
            self._waiting.extendleft(deque([one]) for one in task)
        else:
            self._lose(task[0][0], f"{type(error).__name__}: {error}")

    def _abandon(self) -> None:
        """Take what has finished, call the rest off."""
        finished = [future for future in list(self._flying) if not future.cancel() and future.done()]
        self._collect(future for future in finished if future.exception() is None)
        self._flying.clear()


def _broken(error: BaseException) -> SolveError:
    return SolveError(
        f"the executor broke down ({type(error).__name__}: {error}); finished points are kept in .study and in the "
        "store, if there is one; run the study again with the same store to go on",
        status="executor",
    )


def _width(executor: Any) -> int:
    """How many tasks an executor works on at a time."""
    workers = getattr(executor, "_max_workers", None)
    if isinstance(workers, int) and workers > 0:
        return workers
    threads = getattr(getattr(executor, "_client", None), "nthreads", None)
    if callable(threads):
        return max(1, int(sum(threads().values())))
    return _UNKNOWN
