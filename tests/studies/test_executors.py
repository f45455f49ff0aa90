"""Studies on pools of processes and threads: the same bits as in one process, and what happens when a pool breaks."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from tests.studies.study_runs import after, commands, same, small_scene

from glossa import InputError, Scene, SolveError, SolveInterrupted
from glossa.studies import Point, open_study, run_points, worker_pool


@pytest.fixture(scope="module")
def scene() -> Scene:
    return small_scene()


@pytest.fixture(scope="module")
def points() -> list[Point]:
    """Some of them in other scenes, between the rest, and one that fails."""
    mixed = commands(24)
    for number in range(0, 24, 5):
        gravity = (0.0, 0.0, -2.0 * number)
        mixed[number] = Point(commands={"upper": 0.8}, scene={"gravity": gravity}, labels={"command": 0.8})
    mixed[7] = Point(commands={"lower": 0.8}, scene={"hyoid": "mobile"}, labels={"command": 0.0})
    return mixed


@pytest.fixture(scope="module")
def serial(scene: Scene, points: list[Point]) -> xr.Dataset:
    return run_points(scene, points, positions=True)


@pytest.fixture(scope="module")
def pool() -> Iterator[ProcessPoolExecutor]:
    with worker_pool(2) as executor:
        yield executor


class Inline(Executor):
    """Computes in ``submit``; after so many tasks something else."""

    def __init__(self, tasks: int = 10_000, then: BaseException | None = None) -> None:
        self.tasks, self.then = tasks, then

    def submit(self, fn: Any, /, *args: Any, **options: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.tasks -= 1
        if self.tasks >= 0:
            future.set_result(fn(*args, **options))
        elif self.then is None:
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_exception(self.then)
        return future


class KilledWorker(Exception):  # noqa: N818 - its name matters
    """As Dask's."""


def test_processes_give_the_same_bits(
    scene: Scene, points: list[Point], serial: xr.Dataset, pool: ProcessPoolExecutor, tmp_path: Path
) -> None:
    store = tmp_path / "pool.study"
    result = run_points(scene, points, executor=pool, store=store, positions=True)
    same(result, serial)
    same(open_study(store), serial)
    workers = set(result["worker"].to_numpy().tolist())
    assert workers.isdisjoint(serial["worker"].to_numpy().tolist())


def test_processes_start_from_the_posture_that_is_sent(scene: Scene, pool: ProcessPoolExecutor) -> None:
    start = scene.equilibrate({"upper": 0.75})
    same(
        run_points(scene, commands(5), start=start, executor=pool, positions=True),
        run_points(scene, commands(5), start=start, positions=True),
    )


def test_threads_give_the_same_bits(scene: Scene, points: list[Point], serial: xr.Dataset) -> None:
    with ThreadPoolExecutor(3) as threads:
        same(run_points(scene, points, executor=threads, positions=True), serial)


def test_any_executor_will_do(scene: Scene, points: list[Point], serial: xr.Dataset) -> None:
    same(run_points(scene, points, executor=Inline(), positions=True), serial)


class Forgetful(Inline):
    """Workers that come and go: each second task meets one that has not seen the study."""

    sent: list[bool]

    def submit(self, fn: Any, /, *args: Any, **options: Any) -> Future[Any]:
        self.sent.append(args[1] is not None)
        if len(self.sent) % 2:
            return super().submit(fn, *args, **options)
        future: Future[Any] = Future()
        future.set_result(None if args[1] is None else fn(*args, **options))
        return future


def test_workers_that_ask_get_the_study(
    scene: Scene, points: list[Point], serial: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("glossa.studies.executors._width", lambda _: 1)
    executor = Forgetful()
    executor.sent = []
    same(run_points(scene, points, executor=executor, positions=True), serial)
    assert executor.sent[0]
    assert not all(executor.sent)
    assert any(executor.sent[3:])


def test_a_killed_pool_loses_nothing_that_had_finished(scene: Scene, tmp_path: Path) -> None:
    store = tmp_path / "s.study"
    whole = run_points(scene, commands(40))
    with worker_pool(1) as pool:

        def kill() -> None:
            for process in list(pool._processes.values()):
                assert process.pid is not None
                os.kill(process.pid, signal.SIGKILL)

        with pytest.raises(SolveError, match="executor broke down") as caught:
            run_points(scene, commands(40), executor=pool, store=store, progress=after(3, kill))
    kept = open_study(store)
    done = int((kept["status"] == "converged").sum())
    assert 3 <= done < 40
    xr.testing.assert_identical(kept, caught.value.study)
    same(run_points(scene, commands(40), store=store), whole)


def test_interrupted_pools_keep_what_has_finished(scene: Scene, pool: ProcessPoolExecutor, tmp_path: Path) -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    store = tmp_path / "s.study"
    with pytest.raises(SolveInterrupted, match="points are finished") as caught:
        run_points(scene, commands(60), executor=pool, store=store, progress=after(4, stop))
    done = int((caught.value.study["status"] == "converged").sum())
    assert 4 <= done < 60
    xr.testing.assert_identical(open_study(store), caught.value.study)
    same(run_points(scene, commands(60), executor=pool, store=store), run_points(scene, commands(60)))


def test_ctrl_c_in_a_worker_ends_the_study(scene: Scene) -> None:
    with pytest.raises(SolveInterrupted, match="2 of 9"):
        run_points(scene, commands(9), executor=Inline(2, SolveInterrupted("stopped")))


def test_a_cancelled_task_is_a_broken_executor(scene: Scene) -> None:
    for error in (None, CancelledError()):
        with pytest.raises(SolveError, match="executor broke down"):
            run_points(scene, commands(4), executor=Inline(1, error))


def test_a_worker_that_cannot_compute_ends_the_study(scene: Scene) -> None:
    with pytest.raises(SolveError, match=r"ModuleNotFoundError: no glossa .*same glossa installed") as caught:
        run_points(scene, commands(4), executor=Inline(1, ModuleNotFoundError("no glossa")))
    assert caught.value.study["status"].to_numpy().tolist() == ["converged"] + ["unfinished"] * 3


def test_points_that_kill_every_worker_are_lost_and_the_rest_is_not(scene: Scene, tmp_path: Path) -> None:
    class Deadly(Inline):
        """Dies of tasks with the fifth point."""

        def submit(self, fn: Any, /, *args: Any, **options: Any) -> Future[Any]:
            future = super().submit(fn, *args, **options)
            if any(record.number == 5 for record in future.result()):
                future = Future()
                future.set_exception(KilledWorker("died 4 times"))
            return future

    store = tmp_path / "s.study"
    result = run_points(scene, commands(30), executor=Deadly(), store=store)
    assert np_where(result, "lost") == [5]
    assert "died 4 times" in result["reason"][5].item()
    assert len(np_where(result, "converged")) == 29
    same(run_points(scene, commands(30), store=store), result)
    same(run_points(scene, commands(30), store=store, retry_failed=True), run_points(scene, commands(30)))


def np_where(result: xr.Dataset, status: str) -> list[int]:
    return [k for k, one in enumerate(result["status"].to_numpy().tolist()) if one == status]


def test_closed_executors_are_refused(scene: Scene) -> None:
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(InputError, match="takes no tasks: cannot schedule"):
        run_points(scene, commands(1), executor=executor)


@pytest.mark.parametrize("workers", [0, -1, 2.0, True])
def test_pools_need_workers(workers: Any) -> None:
    with pytest.raises(InputError, match="workers must be a whole number"):
        worker_pool(workers)


def test_scenes_that_cannot_be_sent_are_refused(scene: Scene) -> None:
    from types import MappingProxyType

    from glossa import Stiffening

    odd = Scene(scene.speaker, fixed=["left"], stiffening=Stiffening(gains=MappingProxyType({"upper": 1.0})))
    with pytest.raises(InputError, match="cannot be sent to other processes"):
        run_points(odd, commands(1), executor=Inline())
