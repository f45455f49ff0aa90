"""The accuracy study: errors fall with steps and tolerances, what pays, presets, refusals, interruption."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block

from glossa import Posture, Scene, SolveError, SolveInterrupted, Speaker
from glossa.errors import InputError
from glossa.result_files import write_dataset
from glossa.studies import accuracy_study
from glossa.studies.accuracy import FULL, QUICK, AccuracySettings, cheapest, pareto, presets, savings, worst
from glossa.studies.accuracy_choices import Choice, choices
from glossa.studies.accuracy_mesh import Limit
from glossa.studies.accuracy_runs import Outcome, Solves
from glossa.studies.machine import machine
from glossa.studies.run import Progress

SHORT = replace(QUICK, until=0.01, moving=())


@pytest.fixture(scope="module")
def told() -> list[Progress]:
    return []


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True)


@pytest.fixture(scope="module")
def smooth(reference: Speaker) -> Scene:
    """Solved sooner."""
    return Scene(reference, mirror=True, contact=False)


@pytest.fixture(scope="module")
def study(scene: Scene, told: list[Progress]) -> xr.Dataset:
    return accuracy_study(scene, replace(QUICK, threads=(1, 2)), progress=told.append)


def rows(study: xr.Dataset, family: str, kind: str = "movement") -> xr.Dataset:
    table = worst(study)
    return table.isel(choice=((table["family"] == family) & (table["kind"] == kind)).to_numpy())


@pytest.mark.parametrize("family", ["SDIRK2", "BDF2", "backward Euler", "adaptive"])
def test_errors_of_movements_fall_with_the_step(study: xr.Dataset, family: str) -> None:
    own = rows(study, family)
    assert (np.diff(own["setting"]) < 0.0).all()
    for measure in ("nodes", "largest", "force"):
        assert (np.diff(own[measure]) < 0.0).all(), measure
        assert (own[measure] > 0.0).all()


def test_second_order_beats_first_order(study: xr.Dataset) -> None:
    errors = {family: rows(study, family)["nodes"].to_numpy() for family in ("SDIRK2", "BDF2", "backward Euler")}
    assert (errors["SDIRK2"] < errors["BDF2"]).all()
    assert (errors["BDF2"] < errors["backward Euler"]).all()


def test_errors_of_equilibria_fall_with_the_depth_of_contact(study: xr.Dataset) -> None:
    own = rows(study, "contact", "posture")
    assert own["setting"].to_numpy() == pytest.approx([20e-6, 2e-6])
    for measure in ("nodes", "largest", "force"):
        assert float(own[measure][1]) < 0.8 * float(own[measure][0]), measure  # 0.68: the deeper one lay less deep
    assert float(own["formant"].max()) < 1.0  # Hz; 0.3 and 0.4 seen, what the slicing makes of micrometres
    preset = rows(study, "preset", "posture")
    assert float(preset["nodes"][2]) < float(preset["nodes"][1])


def test_half_and_threads_change_nothing(study: xr.Dataset) -> None:
    preset = rows(study, "preset", "posture")
    standard = preset.isel(choice=(preset["label"] == "standard").to_numpy())
    for family, digits in (("half", 1e-4), ("threads", 0.0)):
        own = rows(study, family, "posture")
        assert own.sizes["choice"] == 2
        for measure in ("nodes", "force"):
            assert own[measure].to_numpy() == pytest.approx(float(standard[measure][0]), rel=digits, abs=0.0)
    full = rows(study, "half", "posture")
    assert full["label"].values.tolist() == ["mirrored", "full"]
    assert float(full["cpu_seconds"][1]) > float(full["cpu_seconds"][0])


def test_references_are_better_than_what_they_measure(study: xr.Dataset) -> None:
    for against, kind in (("solve", "posture"), ("steps", "movement")):
        table = worst(study)
        own = table["largest"][((table["against"] == against) & (table["kind"] == kind)).to_numpy()]
        away = float(study["reference_largest"].sel(reference=against, vowel="i"))
        assert 0.0 < away < float(own.min())


def test_presets(study: xr.Dataset) -> None:
    table = presets(study)
    assert table.index.tolist() == [
        (kind, accuracy) for kind in ("posture", "movement") for accuracy in ("draft", "standard", "reference")
    ]
    assert np.isfinite(table.to_numpy(dtype=float)).all()
    movement = table.loc["movement"]
    assert movement["nodes_mm"].is_monotonic_decreasing
    assert movement["steps"].is_monotonic_increasing
    one = study.isel(choice=((study["family"] == "adaptive") & (study["label"] == "draft")).to_numpy())
    assert movement.loc["draft", "nodes_mm"] == pytest.approx(1e3 * float(one["node_error"].max()))
    assert movement.loc["draft", "formant_Hz"] == pytest.approx(float(one["formant_error"].max()))


def test_movements_state_errors_of_their_size(study: xr.Dataset) -> None:
    own = study.isel(choice=(study["family"] == "adaptive").to_numpy()).sel(vowel="i")
    assert (own["stated_error"] > 0.0).all()
    assert (np.diff(own["stated_error"]) < 0.0).all()
    assert np.isnan(study["stated_error"][(study["kind"] == "posture").to_numpy()]).all()


def test_effects_left_out(study: xr.Dataset) -> None:
    table = savings(study)
    assert table.index.tolist() == [
        (kind, effect) for kind in ("posture", "movement") for effect in ("all", "no contact", "no gravity")
    ]
    for kind in ("posture", "movement"):
        own = table[table.index.get_level_values("kind") == kind].droplevel("kind").to_dict("index")
        assert own["all"]["saved"] == own["all"]["nodes_mm"] == 0.0
        assert own["no contact"]["nodes_mm"] > 0.3
        assert own["no gravity"]["formant_Hz"] > 10.0
        assert own["no contact"]["saved"] == 1.0 - own["no contact"]["cpu_s"] / own["all"]["cpu_s"]


@pytest.mark.parametrize("measure", ["nodes", "largest", "force", "formant"])
@pytest.mark.parametrize("cost", ["wall_seconds", "cpu_seconds"])
def test_what_pays_is_a_front(study: xr.Dataset, measure: str, cost: str) -> None:
    table, marked = worst(study), pareto(study, measure, cost)
    assert not marked[(table["against"] == "all effects").to_numpy()].any()
    for against in ("solve", "steps"):
        own = (table["against"] == against).to_numpy()
        errors, seconds = table[measure].to_numpy()[own], table[cost].to_numpy()[own]
        front = marked.to_numpy()[own]
        order = np.argsort(seconds[front], kind="stable")
        assert (np.diff(errors[front][order]) <= 0.0).all()
        assert front[errors == errors.min()].any()
        assert front[seconds == seconds.min()].any()
        for k in np.flatnonzero(~front):
            dominates = (errors <= errors[k]) & (seconds <= seconds[k])
            assert (dominates & ((errors < errors[k]) | (seconds < seconds[k]))).any()


def test_cheapest(study: xr.Dataset) -> None:
    table = worst(study)
    best = cheapest(study, largest=0.1e-3)
    assert best is not None
    family, label = best.split(", ")
    chosen = rows(study, family).set_index(choice="label").sel(choice=label)
    assert float(chosen["largest"]) <= 0.1e-3
    good = ((table["against"] == "steps") & (table["largest"] <= 0.1e-3)).to_numpy()
    assert float(chosen["wall_seconds"]) == table["wall_seconds"].to_numpy()[good].min()
    assert cheapest(study, largest=1e-9) is None
    assert cheapest(study, "posture", nodes=3e-6) == "contact, 2 µm"
    with pytest.raises(InputError, match="kind must be"):
        cheapest(study, "vowel")
    with pytest.raises(InputError, match="largest must be positive"):
        cheapest(study, largest=-1.0)


def test_progress_and_provenance(study: xr.Dataset, told: list[Progress], scene: Scene) -> None:
    assert told[0].done == 0
    assert [one.done for one in told] == list(range(told[-1].total + 1))
    assert study.attrs["speaker_fingerprint"] == scene.speaker.fingerprint
    assert study.attrs["settings"] == "own"
    assert set(machine()) <= set(study.attrs)
    assert study["node_error"].attrs["units"] == "m"
    units = {
        family: study["setting_units"].values[study["family"] == family].tolist() for family in ("BDF2", "adaptive")
    }
    assert units == {"BDF2": ["s"] * 2, "adaptive": ["m"] * 3}
    assert not study["reason"].values.astype(bool).any()


def test_round_trip(study: xr.Dataset, tmp_path: Path) -> None:
    write_dataset(study, tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as back:
        xr.testing.assert_identical(back.load(), study)
        assert presets(back).equals(presets(study))


# Meshes


def made_up(values: float, trace: float) -> Outcome:
    return Outcome(
        trace=np.full((1, 7, 3), trace),
        ends=np.zeros(1),
        forces=np.full((1, 2), values),
        formants=np.full(4, 100.0 * values),
        counts={},
        cpu=1.0,
        wall=1.0,
    )


def test_limit_of_a_power() -> None:
    outcomes = {r: made_up(7.0 + 2.0 / r**1.5, 0.5 + 0.1 / r**1.2) for r in (1, 2, 3)}
    limit = Limit(outcomes, list(range(6)))
    assert limit.order == pytest.approx(1.2)
    for r, outcome in outcomes.items():
        away = limit.error(outcome, r, of_limit=True)
        assert away.nodes == pytest.approx(math.sqrt(3.0) * 0.1 / r**1.2)
        assert away.largest == pytest.approx(away.nodes[0])
        assert away.forces == pytest.approx(2.0 / r**1.5)
        assert away.formants == pytest.approx(200.0 / r**1.5)
    other = limit.error(made_up(8.0, 0.6), 1, of_limit=False)
    assert other.forces == pytest.approx(1.0)


def test_limit_without_an_order_and_of_two_meshes() -> None:
    turning = {1: made_up(5.0, 0.5), 2: made_up(6.0, 0.6), 3: made_up(5.5, 0.8)}
    limit = Limit(turning, [0])
    assert math.isnan(limit.order)
    finest = limit.error(turning[3], 3, of_limit=True)
    assert finest.forces == pytest.approx(0.5)
    assert finest.largest == pytest.approx(math.sqrt(3.0) * 0.2)
    two = Limit({r: turning[r] for r in (1, 2)}, [0])
    assert np.isnan(two.error(turning[2], 2, of_limit=True).forces).all()
    assert two.error(turning[1], 1, of_limit=True).forces == pytest.approx(1.0)


def test_mesh_and_element(reference: Speaker) -> None:
    scene = Scene(reference, mirror=True, contact=False, hyoid="fixed")
    settings = replace(SHORT, vowels=("ə",), resolutions=(1, 2), residuals=(), gaps=(), effects=(), threads=())
    study = accuracy_study(scene, settings)
    mesh, element = rows(study, "mesh", "posture"), rows(study, "element", "posture")
    assert mesh["setting"].values.tolist() == [1.0, 0.5]
    assert element["setting"].values.tolist() == [1.0, 0.5, 1.0, 0.5]
    assert element["label"].values.tolist()[2:] == ["Q2P1, resolution 1", "Q2P1, resolution 2"]
    assert 1e-5 < float(mesh["nodes"][0]) < 2e-3
    assert np.isnan(mesh["nodes"][1])
    assert float(element["nodes"][1]) < float(element["nodes"][0])
    assert float(element["nodes"][0]) > float(mesh["nodes"][0])  # locks
    assert float(element["nodes"][3]) < float(element["nodes"][2])
    assert int(study["asked"].sum()) == study.sizes["choice"]


# What goes wrong


def test_interruption(smooth: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve, calls = Scene.equilibrate, iter(range(100))

    def interrupted(self: Scene, *args: Any, **options: Any) -> Posture:
        if next(calls) == 4:
            raise SolveInterrupted("stopped")
        return solve(self, *args, **options)

    monkeypatch.setattr(Scene, "equilibrate", interrupted)
    with pytest.raises(SolveInterrupted, match=r"interrupted: 4 of \d+ solves are finished") as stop:
        accuracy_study(smooth, SHORT)
    done = np.isfinite(stop.value.study["cpu_seconds"].sel(vowel="i").to_numpy())
    assert done.tolist() == [True, True] + [False] * (len(done) - 2)  # two choices, and two references


def test_a_failure_is_a_row_without_numbers(smooth: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Scene.equilibrate

    def failing(self: Scene, *args: Any, **options: Any) -> Posture:
        if options.get("accuracy") == "reference":
            raise SolveError("no equilibrium today; .posture is the last good state")
        return solve(self, *args, **options)

    monkeypatch.setattr(Scene, "equilibrate", failing)
    study = accuracy_study(smooth, replace(SHORT, residuals=(), gaps=(), effects=()))
    own = rows(study, "preset", "posture")
    assert own["failed"].values.tolist() == [0, 0, 1]
    assert np.isfinite(own["nodes"].to_numpy()).tolist() == [True, True, False]
    assert study["reason"].values[2].tolist() == ["no equilibrium today"]
    assert not bool(pareto(study)[2])


def test_speakers_that_cannot_be_divided(scene: Scene) -> None:
    other = Scene(Speaker.reference(landmarks={"shape": {"pharynx_length": 6.0}}), mirror=True)
    with pytest.raises(InputError, match="only the built-in speaker can be divided"):
        accuracy_study(other, replace(QUICK, resolutions=(1, 2)))
    with pytest.raises(InputError, match="unknown muscle"):
        accuracy_study(Scene(block((2, 2, 2)), fixed=["left"]), SHORT)
    with pytest.raises(InputError, match="scene must be a Scene"):
        accuracy_study(scene.speaker)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="settings must be"):
        accuracy_study(scene, "quick")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"vowels": "i"}, "list of names"),
        ({"vowels": ("i", "i")}, "twice"),
        ({"vowels": ("y",)}, "y"),
        ({"vowels": (), "moving": ()}, "at least one vowel"),
        ({"effects": ("sound",)}, "unknown effect 'sound'"),
        ({"until": 0.0}, "until"),
        ({"steps": (0.0001,)}, "reference_step must be shorter"),
        ({"steps": (-1.0,)}, "steps must be positive"),
        ({"gaps": (math.nan,)}, "gaps must be finite"),
        ({"resolutions": (2, 3)}, "rise from 1"),
        ({"resolutions": ()}, "rise from 1"),
        ({"resolutions": (1, 1)}, "rise from 1"),
        ({"threads": (0,)}, "threads"),
        ({"repetitions": 0}, "repetitions"),
    ],
)
def test_wrong_settings_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(QUICK, **wrong)


def test_other_datasets_are_refused(study: xr.Dataset) -> None:
    for read in (worst, pareto, presets, savings, cheapest):
        with pytest.raises(InputError, match="accuracy_study"):
            read(xr.Dataset())
    with pytest.raises(InputError, match="measure must be"):
        pareto(study, "mm")
    with pytest.raises(InputError, match="cost must be"):
        pareto(study, cost="seconds")


# Settings and choices


def test_settings_have_names() -> None:
    assert [one.name for one in (FULL, QUICK, replace(FULL, resolutions=(1, 2, 3)), SHORT)] == [
        "full",
        "quick",
        "full",
        "own",
    ]
    assert AccuracySettings() == FULL


@pytest.fixture
def listed(scene: Scene) -> list[Choice]:
    return choices(scene, FULL, (1, 2, 3))


def test_every_choice_changes_one_thing(listed: list[Choice]) -> None:
    names = [(choice.kind, choice.family, choice.label) for choice in listed]
    assert len(set(names)) == len(names)
    for choice in listed:
        changed = len(choice.scene) + len(choice.solve) + (choice.resolution != 1)
        assert changed <= (2 if choice.family in ("SDIRK2", "BDF2", "backward Euler", "element") else 1), choice


def test_effects_that_a_scene_lacks_are_not_left_out(reference: Speaker) -> None:
    bare = Scene(reference, mirror=True, contact=False, hyoid="fixed")
    labels = {choice.label for choice in choices(bare, FULL, (1,)) if choice.family == "effects"}
    assert labels == {"all", "no stiffening", "no reflex", "no force_velocity", "no damping", "no gravity"}
    assert not [choice for choice in choices(bare, FULL, (1,)) if choice.family in ("contact", "mesh")]


def test_long_solves_are_not_repeated(smooth: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[float] = []
    solve = Scene.equilibrate

    def counted(self: Scene, *args: Any, **options: Any) -> Posture:
        calls.append(0.0)
        return solve(self, *args, **options)

    monkeypatch.setattr(Scene, "equilibrate", counted)
    run = choices(smooth, QUICK, (1,))[0].run("i")
    for long, expected in ((5.0, 3), (0.0, 1)):
        monkeypatch.setattr("glossa.studies.accuracy_runs.LONG", long)
        calls.clear()
        solves = Solves(smooth, 0.01, None, 3, lambda *_: None)
        assert solves.outcome(run) is solves.outcome(run)
        assert len(calls) == expected
