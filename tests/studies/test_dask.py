"""A study on a Dask cluster: a scheduler and two workers as processes of their own, talking over TCP."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.studies.study_runs import after, commands, environment, same, small_scene

from glossa import InputError
from glossa.studies import Progress, open_study, run_points
from glossa.studies.evaluation import this_worker
from glossa.studies.store import read_store

distributed: Any = pytest.importorskip("distributed")

POINTS = 60


@contextmanager
def started(module: str, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{module}", *arguments],
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[Any, list[subprocess.Popen[bytes]]]]:
    """A client, and the processes of two workers."""
    importlib.import_module("distributed.cli.dask_scheduler")
    note = tmp_path / "scheduler.json"
    common = ("--scheduler-file", str(note), "--no-dashboard")
    single = ("--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path))
    with ExitStack() as stack:
        stack.enter_context(started("dask_scheduler", *common, "--host", "tcp://127.0.0.1", "--port", "0"))
        workers = [stack.enter_context(started("dask_worker", *common, *single)) for _ in range(2)]
        end = time.monotonic() + 60.0
        while not note.exists():
            assert time.monotonic() < end, "no scheduler"
            time.sleep(0.05)
        client = stack.enter_context(distributed.Client(scheduler_file=str(note), timeout=60))
        client.wait_for_workers(2, timeout=60)
        assert client.scheduler.address.startswith("tcp://127.0.0.1")
        yield client, workers


def test_a_worker_that_is_killed_costs_no_point(
    cluster: tuple[Any, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    client, workers = cluster
    scene, points, store = small_scene((12, 6, 6)), commands(POINTS), tmp_path / "dask.study"
    killed_at: list[float] = []
    left: list[int] = []
    by_address = dict(client.run(os.getpid))

    def kill() -> None:
        busy = {by_address[address] for address, tasks in client.processing().items() if tasks}
        victims = [worker for worker in workers if worker.pid in busy]
        assert victims, "one should have work that is lost"
        victims[0].kill()
        assert victims[0].wait() == -9
        left.extend(worker.pid for worker in workers if worker is not victims[0])
        killed_at.append(time.time())

    with pytest.raises(InputError, match="pass its get_executor"):
        run_points(scene, points, executor=client)
    seen: list[int] = []
    watch = after(POINTS // 4, kill)

    def note(progress: Progress) -> None:
        seen.append(progress.done)
        watch(progress)

    result = run_points(
        scene,
        points,
        executor=client.get_executor(),
        store=store,
        positions=True,
        progress=note,
    )
    assert len(killed_at) == 1
    assert seen == sorted(set(seen))
    assert seen[-1] == POINTS
    kept = open_study(store)
    assert kept.identical(result)
    by_worker = {name.rpartition(":")[2] for name in result["worker"].to_numpy().tolist()}
    assert str(left[0]) in by_worker
    assert by_worker <= {str(worker.pid) for worker in workers}  # the other may not have finished anything
    later = {record.worker for record in read_store(store)[1] if record.finished > killed_at[0]}
    assert later == {this_worker().replace(str(os.getpid()), str(left[0]))}
    assert len(client.nthreads()) == 1
    same(result, run_points(scene, points, positions=True))
