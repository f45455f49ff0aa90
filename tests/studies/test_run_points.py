"""Studies of many points in one process: results, failures, what is refused."""

from __future__ import annotations

import json
import logging
import pickle
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block
from tests.studies.study_runs import after, commands, same, small_scene

from glossa import (
    VOWELS,
    Damping,
    InputError,
    Lips,
    Posture,
    Reflex,
    Scene,
    SolveError,
    SolveInterrupted,
    Speaker,
    Stiffening,
    Yeoh,
    __version__,
    area_function,
)
from glossa.studies import Point, Progress, evaluation, open_study, run_points
from glossa.studies.evaluation import Setup, evaluate_packed, study_name
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES
from glossa.studies.study_point import canonical


@pytest.fixture(scope="module")
def scene() -> Scene:
    return small_scene()


@pytest.fixture(scope="module")
def tongue(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True)


@pytest.fixture(scope="module")
def vowels_study(tongue: Scene) -> xr.Dataset:
    """/ə/ with and without gravity, and with another vault."""
    points = [
        Point(commands=VOWELS["ə"], lips="ə", labels={"what": "plain", "size": 0}),
        Point(commands=VOWELS["ə"], lips=(0.01, 1e-4), scene={"gravity": None}, labels={"what": "no gravity"}),
        Point(commands=VOWELS["ə"], lips="ə", shape={"vault_height": 1.0}, labels={"what": "vault", "size": 1}),
    ]
    return run_points(tongue, points)


def test_scenes_survive_pickling(reference: Speaker) -> None:
    options: dict[str, Any] = {
        "gravity": (0.0, 0.0, -1.6),
        "friction": 0.2,
        "hyoid": "fixed",
        "stiffening": Stiffening(peak_multiplier=5.0, gains={"GGp": 3.0}),
        "reflex": Reflex(delay=0.01),
        "force_velocity": False,
        "damping": Damping(alpha=1.0, beta=0.01),
        "tissue": Yeoh(192.0, 90.0, poissons_ratio=0.49),
        "mirror": True,
        "firing_gradient": 50.0,
        "contact": False,
    }
    scene = Scene(reference, **options)
    again = pickle.loads(pickle.dumps(scene))
    assert again.speaker.fingerprint == reference.fingerprint
    assert dict(again.options) == dict(scene.options)
    assert {name: scene.options[name] for name in options} == options
    for name in scene.options:
        assert getattr(again, name) == getattr(scene, name), name
    assert again.effects == scene.effects


def test_a_pickled_scene_gives_the_same_bits(scene: Scene) -> None:
    scene.equilibrate({"upper": 0.9})
    again = pickle.loads(pickle.dumps(scene))
    one, other = (each.equilibrate({"upper": 0.75}) for each in (scene, again))
    assert np.array_equal(one.positions, other.positions)
    assert np.abs(one.displacements).max() > 1e-4


def test_results_are_those_of_single_equilibria(tongue: Scene, vowels_study: xr.Dataset) -> None:
    posture = tongue.equilibrate(VOWELS["ə"])
    first = vowels_study.isel(point=0)
    assert first["status"].item() == "converged"
    assert first["forces"].to_numpy().tolist() == posture.forces.tolist()
    assert first["formants"].to_numpy().tolist() == area_function(posture, "ə").formants(4).frequencies.tolist()
    assert first["commands"].to_series().to_dict() == dict(VOWELS["ə"])
    assert first["node"].to_numpy().tolist() == list(MIDSAGITTAL_NODES)
    assert posture.contact is not None
    assert posture.hyoid is not None
    assert first["contact_area"].to_numpy().tolist() == posture.contact.touched_areas.tolist()
    assert first["hyoid_displacement"].to_numpy().tolist() == posture.hyoid.displacement.tolist()
    assert posture.report is not None
    assert first["iterations"].item() == posture.report.iterations
    units = {name: vowels_study[name].attrs["units"] for name in ("forces", "displacement", "formants", "contact_area")}
    assert units == {"forces": "N", "displacement": "m", "formants": "Hz", "contact_area": "m2"}


def test_scene_options_shape_and_lips_belong_to_their_points(tongue: Scene, vowels_study: xr.Dataset) -> None:
    plain, floating, vault = (vowels_study.isel(point=number) for number in range(3))
    assert set(vowels_study["status"].to_numpy()) == {"converged"}
    posture = Scene(tongue.speaker, mirror=True, gravity=None).equilibrate(VOWELS["ə"])
    assert floating["forces"].to_numpy().tolist() == posture.forces.tolist()
    own = area_function(posture, (0.01, 1e-4)).formants(4).frequencies
    assert floating["formants"].to_numpy().tolist() == own.tolist()
    assert (floating["lips_length"].item(), floating["lips_area"].item()) == (0.01, 1e-4)
    changed = Speaker.reference(1, {"shape": {"vault_height": 1.0}})
    shaped = Scene(changed, mirror=True).equilibrate(VOWELS["ə"])
    assert vault["forces"].to_numpy().tolist() == shaped.forces.tolist()
    assert vault["formants"].to_numpy().tolist() != plain["formants"].to_numpy().tolist()
    assert json.loads(floating["scene_options"].item()) == {"gravity": None}
    assert json.loads(vault["shape"].item()) == {"vault_height": 1.0}


def test_labels_are_coordinates_and_provenance_is_written(tongue: Scene, vowels_study: xr.Dataset) -> None:
    assert vowels_study["what"].to_numpy().tolist() == ["plain", "no gravity", "vault"]
    assert np.array_equal(vowels_study["size"], [0.0, np.nan, 1.0], equal_nan=True)
    attributes = vowels_study.attrs
    assert attributes["glossa_version"] == __version__
    assert attributes["speaker_fingerprint"] == tongue.speaker.fingerprint
    written = json.loads(attributes["scene"])
    assert written["gravity"] == [0.0, 0.0, -9.81]
    assert written["hyoid"] == "mobile"
    assert written["tissue"]["c10"] == 1037.0
    assert attributes["residual_tolerance"] == 1e-8
    assert attributes["start"] == "rest"


def test_datasets_go_to_netcdf_and_back(vowels_study: xr.Dataset, tmp_path: Path) -> None:
    vowels_study.to_netcdf(tmp_path / "study.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "study.nc", engine="h5netcdf") as opened:
        read = opened.load()
    assert read["what"].to_numpy().tolist() == vowels_study["what"].to_numpy().tolist()
    assert read["forces"].to_numpy().tolist() == vowels_study["forces"].to_numpy().tolist()
    assert read.attrs["design"] == vowels_study.attrs["design"]


def test_every_point_starts_from_the_same_posture(scene: Scene) -> None:
    start = scene.equilibrate({"upper": 0.8})
    points = commands(4)
    result = run_points(scene, points, start=start, positions=True)
    backwards = run_points(scene, points[::-1], start=start, positions=True)
    for number, point in enumerate(points):
        alone = scene.equilibrate(point.commands, start=start)
        assert np.array_equal(result["positions"][number], alone.positions)
        assert np.array_equal(backwards["positions"][-1 - number], alone.positions)
    cold = run_points(scene, points, positions=True)
    assert not np.array_equal(cold["positions"], result["positions"])
    assert result.attrs["start"] == "posture"


def inside_out(scene: Scene) -> Posture:
    """A posture that no solve can start from."""
    good = scene.equilibrate({"upper": 0.8})
    return replace(good, positions=good.positions * [-1.0, 1.0, 1.0])


def test_points_that_fail_from_the_start_are_solved_from_rest(scene: Scene, tmp_path: Path) -> None:
    start, points = inside_out(scene), commands(3)
    with pytest.raises(SolveError):
        scene.equilibrate(points[0].commands, start=start)
    result, cold = run_points(scene, points, start=start), run_points(scene, points)
    assert result["status"].to_numpy().tolist() == ["converged"] * 3
    assert result["started"].to_numpy().tolist() == cold["started"].to_numpy().tolist() == ["rest"] * 3
    assert result["forces"].to_numpy().tolist() == cold["forces"].to_numpy().tolist()
    warm = run_points(scene, points, start=scene.equilibrate({"upper": 0.8}))
    assert warm["started"].to_numpy().tolist() == ["start"] * 3
    store = tmp_path / "s.study"
    with ThreadPoolExecutor(1) as pool:
        same(run_points(scene, points, start=start, store=store, executor=pool), result)
    same(open_study(store), result)


def test_a_resumed_study_does_not_repeat_what_was_solved_from_rest(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, points, store = inside_out(scene), commands(4), tmp_path / "s.study"
    solve, solved = Scene.equilibrate, []

    def note(self: Scene, given: Any, **options: Any) -> Any:
        solved.append((given["upper"], "rest" if options["start"] is None else "start"))
        return solve(self, given, **options)

    def stop() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Scene, "equilibrate", note)
    with pytest.raises(SolveInterrupted):
        run_points(scene, points, start=start, store=store, progress=after(2, stop))
    run_points(scene, points, start=start, store=store)
    assert solved == [(point.commands["upper"], where) for point in points for where in ("start", "rest")]


def test_both_solves_of_a_point_are_counted(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    start, points = scene.equilibrate({"upper": 0.8}), commands(2)
    cold = run_points(scene, points)
    solve = Scene.equilibrate

    def fail_warm(self: Scene, given: Any, *, start: Any = None, **options: Any) -> Any:
        if start is not None:
            time.sleep(0.05)
            raise SolveError("no way from here", status="stalled", report=SimpleNamespace(iterations=70))
        if given["upper"] > 0.9:
            raise SolveError("nor from rest; .posture is the last good state", status="iteration_limit")
        return solve(self, given, start=start, **options)

    monkeypatch.setattr(Scene, "equilibrate", fail_warm)
    result = run_points(scene, points, start=start)
    assert result["iterations"].to_numpy().tolist() == [70 + cold["iterations"][0].item(), 70]
    assert (result["seconds"] > 0.05).all()
    assert result["status"].to_numpy().tolist() == ["converged", "iteration_limit"]
    assert result["reason"].to_numpy().tolist() == ["", "nor from rest"]


def test_failed_points_stay_with_their_reason(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    points = [
        Point(commands={"upper": 0.9}),
        Point(commands={}, scene={"gravity": (-4e3, 0.0, 0.0), "tissue": Yeoh(1.0, 0.0, poissons_ratio=0.0)}),
        Point(commands={"upper": 0.9}, scene={"hyoid": "mobile"}),
        Point(commands={"upper": 0.8}),
    ]
    with caplog.at_level(logging.WARNING, logger="glossa"):
        result = run_points(scene, points)
    status = result["status"].to_numpy().tolist()
    assert status[0] == status[3] == "converged"
    assert status[1] in ("iteration_limit", "stalled", "inverted", "indefinite")
    assert status[2] == "refused"
    assert result["started"].to_numpy().tolist() == ["rest", "rest", "", "rest"]
    assert "no equilibrium" in result["reason"][1].item()
    assert ".posture" not in result["reason"][1].item()
    assert "no hyoid bone" in result["reason"][2].item()
    assert np.isnan(result["forces"][1:3]).all()
    assert np.isfinite(result["forces"][[0, 3]]).all()
    assert result["iterations"][1] > 0
    assert "point 2: refused" in caplog.text


def test_what_nobody_thought_of_stops_no_study(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Scene.equilibrate

    def fail_once(self: Scene, given: Any, **options: Any) -> Any:
        if given["upper"] == 0.8:
            raise ZeroDivisionError("of all things")
        return solve(self, given, **options)

    monkeypatch.setattr(Scene, "equilibrate", fail_once)
    result = run_points(scene, [Point(commands={"upper": value}) for value in (0.9, 0.8, 0.7)])
    assert result["status"].to_numpy().tolist() == ["converged", "error", "converged"]
    assert result["reason"][1].item() == "ZeroDivisionError: of all things"


def test_a_tract_that_cannot_be_cut_is_no_failed_equilibrium(tongue: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_tract(*_: Any) -> None:
        raise InputError("3 of 45 sections are open")

    monkeypatch.setattr("glossa.studies.evaluation.area_function", no_tract)
    result = run_points(tongue, [Point(commands=VOWELS["ə"], lips="ə")])
    assert result["status"].item() == "converged"
    assert result["acoustic_reason"].item() == "3 of 45 sections are open"
    assert np.isnan(result["formants"]).all()
    assert np.isfinite(result["forces"]).all()


def test_progress_tells_rate_and_time_left(scene: Scene) -> None:
    seen: list[Progress] = []
    run_points(scene, commands(4), progress=seen.append)
    assert [one.done for one in seen] == [0, 1, 2, 3, 4]
    assert {one.total for one in seen} == {4}
    assert np.isnan(seen[0].rate)
    middle = seen[2]
    assert middle.rate == 2 / middle.seconds
    assert middle.remaining == pytest.approx(middle.seconds)
    assert seen[-1].remaining == 0.0


def test_interrupted_studies_keep_what_has_finished(scene: Scene, tmp_path: Path) -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(SolveInterrupted, match="3 of 5 points are finished") as caught:
        run_points(scene, commands(5), progress=after(3, stop))
    whole = run_points(scene, commands(5))
    assert caught.value.study["status"].to_numpy().tolist() == ["converged"] * 3 + ["unfinished"] * 2
    same(caught.value.study.isel(point=slice(3)), whole.isel(point=slice(3)))
    store = tmp_path / "s.study"
    with pytest.raises(SolveInterrupted, match=r"kept in .*s\.study"):
        run_points(scene, commands(5), store=store, progress=after(3, stop))
    same(open_study(store), caught.value.study)
    same(run_points(scene, commands(5), store=store), whole)


def test_ctrl_c_in_a_solve_ends_the_study(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Scene.equilibrate

    def stop_third(self: Scene, given: Any, **options: Any) -> Any:
        posture = solve(self, given, **options)
        if given["upper"] > 0.8:
            raise SolveInterrupted("equilibrium interrupted", posture=posture)
        return posture

    monkeypatch.setattr(Scene, "equilibrate", stop_third)
    points = [Point(commands={"upper": value}) for value in (0.7, 0.8, 0.9)]
    with pytest.raises(SolveInterrupted, match="2 of 3") as caught:
        run_points(scene, points)
    assert isinstance(caught.value, KeyboardInterrupt)
    assert caught.value.study["status"].to_numpy().tolist() == ["converged", "converged", "unfinished"]


def test_workers_keep_scenes(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same study sent again builds nothing again; the options of points build each scene once while few."""
    built = []
    build = Scene.__init__

    def counted(self: Scene, *args: Any, **options: Any) -> None:
        built.append(options.get("gravity"))
        build(self, *args, **options)

    monkeypatch.setattr(Scene, "__init__", counted)
    monkeypatch.setattr(evaluation, "_local", threading.local())  # a worker that has seen no study, not even this one
    setup = Setup(scene=scene, start=None, positions=False).packed()
    light = Point(commands={"upper": 0.8}, scene={"gravity": (0.0, 0.0, -1.6)})
    dark = Point(commands={"upper": 0.8}, scene={"gravity": (0.0, 0.0, -2.6)})
    task = pickle.dumps([(0, light), (1, dark), (2, Point(commands={}))])
    name = study_name(setup)
    assert evaluate_packed(name, None, task) is None
    first, second = evaluate_packed(name, setup, task), evaluate_packed(name, None, task)
    assert first is not None
    assert second is not None
    assert built == ["upright", (0.0, 0.0, -1.6), (0.0, 0.0, -2.6)]
    for one, other in zip(first, second, strict=True):
        assert one.status == "converged"
        assert np.array_equal(one.values, other.values, equal_nan=True)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Point(commands={"upper": -0.5}), "must be positive"),
        (lambda: Point(commands={}, lips="y"), "no lips known for 'y'"),
        (lambda: Point(commands={}, lips=(0.8, 1.0)), "lip length must be in m"),
        (lambda: Point(commands={}, labels={"a": float("nan")}), "label a must be finite"),
        (lambda: Point(commands={}, labels={"a": None}), "label a must be a number"),  # type: ignore[dict-item]
        (lambda: Point(commands={}, shape={"vault_height": "high"}), "must be a number"),  # type: ignore[dict-item]
        (lambda: Point(commands={}, scene="upright"), "scene of a point must be a mapping"),  # type: ignore[arg-type]
    ],
)
def test_malformed_points_are_refused(make: Callable[[], Point], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], "at least one point"),
        ([{"upper": 0.9}], "point 0 must be a Point"),
        ([Point(commands={}), Point(commands={"GGp": 0.9})], "point 1: unknown muscle 'GGp'; there are upper, lower"),
        ([Point(commands={}, scene={"wind": 1.0})], "unknown scene option 'wind'; there are gravity"),
        ([Point(commands={}, shape={"vault_height": 1.0})], "change the built-in speaker"),
        ([Point(commands={}, shape={"beard": 1.0})], "unknown shape parameter 'beard'"),
        ([Point(commands={}, shape={"vault_height": 100.0})], "vault_height must lie between"),
        ([Point(commands={}, lips="i")], "speaker with walls"),
        ([Point(commands={}, labels={"muscle": "GGp"})], "a label cannot be called 'muscle'"),
        ([Point(commands={}, labels={"status": 1.0})], "a label cannot be called 'status'"),
        ([Point(commands={}, labels={"a": 1.0}), Point(commands={}, labels={"a": "x"})], "'a' is a number at some"),
        ([Point(commands={}, scene={"gravity": object()})], "cannot write object down"),
    ],
)
def test_points_that_do_not_suit_the_scene_are_refused(scene: Scene, points: list[Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        run_points(scene, points)


def test_starts_that_do_not_suit_the_scene_are_refused(scene: Scene, tongue: Scene) -> None:
    other = Scene(block((2, 2, 2)), fixed=["left"]).equilibrate()
    with pytest.raises(InputError, match="belongs to another speaker"):
        run_points(scene, commands(1), start=other)
    with pytest.raises(InputError, match="start must be a Posture"):
        run_points(scene, commands(1), start=scene.speaker.nodes)  # type: ignore[arg-type]
    own = tongue.equilibrate(accuracy="draft")
    with pytest.raises(InputError, match="start from rest"):
        run_points(tongue, [Point(commands={}, shape={"vault_height": 1.0})], start=own)


@pytest.mark.parametrize(
    ("executor", "message"),
    [
        (4, "must be a concurrent.futures.Executor"),
        (type("Client", (), {"get_executor": None, "submit": print})(), "pass its get_executor"),
        (type("Odd", (), {"submit": lambda *_: 1})(), "must return a concurrent.futures.Future, got int"),
    ],
)
def test_impossible_executors_are_refused(scene: Scene, executor: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        run_points(scene, commands(1), executor=executor)


def test_canonical_text_keeps_every_bit() -> None:
    value = 0.1 + 0.2
    assert json.loads(canonical({"b": (value,), "a": np.float64(value)})) == {"a": value, "b": [value]}
    assert canonical({"a": 1.0, "b": Lips(0.01, 1e-4)}) == '{"a":1.0,"b":{"area":0.0001,"length":0.01}}'
    with pytest.raises(InputError, match="cannot write"):
        canonical({"a": float("inf")})


def test_solve_errors_carry_the_study() -> None:
    assert SolveError("x").study is None
