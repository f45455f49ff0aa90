"""Stores of studies: killed, resumed, refused."""

from __future__ import annotations

import fcntl
import os
import pickle
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block
from tests.studies.study_runs import after, commands, environment, same, small_scene

from glossa import InputError, Reflex, Scene, SolveInterrupted
from glossa.studies import Point, Progress, open_study, run_points
from glossa.studies.store import read_store

RUN = """
import pickle, sys
from glossa.studies import run_points
scene, points, store = pickle.load(open(sys.argv[1], "rb"))
run_points(scene, points, store=store)
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return small_scene()


@pytest.fixture(scope="module")
def whole(scene: Scene) -> xr.Dataset:
    return run_points(scene, commands(6))


@pytest.fixture
def half(scene: Scene, tmp_path: Path) -> Path:
    """A store with three of six points."""
    store = tmp_path / "half.study"

    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(SolveInterrupted):
        run_points(scene, commands(6), store=store, progress=after(3, stop))
    assert len(read_store(store)[1]) == 3
    return store


def in_background(scene: Scene, points: list[Point], store: Path) -> subprocess.Popen[bytes]:
    task = store.with_suffix(".task")
    task.write_bytes(pickle.dumps((scene, points, store)))
    return subprocess.Popen([sys.executable, "-c", RUN, str(task)], env=environment())


def finished(store: Path) -> dict[int, tuple[str, float]]:
    """Worker and time of each finished point; empty while there is no header yet."""
    try:
        return {record.number: (record.worker, record.finished) for record in read_store(store)[1]}
    except (FileNotFoundError, InputError):
        return {}


def has_at_least(store: Path, count: int) -> bool:
    return len(finished(store)) >= count


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_a_study_that_is_killed_again_and_again_loses_and_repeats_nothing(tmp_path: Path) -> None:
    scene, points = small_scene((8, 4, 4)), commands(80)
    store = tmp_path / "killed.study"
    before: dict[int, tuple[str, float]] = {}
    chance = random.Random(1)
    for _ in range(2):
        process = in_background(scene, points, store)
        wait_for(partial(has_at_least, store, len(before) + 4))
        time.sleep(chance.uniform(0.0, 0.03))
        process.kill()
        assert process.wait() == -signal.SIGKILL
        now = finished(store)
        assert len(before) + 4 <= len(now) < len(points)
        assert now.items() >= before.items()
        before = now
    result = run_points(scene, points, store=store)
    records = finished(store)
    assert len(records) == len(points)
    assert records.items() >= before.items()
    assert len({worker for worker, _ in records.values()}) == 3
    same(result, run_points(scene, points))


def test_a_write_that_was_cut_short_is_undone(scene: Scene, half: Path, whole: xr.Dataset) -> None:
    """The file itself holds half of it, and the journal beside it the way back."""
    cut = """
import os, signal, sqlite3, sys
database = sqlite3.connect(sys.argv[1], isolation_level=None)
database.execute("PRAGMA cache_size=1")
database.execute("BEGIN IMMEDIATE")
database.execute("UPDATE record SET reason = 'never'")
for k in range(100, 300):
    database.execute("INSERT INTO record VALUES (?, '', '', '', '', 0, 0, '', 0, zeroblob(3000), 0)", (k,))
os.kill(os.getpid(), signal.SIGKILL)
"""
    before = half.read_bytes()
    done = subprocess.run([sys.executable, "-c", cut, str(half)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert half.read_bytes() != before
    assert Path(f"{half}-journal").exists()
    assert open_study(half)["status"].to_numpy().tolist() == ["converged"] * 3 + ["unfinished"] * 3
    assert half.read_bytes() == before
    same(run_points(scene, commands(6), store=half), whole)


def test_a_killed_writer_holds_nobody_up_and_a_living_one_does(tmp_path: Path) -> None:
    scene, points = small_scene((8, 4, 4)), commands(2000)
    store = tmp_path / "s.study"
    process = in_background(scene, points, store)
    try:
        wait_for(partial(has_at_least, store, 2))
        with pytest.raises(InputError, match="being written by another process"):
            run_points(scene, points, store=store)
        running = open_study(store)
        assert set(running["status"].to_numpy()) == {"converged", "unfinished"}
    finally:
        process.kill()
        process.wait()
    done = len(finished(store))
    with pytest.raises(SolveInterrupted):
        run_points(scene, points, store=store, progress=after(done + 1, lambda: os.kill(os.getpid(), signal.SIGINT)))
    assert len(finished(store)) > done


def test_nothing_is_computed_twice(scene: Scene, half: Path, whole: xr.Dataset) -> None:
    before = finished(half)
    seen: list[Progress] = []
    same(run_points(scene, commands(6), store=half, progress=seen.append), whole)
    assert [(one.done, one.resumed) for one in seen] == [(3, 3), (4, 3), (5, 3), (6, 3)]
    assert finished(half).items() >= before.items()
    after_all = half.read_bytes()
    again = run_points(scene, commands(6), store=half)
    assert half.read_bytes() == after_all
    xr.testing.assert_identical(again, open_study(half))
    assert list(half.parent.glob("half.study*")) == [half]


def test_unfinished_studies_can_be_read(half: Path, whole: xr.Dataset) -> None:
    data = open_study(half)
    assert data["status"].to_numpy().tolist() == ["converged"] * 3 + ["unfinished"] * 3
    assert np.isnan(data["forces"][3:]).all()
    assert data["command"].to_numpy().tolist() == whole["command"].to_numpy().tolist()
    data.to_netcdf(half.with_suffix(".nc"), engine="h5netcdf")
    same(data.isel(point=slice(3)), whole.isel(point=slice(3)))


def test_stores_that_can_only_be_read_are_read(half: Path) -> None:
    half.chmod(0o444)
    assert open_study(half).sizes["point"] == 6


def test_failed_points_count_as_finished_unless_told_otherwise(scene: Scene, tmp_path: Path) -> None:
    store = tmp_path / "failed.study"
    points = [*commands(2), Point(commands={}, scene={"hyoid": "mobile"}, labels={"command": 0.0})]
    first = run_points(scene, points, store=store)
    before = finished(store)
    xr.testing.assert_identical(run_points(scene, points, store=store), first)
    assert finished(store) == before
    same(run_points(scene, points, store=store, retry_failed=True), first)
    now = finished(store)
    assert [now[k] == before[k] for k in range(3)] == [True, True, False]


def test_what_does_not_change_results_may_differ(scene: Scene, half: Path, whole: xr.Dataset) -> None:
    threads = Scene(scene.speaker, fixed=["left"], threads=2, gravity=(0.0, 0.0, -9.81))
    same(run_points(threads, commands(6), store=half), whole)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda _: (Scene(block((3, 2, 2), muscles={"upper": 2.0, "lower": 2.0}), fixed=["left"]), {}),
            "other speaker",
        ),
        (lambda s: (Scene(s.speaker, fixed=["left"], gravity=None), {}), r"scene \(gravity \[0.0,0.0,-9.81\] instead"),
        (
            lambda s: (Scene(s.speaker, fixed=["left"], reflex=Reflex(delay=0.01)), {}),
            'another scene .reflex .*"delay"',
        ),
        (lambda s: (s, {"points": commands(7)}), r"other points \(6, and this study has 7\)"),
        (lambda s: (s, {"points": commands(6)[::-1]}), "number 0 is the first that differs"),
        (lambda s: (s, {"positions": True}), "other quantities"),
        (lambda s: (s, {"start": s.equilibrate()}), "another posture"),
    ],
)
def test_stores_of_other_studies_are_refused(
    scene: Scene, half: Path, change: Callable[[Scene], tuple[Scene, dict[str, object]]], message: str
) -> None:
    before = half.read_bytes()
    other, options = change(scene)
    points = options.pop("points", commands(6))
    with pytest.raises(InputError, match=message):
        run_points(other, points, store=half, **options)  # type: ignore[arg-type]
    assert half.read_bytes() == before


@pytest.mark.parametrize(("version", "good"), [("0.1.7", True), ("0.2.0", False), ("1.1.0", False)])
def test_stores_of_other_versions_are_refused(
    scene: Scene, half: Path, monkeypatch: pytest.MonkeyPatch, version: str, good: bool
) -> None:
    """Patches leave numbers as they are; minor versions may not."""
    monkeypatch.setattr("glossa.studies.run._core.__version__", version)
    assert open_study(half).attrs["glossa_version"] != version
    if good:
        assert set(run_points(scene, commands(6), store=half)["status"].to_numpy()) == {"converged"}
        return
    before = half.read_bytes()
    with pytest.raises(InputError, match=f"another version of glossa .*this is {version}"):
        run_points(scene, commands(6), store=half)
    assert half.read_bytes() == before


def _text(path: Path) -> None:
    path.write_text("not a database " * 100)


def _foreign(path: Path) -> None:
    path.unlink()
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE mine (a)")
    database.close()


def _other_format(path: Path) -> None:
    database = sqlite3.connect(path)
    database.execute("PRAGMA user_version=99")
    database.close()


def _truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-4096])


def _short(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:700])


def _changed_number(path: Path) -> None:
    database = sqlite3.connect(path)
    doubles = bytearray(database.execute("SELECT doubles FROM record WHERE number = 1").fetchone()[0])
    doubles[6] ^= 1
    with database:
        database.execute("UPDATE record SET doubles = ? WHERE number = 1", (bytes(doubles),))
    database.close()


def _changed_status(path: Path) -> None:
    database = sqlite3.connect(path)
    with database:
        database.execute("UPDATE record SET status = 'stalled' WHERE number = 1")
    database.close()


def _changed_header(path: Path) -> None:
    database = sqlite3.connect(path)
    with database:
        database.execute("UPDATE header SET value = replace(value, '0.7', '0.8') WHERE name = 'points'")
    database.close()


def _missing_entry(path: Path) -> None:
    database = sqlite3.connect(path)
    with database:
        database.execute("DELETE FROM header WHERE name = 'scene'")
    database.close()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_text, "is no store of a study, or damaged"),
        (_foreign, "is no store of a study"),
        (_other_format, "has format 99"),
        (_truncated, "damaged"),
        (_short, "damaged"),
        (_changed_number, r"damaged \(point 1\)"),
        (_changed_status, r"damaged \(point 1\)"),
        (_changed_header, r"damaged \(its header\)"),
        (_missing_entry, r"damaged \(its header\)"),
    ],
)
def test_corrupt_and_foreign_files_are_refused(
    scene: Scene, half: Path, spoil: Callable[[Path], None], message: str
) -> None:
    spoil(half)
    before = half.read_bytes()
    with pytest.raises(InputError, match=message):
        run_points(scene, commands(6), store=half)
    with pytest.raises(InputError, match=message):
        open_study(half)
    assert half.read_bytes() == before


def test_places_where_no_store_can_be_are_refused(scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        run_points(scene, commands(1), store=tmp_path)
    with pytest.raises(InputError, match="there is no folder"):
        run_points(scene, commands(1), store=tmp_path / "no" / "s.study")
    with pytest.raises(InputError, match="is a folder"):
        open_study(tmp_path)
    with pytest.raises(FileNotFoundError, match="no file at"):
        open_study(tmp_path / "none.study")
    empty = tmp_path / "empty.study"
    empty.touch()
    with pytest.raises(InputError, match="is no store"):
        open_study(empty)
    assert run_points(scene, commands(1), store=empty)["status"].item() == "converged"


def test_a_lock_file_left_behind_does_not_matter_and_a_held_one_does(
    scene: Scene, half: Path, whole: xr.Dataset
) -> None:
    lock = Path(f"{half}.lock")
    lock.touch()
    with lock.open("r+") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(InputError, match="being written by another process"):
            run_points(scene, commands(6), store=half)
    assert lock.exists()
    same(run_points(scene, commands(6), store=half), whole)
    assert not lock.exists()


def test_a_disk_that_refuses_stops_the_study(scene: Scene, half: Path) -> None:
    database = sqlite3.connect(half)
    with database:
        database.execute("CREATE TRIGGER full BEFORE INSERT ON record BEGIN SELECT RAISE(ABORT, 'disk full'); END")
    database.close()
    with pytest.raises(OSError, match="cannot be written: disk full"):
        run_points(scene, commands(6), store=half)
    assert len(read_store(half)[1]) == 3
