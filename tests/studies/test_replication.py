"""The paper beside one speaker: rules, rows, failures, interruption."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from tests.blocks import block
from tests.studies.paper_runs import papers_own, quick_scene
from tests.studies.small_replication import CHANGED, shorten, small_replication

from glossa import VOWELS, InputError, Scene, SolveError, SolveInterrupted, Speaker, area_function, paper
from glossa.cli.options import make_scene
from glossa.data_files import data_path
from glossa.studies import Progress, Replication, muscle_effects, replicate
from glossa.studies import replication_runs as runs_module
from glossa.studies.replication import PLACES
from glossa.studies.replication_row import COLUMNS, number_row, statement_row, table_of_rows
from glossa.studies.replication_rules import RULE_WORDS, RULES, VERDICTS, verdict
from glossa.studies.replication_runs import Runs
from glossa.studies.replication_variation import dispersion_rows, saturation_rows, table_6

SIZES = {
    "Table II": 44,
    "Table IV": 16,
    "section III.A.1": 36,
    "section III.B": 3,
    "Table VI": 168,
    "section IV.B": 19,
    "section IV.C": 4,
    "section V.A": 7,
    "section V.B": 10,
}


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return quick_scene(reference)


@pytest.fixture(scope="module")
def result(reference: Speaker) -> Replication:
    return small_replication(reference)


def one(result: Replication, place: str, item: str, measure: str) -> pd.Series[Any]:
    rows = result.rows
    found = rows[(rows["place"] == place) & (rows["item"] == item) & (rows["measure"] == measure)]
    assert len(found) == 1
    return found.iloc[0]


# Rules


@pytest.mark.parametrize(
    ("rule", "theirs", "ours", "agrees"),
    [
        ("force", 10.0, 12.9, True),
        ("force", 10.0, 13.1, False),
        ("force", 10.0, 6.9, False),
        ("force", 0.0, 0.09, True),
        ("force", 0.0, 0.11, False),
        ("formant", 1000.0, 1099.0, True),
        ("formant", 1000.0, 1101.0, False),
        ("formant", 1000.0, 899.0, False),
        ("formant change", 5.0, 0.6, True),
        ("formant change", 5.0, 0.4, False),
        ("formant change", -5.0, -300.0, True),
        ("formant change", -5.0, 5.0, False),
        ("formant change", 4.0, -9.9, True),
        ("formant change", 4.0, 10.1, False),
        ("formant change", 0.0, 0.0, True),
        ("span", 100.0, 139.0, True),
        ("span", 100.0, 59.0, False),
        ("displacement", 10.0, 13.9, True),
        ("displacement", 10.0, 14.1, False),
        ("displacement", 1.0, 1.9, True),
        ("displacement", 1.0, 2.1, False),
        ("displacement below", 0.5, 1.4, True),
        ("displacement below", 0.5, 0.0, True),
        ("displacement below", 0.5, 1.6, False),
        ("ellipse axis", 5.0, 6.9, True),
        ("ellipse axis", 5.0, 2.9, False),
        ("angle", 173.0, 4.0, True),
        ("angle", 173.0, 14.0, False),
        ("angle", 133.0, 109.0, False),
        ("force change", 1.0, 3.9, True),
        ("force change", 1.0, -0.1, False),
        ("force change", 8.0, 11.1, False),
        ("order", 1.0, 3.1, True),
        ("order", 1.0, 0.31, False),
    ],
)
def test_rules(rule: str, theirs: float, ours: float, agrees: bool) -> None:
    assert verdict(rule, theirs, ours) == ("agrees" if agrees else "differs")


@pytest.mark.parametrize("rule", RULES)
def test_no_number_of_ours_is_a_failure_by_every_rule(rule: str) -> None:
    assert verdict(rule, 1.0, math.nan) == "failed"
    assert verdict(rule, 1.0, math.inf) == "failed"
    assert RULE_WORDS[rule]


def test_rows_tell_deviations() -> None:
    force = number_row("p", "i", "m", "N", paper=4.0, ours=3.0, rule="force")
    assert (force.deviation, force.deviation_percent, force.printed) == (-1.0, -25.0, "4")
    assert math.isnan(number_row("p", "i", "m", "N", paper=0.0, ours=3.0, rule="force").deviation_percent)
    angle = number_row("p", "i", "m", "°", paper=173.0, ours=4.0, rule="angle")
    assert (angle.deviation, angle.verdict) == (11.0, "agrees")
    assert math.isnan(angle.deviation_percent)


def test_a_wrong_direction_differs_whatever_the_number() -> None:
    row = number_row("p", "i", "m", "mm", paper=0.5, ours=0.5, rule="displacement", right=False)
    assert (row.verdict, row.note) == ("differs", "wrong direction")


def test_statements_are_right_wrong_or_failed() -> None:
    ours = (1.0, -1.0, math.nan)
    rows = [statement_row("p", "i", "m", "mm", printed="up", ours=value, right=value > 0.0) for value in ours]
    assert [row.verdict for row in rows] == ["right", "wrong", "failed"]
    assert rows[2].note
    assert tuple(table_of_rows(rows).columns) == COLUMNS


# A replication


def test_every_number_of_the_paper_has_a_row(result: Replication) -> None:
    counts = result.totals
    assert counts["rows"].to_dict() == {**SIZES, "all": sum(SIZES.values())}
    assert counts[list(VERDICTS)].sum(axis=1).to_dict() == counts["rows"].to_dict()
    assert tuple(result.rows.columns) == COLUMNS
    assert not result.rows.duplicated(["place", "item", "measure"]).any()
    assert set(result.rows["rule"]) <= set(RULE_WORDS)
    assert (result.rows["printed"] != "").all()
    stated = result.rows["rule"] == "statement"
    assert result.rows.loc[stated, "paper"].isna().all()
    assert result.rows.loc[~stated, "paper"].notna().all()


def test_rows_hold_the_numbers_of_the_paper_and_of_the_studies(scene: Scene, result: Replication) -> None:
    posture = scene.equilibrate(VOWELS["i"])
    force = one(result, "Table II", "/i/", "GGp")
    assert force["paper"] == paper.forces().loc["i", "GGp"]
    assert force["ours"] == pytest.approx(float(posture.forces["GGp"]), abs=1e-9)
    formant = one(result, "Table IV", "/i/", "F2")
    assert (formant["paper"], formant["printed"]) == (2095.0, "2095")
    assert formant["ours"] == pytest.approx(float(area_function(posture, "i").formants(4).frequencies[1]), abs=1e-6)
    effects = muscle_effects(scene)
    ours = result.rows.loc[result.rows["place"] == "section III.A.1", "ours"]
    assert ours.to_numpy() == pytest.approx(effects["ours_mm"].to_numpy(), abs=1e-9)
    numbers = result.rows[(result.rows["place"] == "section III.A.1") & result.rows["paper"].notna()]
    magnitudes = effects[effects["agrees"].notna()]
    assert (numbers["verdict"] == "agrees").tolist() == (
        magnitudes["agrees"].astype(bool) & magnitudes["right"]
    ).tolist()
    assert one(result, "section III.A.1", "Vert", "palatal down")["printed"] == "below 0.5"
    assert one(result, "section V.A", "silent, supine", "tip, distance from rest")["paper"] == 9.0
    tip = result.runs.gravity["final_tip"].sel(control="silent", gravity="supine")  # type: ignore[index]
    assert one(result, "section V.A", "silent, supine", "tip, distance from rest")["ours"] == pytest.approx(
        1e3 * float(np.hypot(tip[0], tip[2]))
    )
    assert one(result, "section V.B", "tongue", "weight")["ours"] == pytest.approx(
        scene.speaker.volume * 1040.0 * 9.81, rel=1e-3
    )
    assert result.provenance["speaker_fingerprint"] == scene.speaker.fingerprint
    assert all(result.provenance.values())


def test_table_6_tells_changes_against_the_vowel(result: Replication) -> None:
    row = one(result, "Table VI", "GGa -10 %", "change of F1")
    assert (row["paper"], row["printed"]) == (54.0, "375")
    study = result.runs.sensitivity
    assert study is not None
    run = study["formants"].sel(muscle="GGa", change=-10.0, formant=1)
    assert row["ours"] == pytest.approx(float(run - study["vowel_formants"].sel(formant=1)), abs=1e-9)
    made = result.rows[(result.rows["place"] == "Table VI") & (result.rows["verdict"] != "failed")]
    assert len(made) == 3 * sum(map(len, CHANGED.values()))
    missing = one(result, "Table VI", "MH +10 %", "change of F1")
    assert (missing["verdict"], missing["note"]) == ("failed", "not run")
    assert "6 runs, 0 failed; 0 that failed" in result.remarks["Table VI"]


def test_the_papers_own_formants_agree_everywhere(result: Replication) -> None:
    assert result.runs.sensitivity is not None
    runs = replace(result.runs, sensitivity=papers_own(result.runs.sensitivity))
    rows = table_6(runs)
    assert len(rows) == 168
    assert all(row.deviation == pytest.approx(0.0, abs=1e-9) for row in rows)
    flipped = papers_own(result.runs.sensitivity)
    flipped["formants"] = 2.0 * flipped["vowel_formants"] - flipped["formants"]
    turned = table_6(replace(result.runs, sensitivity=flipped))
    large = [row for row in turned if abs(row.paper) >= 5.0]
    assert len(large) > 100
    assert {row.verdict for row in large} == {"differs"}
    whole = papers_own(result.runs.sensitivity)
    whole["asked"][:] = True
    whole["converged"][:] = True
    spans = saturation_rows(replace(result.runs, sensitivity=whole))
    assert [row.verdict for row in spans] == ["agrees", "agrees", "agrees", "right"]
    assert [row.ours for row in spans] == pytest.approx([103.0, 250.0, 283.0, 102.0])


def test_without_results_every_row_is_there_and_failed() -> None:
    rows = [row for place in PLACES for row in place(Runs(reasons={"sensitivity": "no luck"}))]
    assert len(rows) == sum(SIZES.values())
    assert {row.verdict for row in rows} == {"failed"}
    assert all(row.note for row in rows)
    assert dispersion_rows(Runs(reasons={"sensitivity": "no luck"}))[0].note == "no luck"


# Failures


@pytest.mark.parametrize(
    ("study", "places"),
    [
        ("sensitivity", {"Table VI", "section IV.B", "section IV.C"}),
        ("muscle_effects", {"section III.A.1"}),
        ("transversalis", {"section III.B"}),
        ("gravity", {"section V.A", "section V.B"}),
        ("vowels", {"Table II", "Table IV"}),
    ],
)
def test_a_study_that_fails_is_told_and_the_rest_goes_on(
    study: str, places: set[str], scene: Scene, result: Replication, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise SolveError("no solution today", status="stalled")

    kept = {
        "sensitivity": result.runs.sensitivity,
        "muscle_effects": result.runs.effects,
        "single_muscles": result.runs.muscles,
        "transversalis": result.runs.transversalis,
        "gravity": result.runs.gravity,
    }
    for name, value in kept.items():
        monkeypatch.setattr(runs_module, name, lambda *_, value=value, **__: value)
    monkeypatch.setattr(runs_module, "vowels", lambda _, names: {name: result.runs.vowels[name] for name in names})
    monkeypatch.setattr(runs_module, study, fail)
    found = replicate(scene).rows
    inside = found["place"].isin(places) & (found["measure"] != "weight")
    assert (found.loc[inside, "verdict"] == "failed").all()
    assert (found.loc[inside, "note"] == "no solution today").all()
    outside = found[~inside].reset_index(drop=True)
    pd.testing.assert_frame_equal(outside, result.rows[~inside].reset_index(drop=True))


def test_a_vowel_without_equilibrium_fails_alone(
    scene: Scene, result: Replication, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve = Scene.equilibrate

    def fail_one(self: Scene, commands: Any = None, **options: Any) -> Any:
        posture = solve(self, commands, **options)
        if commands is not None and dict(commands) == dict(VOWELS["u"]):
            assert posture.report is not None
            last = replace(posture, report=replace(posture.report, converged=False, status="stalled"))
            raise SolveError("no equilibrium", status="stalled", posture=last)
        return posture

    monkeypatch.setattr(Scene, "equilibrate", fail_one)
    postures, reasons = runs_module._vowels(scene, lambda _: None)
    assert list(postures) == ["i", "ə", "a"]
    assert reasons == {"vowels u": "the solve of /u/ ended with stalled"}
    rows = [row for place in PLACES[:2] for row in place(replace(result.runs, vowels=postures, reasons=reasons))]
    failed = [row for row in rows if row.verdict == "failed"]
    assert {row.item for row in failed if row.place == "Table II"} == {"/u/"}
    assert {row.note for row in failed} == {"the solve of /u/ ended with stalled"}


def test_interrupted_and_resumed(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shorten(monkeypatch)
    store = tmp_path / "i.study"

    def stop(_: str, points: Progress | None) -> None:
        if points is not None and points.done == 3:
            raise KeyboardInterrupt

    with pytest.raises(SolveInterrupted, match="3 of 7 points"):
        replicate(scene, store=store, progress=stop)
    seen: list[Progress] = []
    words: list[str] = []

    class EnoughError(Exception):
        pass

    def watch(line: str, points: Progress | None) -> None:
        words.append(line)
        if points is not None:
            seen.append(points)
        elif line.startswith("Tables II"):
            raise EnoughError

    with ThreadPoolExecutor(1) as pool, pytest.raises(EnoughError):
        replicate(scene, store=store, executor=pool, progress=watch)
    assert (seen[0].resumed, seen[0].done, seen[-1].done) == (3, 3, 7)
    assert words[0].startswith("Table VI")


# Refusals


def test_other_scenes_are_refused(reference: Speaker, scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="upright gravity"):
        replicate(quick_scene(reference, gravity="supine"))
    with pytest.raises(InputError, match="a mobile hyoid"):
        replicate(quick_scene(reference, hyoid="fixed"))
    with pytest.raises(InputError, match="muscles of Table III"):
        replicate(Scene(block((2, 2, 2)), fixed=["left"]))
    with pytest.raises(InputError, match="is a folder"):
        replicate(scene, store=tmp_path)


def test_numbers_in_running_text_say_where_they_come_from() -> None:
    path = data_path("paper/in_text/sections_4_and_5.csv")
    assert path.read_text(encoding="utf-8").startswith("# Buchaillard, S., Perrier, P. & Payan, Y. (2009)")


# Both speakers, with every effect


def check_whole(result: Replication) -> None:
    """Every equilibrium is found, and most of what each part of the paper says is found here, too."""
    counts = result.totals
    statics = [place for place in SIZES if place not in ("section V.A", "section V.B")]
    assert (counts.loc[statics, "failed"] == 0).all()
    failed = result.rows[result.rows["verdict"] == "failed"]
    assert (failed["note"] != "").all()
    good = (counts["agrees"] + counts["right"]) / counts["rows"]
    for place, least in {"Table II": 0.75, "Table IV": 0.75, "section III.A.1": 0.7, "Table VI": 0.6}.items():
        assert good[place] >= least, place
    assert good["all"] >= 0.65


@pytest.mark.slow
def test_the_built_in_speaker(reference: Speaker) -> None:
    check_whole(replicate(make_scene(reference)))


@pytest.mark.slow
def test_pb(pb: Speaker) -> None:
    check_whole(replicate(make_scene(pb)))
