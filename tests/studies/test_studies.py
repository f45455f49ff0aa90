"""Vowels, tables and single muscles."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from glossa import VOWELS, InputError, MotorCommands, Posture, Scene, SolveError, Speaker
from glossa.studies import (
    displacements_mm,
    posture_table,
    rest_posture,
    single_muscle,
    single_muscle_command,
    single_muscles,
    tracked_nodes,
    vowels,
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(Speaker.reference(), mirror=True)


def test_vowels_are_the_equilibria_of_table_3(scene: Scene) -> None:
    postures = vowels(scene, ["u", "ə"])
    assert list(postures) == ["u", "ə"]
    assert postures["u"].commands == VOWELS["u"]
    assert all(p.report is not None and p.report.converged for p in postures.values())


def test_unknown_vowels_are_refused(scene: Scene) -> None:
    with pytest.raises(InputError, match="unknown vowel 'y'"):
        vowels(scene, ["i", "y"])


def test_table_has_forces_and_displacements_with_units(scene: Scene) -> None:
    postures = vowels(scene, ["u", "ə"])
    table = posture_table(postures)
    assert dict(table.sizes) == {"posture": 2, "muscle": 11, "point": 2, "axis": 2}
    assert table["forces"].attrs["units"] == "N"
    assert table["displacement"].attrs["units"] == "mm"
    assert float(table["forces"].sel(posture="u", muscle="Sty")) == postures["u"].forces["Sty"] > 1.0
    tip = postures["u"].displacements[scene.speaker.node_sets["tip"][0]]
    assert table["displacement"].sel(posture="u", point="tip").values == pytest.approx(tip[[0, 2]] * 1e3)
    assert bool(table["converged"].all())


def test_a_vowel_that_fails_stops_no_other_and_leaves_no_number(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    solve = Scene.equilibrate

    def fail_once(self: Scene, commands: MotorCommands) -> Posture:
        posture = solve(self, commands)
        if commands != VOWELS["ə"]:
            return posture
        assert posture.report is not None
        bad = replace(posture, report=replace(posture.report, converged=False, status="stalled"))
        raise SolveError("no equilibrium: stalled", status="stalled", posture=bad, report=bad.report)

    monkeypatch.setattr(Scene, "equilibrate", fail_once)
    with caplog.at_level(logging.WARNING, logger="glossa"):
        table = posture_table(vowels(scene, ["ə", "u"]))
    assert "vowel ə" in caplog.text
    assert table["converged"].values.tolist() == [False, True]
    assert np.isnan(table["forces"].sel(posture="ə")).all()
    assert np.isnan(table["displacement"].sel(posture="ə")).all()
    assert np.isfinite(table["forces"].sel(posture="u")).all()


def test_tables_need_postures_of_one_speaker() -> None:
    with pytest.raises(InputError, match="at least one posture"):
        posture_table({})


def test_points_come_from_node_sets_or_the_contour() -> None:
    speaker = Speaker.reference()
    assert tracked_nodes(speaker) == {name: int(speaker.node_sets[name][0]) for name in ("tip", "dorsum")}
    contour = speaker.contours["dorsum"]
    plain = Speaker(speaker.nodes[:-2], speaker.hexahedra, contours={"dorsum": contour})
    highest = contour[speaker.nodes[contour, 2].argmax()]
    assert tracked_nodes(plain) == {"tip": contour[0], "dorsum": highest}
    with pytest.raises(InputError, match="neither a node set 'tip' nor a contour"):
        tracked_nodes(Speaker(speaker.nodes[:-2], speaker.hexahedra))


def test_rest_is_free_of_force_and_displacement() -> None:
    speaker = Speaker.reference()
    posture = rest_posture(speaker)
    assert np.array_equal(posture.positions, speaker.nodes)
    assert posture.forces.tolist() == [0.0] * 11
    assert posture_table({"rest": posture})["displacement"].values.tolist() == [[[0.0, 0.0]] * 2]


def test_the_papers_commands_of_single_muscles() -> None:
    assert [single_muscle_command(name) for name in ("GGp", "Sty", "IL", "SL")] == [0.75, 0.85, 0.85, 0.85]


def test_a_muscle_alone_is_the_only_one_with_force(scene: Scene) -> None:
    posture = single_muscle(scene, "HG")
    assert posture.commands == MotorCommands({"HG": 0.75})
    assert posture.forces["HG"] > 1.0
    assert posture.forces.drop("HG").abs().max() == 0.0
    assert displacements_mm(posture)["dorsum"][1] < -1.0  # section III.A.1: HG lowers the dorsum


def test_several_muscles_and_unknown_ones(scene: Scene) -> None:
    assert list(single_muscles(scene, ["GGa", "MH"])) == ["GGa", "MH"]
    with pytest.raises(InputError, match="unknown muscle 'XYZ'"):
        single_muscle(scene, "XYZ")
