"""What studies of many points cost: `make bench` prints it. Times are those of the clock.

Few points by default; ``GLOSSA_POINTS=1000 make bench`` is a Monte Carlo of a thousand over the eleven commands.
"""

from __future__ import annotations

import os
import pickle
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from glossa import MUSCLES, VOWELS, Scene, Speaker
from glossa.studies import Design, Point, Progress, monte_carlo, run_points, sweep, worker_pool
from glossa.studies.evaluation import Bench, Record, Setup
from glossa.studies.sweep import sweep_points

pytestmark = pytest.mark.slow

POINTS = int(os.environ.get("GLOSSA_POINTS", "12"))
SEED = 1
CLUSTER = 100
"""Workers of the cluster that is extrapolated to."""


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    """The built-in speaker with every effect of a static scene: contact, friction, hyoid, gravity."""
    return Scene(reference, mirror=True)


def around(vowel: str) -> tuple[str, Design]:
    """All commands within 10 % of a vowel's."""
    return vowel, monte_carlo({f"change.{name}": (-10.0, 10.0) for name in VOWELS[vowel]}, POINTS, SEED)


def anywhere() -> tuple[str, Design]:
    """All commands from 0.7 to 1.2, from rest; lips of /ə/."""
    return "ə", monte_carlo({f"command.{name}": (0.7, 1.2) for name in MUSCLES}, POINTS, SEED)


DESIGNS: dict[str, tuple[Callable[[], tuple[str, Design]], bool]] = {
    "within 10 % of /i/": (lambda: around("i"), True),
    "within 10 % of /u/": (lambda: around("u"), True),
    "within 10 % of /a/": (lambda: around("a"), True),
    "0.7 to 1.2, from rest": (anywhere, False),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_monte_carlo_over_eleven_commands(scene: Scene, name: str) -> None:
    """Points per second, how many converge, and why the others do not; in this process."""
    make, warm = DESIGNS[name]
    base, design = make()
    start = scene.equilibrate(VOWELS[base]) if warm else None
    result, seconds = timed(lambda: sweep(scene, design, base, start=start))
    report(name, result, seconds)
    assert result.sizes["point"] == POINTS
    assert ((result["status"] == "converged") | (result["reason"] != "")).all()


def report(name: str, result: xr.Dataset, seconds: float) -> None:
    count, good = result.sizes["point"], result["status"].to_numpy() == "converged"
    heard = np.isfinite(result["formants"].to_numpy()).all(axis=1)
    again = int((good & (result["started"].to_numpy() == "rest")).sum()) if result.attrs["start"] != "rest" else 0
    each = result["seconds"].to_numpy()
    print(f"\n{count} points, {name}, seed {SEED}: {count / seconds:.2f} per second")
    print(f"  converged {good.sum()} ({good.mean():.1%}), {again} of them from rest; with four formants {heard.sum()}")
    print(f"  seconds of a point: median {np.median(each):.2f}, largest {each.max():.2f}")
    print(
        f"  iterations of a point: median {np.median(result['iterations']):.0f}, largest {result['iterations'].max():d}"
    )
    for status, times in Counter(result["status"].to_numpy()[~good].tolist()).most_common():
        print(
            f"  {status}: {times}, the first: {result['reason'].to_numpy()[result['status'].to_numpy() == status][0]}"
        )


def timed(job: Callable[[], Any]) -> tuple[Any, float]:
    """Result and seconds."""
    begin = time.perf_counter()
    found = job()
    return found, time.perf_counter() - begin


# Scaling


def test_scaling_and_what_a_cluster_needs(scene: Scene, tmp_path: Path) -> None:
    """The same points on 1 and 2 processes, the costs beside computing, and 100 workers on paper."""
    base, design = around("i")
    points, _ = sweep_points(scene, design, base)
    start = scene.equilibrate(VOWELS[base])
    alone, seconds = timed(lambda: run_points(scene, points, start=start))
    load = f"{os.cpu_count()} cores whose load was {os.getloadavg()[0]:.1f} before"
    print(f"\n{POINTS} points within 10 % of /i/, {load}")
    print(f"  this process: {POINTS / seconds:.2f} per second")
    rates = {}
    for workers in (1, 2):
        began, rates[workers], result = on_workers(scene, points, start, workers)
        print(f"  {workers} worker(s): {rates[workers]:.2f} per second, after {began:.1f} s until the first point")
        assert np.array_equal(result["forces"], alone["forces"], equal_nan=True)
    print(f"  2 workers against 1: {rates[2] / rates[1]:.2f} times the rate")
    record = Bench(Setup(scene=scene, start=start, positions=False)).evaluate(0, points[0])
    setup, packing = timed(Setup(scene=scene, start=start, positions=False).packed)
    print(f"  sent once to a worker: {len(setup) / 1e6:.2f} MB, packed in {packing:.2f} s")
    print(f"  sent for a point: {len(pickle.dumps((0, points[0])))} B there, {len(pickle.dumps(record))} B back")
    cost = own_cost(scene, points[0], record, tmp_path)
    compute = float(np.nanmean(alone["seconds"]))
    print(f"  cost of a point in the process that runs the study, store included: {cost * 1e3:.2f} ms")
    demand, network = CLUSTER / compute, len(pickle.dumps(record))
    rate = min(demand, 1.0 / cost)
    print(f"{CLUSTER} workers, {compute:.2f} s for a point: {rate:.0f} points per second,")
    print(f"  {min(1.0, demand * cost):.0%} of one core for the study itself, good for {compute / cost:.0f} workers")
    print(f"  1,000 points in {1e3 / rate:.0f} s, 100,000 in {1e5 / rate / 60:.1f} min, and the workers' beginning")
    print(f"  network: {CLUSTER * len(setup) / 1e6:.0f} MB once, {demand * network / 1e6:.2f} MB/s back")


def on_workers(scene: Scene, points: list[Point], start: Any, workers: int) -> tuple[float, float, xr.Dataset]:
    """Seconds to the first point, points per second after it, and the result."""
    seen: list[tuple[int, float]] = []

    def watch(progress: Progress) -> None:
        seen.append((progress.done, progress.seconds))

    with worker_pool(workers) as pool:
        result = run_points(scene, points, start=start, executor=pool, progress=watch)
    first, last = next(one for one in seen if one[0]), seen[-1]
    return first[1], (last[0] - first[0]) / max(last[1] - first[1], 1e-9), result


class Instant(Executor):
    """As many workers as wanted that compute nothing: each answers at once with a record made before, sent as bytes."""

    def __init__(self, workers: int, record: Record) -> None:
        self._max_workers, self._record = workers, record

    def submit(self, function: Any, /, *arguments: Any, **options: Any) -> Future[Any]:
        del function, options
        answer: Future[Any] = Future()
        records = [replace(self._record, number=number) for number, _ in pickle.loads(arguments[2])]
        answer.set_result(pickle.loads(pickle.dumps(records)))
        return answer


def own_cost(scene: Scene, point: Point, record: Record, folder: Path) -> float:
    """Seconds per point of everything but computing, with tasks as large as a cluster's."""
    count = 4000
    points = [replace(point, labels={"number": float(number)}) for number in range(count)]

    def study(chosen: list[Point]) -> xr.Dataset:
        store = folder / f"{len(chosen)}.study"
        return run_points(scene, chosen, store=store, executor=Instant(CLUSTER, record))

    few, whole = timed(lambda: study(points[:1]))[1], timed(lambda: study(points))[1]
    return (whole - few) / (count - 1)
