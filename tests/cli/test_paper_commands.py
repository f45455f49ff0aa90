"""The commands of the paper's studies: tables, JSON, files, exit codes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from glossa import Scene, SolveError
from glossa.cli import main

QUICK = ["--no-contact"]


def printed_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main([*arguments, *QUICK, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert isinstance(result, dict)
    return result


def test_sensitivity_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    result = printed_json(capsys, "sensitivity", "i", "--changes=-10,10")
    assert len(result["runs"]) == 18
    assert result["converged"] is True
    assert result["failed"] == 0
    run = result["runs"][0]
    assert (run["muscle"], run["change_percent"]) == ("GGa", -10.0)
    assert len(run["formants_Hz"]) == 4
    assert len(run["displacement_mm"]) == 6
    assert result["formants"]["F1"]["compared"] == 14  # Table VI has no weaker GGm, HG, IL and SL
    assert result["formants"]["F1"]["paper_range"] == 103.0
    assert result["ellipses"]["all"]["apical"]["samples"] == 18
    assert result["ellipses"]["all"]["apical"]["paper_major_mm"] == 8.3
    assert result["ellipses"]["GGp"]["apical"]["major_mm"] is None  # two samples
    assert result["saturation"]["paper_F1_range_Hz"] == 102.0


def test_sensitivity_as_tables_with_pictures_and_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture, curve, table, store = (tmp_path / name for name in ("a.png", "b.png", "c.nc", "d.study"))
    options = ["--changes=-5", "--plot", str(picture), "--plot-saturation", str(curve), "--save", str(table)]
    assert main(["sensitivity", *options, "--store", str(store), *QUICK]) == 0
    printed = capsys.readouterr()
    for words in ("9 runs, 0 failed", "GGa", "103", "8.3", "98.9 %", "Saturation by GGa"):
        assert words in printed.out
    assert picture.stat().st_size > 10_000
    assert curve.stat().st_size > 10_000
    with xr.open_dataset(table, engine="h5netcdf") as study:
        assert study.attrs["study"] == "sensitivity"
        assert int(study["asked"].sum()) == 9
    assert main(["sensitivity", "--changes=-8", "--store", str(store), *QUICK]) == 2  # the store of another study
    assert str(store) in capsys.readouterr().err


def test_gravity(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pictures = [tmp_path / "shapes.png", tmp_path / "forces.png"]
    options = [
        "--until",
        "0.02",
        "--vowel-until",
        "0.04",
        "--plot",
        str(pictures[0]),
        "--plot-forces",
        str(pictures[1]),
    ]
    result = printed_json(capsys, "gravity", *options)
    assert set(result["without_commands"]) == {"silent", "reflex"}
    supine = result["without_commands"]["silent"]["supine"]
    assert supine["paper_mm"] == 9.0
    assert supine["static_tip_mm"][0] > 1.0
    assert list(result["vowels"]) == ["i", "u", "a"]
    assert result["vowels"]["a"]["paper_GGp_change_percent"] == 8.0
    assert result["vowels"]["i"]["by_position"]["upright"]["peak_force_N"]["GGp"] > 3.0
    assert all(picture.stat().st_size > 10_000 for picture in pictures)


def test_transversalis(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["transversalis", "--plot", str(tmp_path / "t.png"), *QUICK]) == 0
    text = capsys.readouterr().out
    assert "paper: less width reflex than silent: here, too" in text
    result = printed_json(capsys, "transversalis")
    assert list(result["conditions"]) == ["reflex", "silent", "voluntary"]
    assert result["conditions"]["silent"]["forces_N"]["Trans"] == 0.0
    assert len(result["paper"]) == 3


def test_delay(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ["--delays", "5,17", "--until", "0.03"]
    assert main(["delay", "i", *options, "--plot", str(tmp_path / "d.png"), *QUICK]) == 0
    assert "17 ms" in capsys.readouterr().out
    result = printed_json(capsys, "delay", "i", *options)
    assert [run["delay_s"] for run in result["runs"]] == [0.005, 0.017]
    assert len(result["runs"][0]["displacement_mm"]["apical"]) == len(result["times_s"]) == 31


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sensitivity", "y"], "unknown vowel 'y'"),
        (["sensitivity", "--changes", "much"], "numbers with commas"),
        (["sensitivity", "--changes", "0"], "not 0"),
        (["sensitivity", "--workers", "0"], "--workers"),
        (["sensitivity", "--plot", "picture.txt"], "must end in"),
        (["transversalis", "u"], "activates Trans voluntarily"),
        (["transversalis", "--voluntary", "1.2"], "below 1"),
        (["delay", "--delays", "17"], "two or more"),
        (["delay", "--delays", "a,b"], "numbers with commas"),
        (["gravity", "--until", "-1"], "until"),
    ],
)
def test_wrong_input_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*arguments, *QUICK]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("command", ["sensitivity", "gravity", "transversalis", "delay"])
def test_every_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    text = capsys.readouterr().out
    assert "Example" in text
    assert "--json" in text


@pytest.mark.parametrize("command", ["gravity", "transversalis", "delay"])
def test_failed_runs_are_told_and_exit_with_1(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise SolveError("no solution today")

    monkeypatch.setattr(Scene, "simulate", fail)
    monkeypatch.setattr(Scene, "equilibrate", fail)
    assert main([command, *QUICK]) == 1
    printed = capsys.readouterr()
    assert "no solution today" in printed.err
    assert "no solution today" in printed.out
