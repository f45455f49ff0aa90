"""The sensitivity study: its design, its runs, and what its summary says."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.paper_runs import papers_own, quick_scene, some_runs

from glossa import VOWELS, InputError, Scene, SolveError, Speaker, area_function, paper
from glossa.studies import (
    MIDSAGITTAL_NODES,
    compared_changes,
    dispersion_ellipse,
    midsagittal_nodes,
    sensitivity,
    sensitivity_changes,
    sensitivity_summary,
)
from glossa.studies.dispersion import angle_between
from glossa.studies.sensitivity_summary import scatter


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return quick_scene(reference)


@pytest.fixture(scope="module")
def study(scene: Scene) -> xr.Dataset:
    return some_runs(scene)


# The design


def test_design_of_i_is_that_of_table_6() -> None:
    design = sensitivity_changes("i")
    runs = {(muscle, change) for muscle, changes in design.items() for change in changes}
    assert runs == {(muscle, float(change)) for muscle, change in paper.sensitivity_i().index}
    assert sum(map(len, design.values())) == 56


def test_muscles_that_are_silent_in_a_vowel_are_only_made_stronger() -> None:
    for vowel in VOWELS:
        for muscle, changes in sensitivity_changes(vowel).items():
            assert (max(changes) < 0.0) == (paper.forces().loc[vowel, muscle] == 0.0)


@pytest.mark.parametrize(
    ("vowel", "changes", "message"),
    [
        ("y", None, "unknown vowel 'y'"),
        ("i", {"XX": [-5.0]}, "no command of 'XX'"),
        ("i", [0.0], "not 0"),
        ("i", [-100.0], "above -100"),
        ("i", [5.0, 5.0], "must differ"),
        ("i", [math.nan], "finite"),
        ("i", ["5"], "must be a number"),
        ("i", "5", "list of numbers"),
        ("i", {"GGa": 5.0}, "list of numbers"),
        ("i", {"GGa": []}, "no change to be run"),
    ],
)
def test_impossible_designs_are_refused(scene: Scene, vowel: str, changes: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        sensitivity(scene, vowel, changes)


# The runs


def test_runs_are_equilibria_started_from_the_vowel(scene: Scene, study: xr.Dataset) -> None:
    vowel = scene.equilibrate(VOWELS["i"])
    posture = scene.equilibrate(VOWELS["i"].scaled("GGa", 0.9), start=vowel)
    run = study.sel(muscle="GGa", change=-10.0)
    nodes = list(midsagittal_nodes(scene.speaker).values())
    assert run["nodes"].values == pytest.approx(posture.positions[nodes], abs=1e-12)
    assert run["displacement"].values == pytest.approx((posture.positions - vowel.positions)[nodes], abs=1e-9)
    assert run["forces"].values == pytest.approx(posture.forces.to_numpy(), abs=1e-9)
    formants = area_function(posture, "i").formants(4).frequencies
    assert run["formants"].values == pytest.approx(formants, abs=1e-6)
    assert study["vowel_formants"].values == pytest.approx(area_function(vowel, "i").formants(4).frequencies, abs=0.01)
    assert study["vowel_positions"].values == pytest.approx(vowel.positions, abs=1e-9)


def test_table_has_units_and_tells_what_was_asked(study: xr.Dataset) -> None:
    sizes = {"muscle": 2, "change": 4, "formant": 4, "node": 6, "axis": 3, "acting": 11}
    assert sizes.items() <= dict(study.sizes).items()
    assert study["change"].values.tolist() == [-10.0, -8.0, -5.0, 5.0]
    assert {name: study[name].attrs["units"] for name in ("formants", "nodes", "displacement", "forces", "change")} == {
        "formants": "Hz",
        "nodes": "m",
        "displacement": "m",
        "forces": "N",
        "change": "%",
    }
    asked = study["asked"]
    assert int(asked.sum()) == 6
    assert not bool(asked.sel(muscle="SL", change=5.0))
    assert bool((study["converged"] == asked).all())
    assert np.isfinite(study["formants"].values[asked.values]).all()
    assert np.isnan(study["nodes"].values[~asked.values]).all()
    assert tuple(study["node"].values) == MIDSAGITTAL_NODES
    assert study.attrs["speaker_fingerprint"]
    assert study.attrs["vowel"] == "i"
    assert study.attrs["glossa_version"]


def test_failed_runs_stay_with_their_reason(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Scene.equilibrate

    def fail_one(self: Scene, commands: Any = None, **options: Any) -> Any:
        if commands is not None and abs(commands["GGa"] - 1.05 * VOWELS["i"]["GGa"]) < 1e-9:
            raise SolveError("no equilibrium today", status="stalled")
        return solve(self, commands, **options)

    monkeypatch.setattr(Scene, "equilibrate", fail_one)
    study = sensitivity(scene, "i", {"GGa": (-5.0, 5.0)})
    assert study["converged"].sel(muscle="GGa").values.tolist() == [True, False]
    assert study["reason"].sel(muscle="GGa").values.tolist() == ["", "no equilibrium today"]
    assert np.isnan(study["formants"].sel(muscle="GGa", change=5.0).values).all()
    summary = sensitivity_summary(study)
    assert int(summary["runs"]) == 2
    assert int(summary["failed"]) == 1
    assert summary["compared"].values.tolist() == [1, 1, 1]


def test_runs_that_fail_from_the_vowel_are_repeated_from_rest(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Scene.equilibrate

    def fail_warm(self: Scene, commands: Any = None, *, start: Any = None, **options: Any) -> Any:
        if start is not None and commands["GGa"] < 0.96 * VOWELS["i"]["GGa"]:
            raise SolveError("no way from here", status="stalled")
        return solve(self, commands, start=start, **options)

    monkeypatch.setattr(Scene, "equilibrate", fail_warm)
    study = sensitivity(scene, "i", {"GGa": (-5.0, 5.0)}).sel(muscle="GGa")
    assert study["started"].values.tolist() == ["rest", "vowel"]
    assert study["converged"].values.tolist() == [True, True]
    assert study["reason"].values.tolist() == ["", ""]
    posture = solve(scene, VOWELS["i"].scaled("GGa", 0.95))
    assert study["forces"].sel(change=-5.0).values == pytest.approx(posture.forces.to_numpy(), abs=1e-9)


def test_a_store_keeps_the_runs(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = tmp_path / "i.study"
    first = sensitivity(scene, "i", {"GGa": (-5.0,)}, store=store)
    solve, calls = Scene.equilibrate, []

    def count(self: Scene, commands: Any = None, **options: Any) -> Any:
        calls.append(commands)
        return solve(self, commands, **options)

    monkeypatch.setattr(Scene, "equilibrate", count)
    second = sensitivity(scene, "i", {"GGa": (-5.0,)}, store=store)
    assert len(calls) == 1  # the vowel's own posture, from which runs start
    xr.testing.assert_identical(first, second)
    with pytest.raises(InputError):
        sensitivity(scene, "i", {"GGa": (-8.0,)}, store=store)


def test_a_study_is_written_and_read_back(study: xr.Dataset, tmp_path: Path) -> None:
    study.to_netcdf(tmp_path / "study.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "study.nc", engine="h5netcdf") as opened:
        xr.testing.assert_identical(sensitivity_summary(opened.load()), sensitivity_summary(study))


# The summary


@pytest.fixture(scope="module")
def of_the_paper(study: xr.Dataset) -> xr.Dataset:
    """A study of all 56 runs with the paper's formants."""
    table = paper.sensitivity_i().index
    changes = sorted({float(change) for _, change in table})
    muscles = list(dict.fromkeys(muscle for muscle, _ in table))
    wide = study.reindex(muscle=muscles, change=changes)
    asked = [[(muscle, change) in table for change in changes] for muscle in muscles]
    wide["asked"] = (("muscle", "change"), np.array(asked))
    wide["converged"] = wide["asked"].copy()
    wide["formants"] = wide["formants"].copy(data=np.full(wide["formants"].shape, math.nan))
    places = np.random.default_rng(0).normal(size=wide["nodes"].shape) * 1e-3
    wide["nodes"] = wide["nodes"].copy(data=places)
    return papers_own(wide)


def test_the_papers_numbers_agree_with_themselves(of_the_paper: xr.Dataset) -> None:
    summary = sensitivity_summary(of_the_paper)
    assert summary["range"].values.tolist() == [103.0, 250.0, 283.0]
    assert summary["paper_range"].values.tolist() == [103.0, 250.0, 283.0]
    assert summary["correlation"].values == pytest.approx(1.0)
    assert summary["slope"].values == pytest.approx(1.0)
    assert summary["rms"].values == pytest.approx(0.0, abs=1e-9)
    assert summary["compared"].values.tolist() == [56, 56, 56]
    assert summary["same_sign"].values.tolist() == summary["large"].values.tolist()
    assert min(summary["large"].values) > 25
    assert float(summary["saturation_range"]) == float(summary["paper_saturation_range"]) == 102.0
    assert bool(summary["saturation_monotone"])
    assert bool(summary["saturation_refuted"])
    assert int(summary["failed"]) == 0
    assert float(summary["coverage"]) == pytest.approx(0.98889, abs=1e-5)


def test_opposite_changes_have_no_sign_right(of_the_paper: xr.Dataset) -> None:
    turned = of_the_paper.copy(deep=True)
    turned["formants"] = 2.0 * turned["vowel_formants"] - turned["formants"]
    summary = sensitivity_summary(turned)
    assert summary["correlation"].values == pytest.approx(-1.0)
    assert summary["same_sign"].values.tolist() == [0, 0, 0]
    assert not bool(summary["saturation_monotone"])


def test_saturation_is_not_refuted_where_f1_stays(of_the_paper: xr.Dataset) -> None:
    still = of_the_paper.copy(deep=True)
    still["formants"].loc[{"muscle": "GGa", "formant": 1}] = 321.0 + np.linspace(3.0, -3.0, 8)
    summary = sensitivity_summary(still)
    assert bool(summary["saturation_monotone"])
    assert not bool(summary["saturation_refuted"])


def test_ellipses_are_those_of_the_runs_of_each_panel(of_the_paper: xr.Dataset) -> None:
    summary = sensitivity_summary(of_the_paper, 2.0)
    for panel, count in (("all", 56), ("GGp", 8), ("GGa", 8), ("Sty", 8)):
        points = scatter(of_the_paper, panel, "palatal")
        assert points.shape == (count, 2)
        ellipse = dispersion_ellipse(points, 2.0)
        one = summary.sel(panel=panel, node="palatal")
        assert float(one["major"]) == ellipse.major
        assert float(one["angle"]) == ellipse.angle
        assert one["centre"].values == pytest.approx(points.mean(axis=0))
        assert int(one["samples"]) == count
    with pytest.raises(InputError, match="panel must be one of"):
        scatter(of_the_paper, "HG", "palatal")


def test_few_runs_have_no_ellipse(study: xr.Dataset) -> None:
    summary = sensitivity_summary(study)
    assert np.isfinite(summary["major"].sel(panel=["all", "GGa"]).values).all()
    assert np.isnan(summary["major"].sel(panel=["GGp", "Sty"]).values).all()
    assert summary["samples"].sel(panel="GGp").values.tolist() == [0] * 6


def test_other_vowels_are_compared_with_nothing(study: xr.Dataset) -> None:
    other = study.assign_attrs(vowel="u")
    assert compared_changes(other).empty
    summary = sensitivity_summary(other)
    for name in ("correlation", "paper_range", "paper_major", "paper_saturation_range"):
        assert np.isnan(summary[name].values).all()
    assert summary["compared"].values.tolist() == [0, 0, 0]


def test_a_summary_needs_a_study() -> None:
    with pytest.raises(InputError, match="result of"):
        sensitivity_summary(xr.Dataset())


@pytest.mark.slow
def test_i_on_pb_against_section_4(pb: Speaker) -> None:
    summary = sensitivity_summary(sensitivity(Scene(pb, mirror=True)))
    assert int(summary["runs"]) == 56
    assert float(summary["correlation"].sel(formant=1)) >= 0.9
    assert int(summary["same_sign"].sel(formant=1)) >= 0.9 * int(summary["large"].sel(formant=1))
    assert bool(summary["saturation_refuted"])
    clear = summary["paper_angle"].notnull()
    ours, theirs = (summary[name].sel(node=clear) for name in ("angle", "paper_angle"))
    apart = [angle_between(float(a), float(b)) for a, b in zip(ours.sel(panel="all"), theirs, strict=True)]
    assert max(apart) < 20.0
