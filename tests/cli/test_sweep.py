"""glossa sweep."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from glossa.cli import app, main
from glossa.cli.running import pace
from glossa.studies import Progress, open_study, sweep

GRID = ("sweep", "--base", "@", "--axis", "change.MH=-1:1:2", "--axis", "gravity=upright,7/0/-7")


def test_json_files_and_the_second_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store, saved = tmp_path / "s.study", tmp_path / "s.nc"
    assert main([*GRID, "--store", str(store), "--save", str(saved), "--json", "--warm"]) == 0
    printed = capsys.readouterr()
    assert printed.err == f"glossa: wrote {saved}\n"
    result = json.loads(printed.out)
    assert result["design"] == {"method": "grid", "axes": ["change.MH", "gravity"], "seed": None}
    assert result["converged"] == 4
    assert [one["axes"] for one in result["points"]] == [
        {"change.MH": change, "gravity": gravity} for change in (-1.0, 1.0) for gravity in ("upright", "7.0,0.0,-7.0")
    ]
    first = result["points"][0]
    assert set(first) == {
        "axes", "status", "reason", "forces_N", "formants_Hz", "displacement_mm", "started_from", "iterations",
        "seconds",
    }  # fmt: skip
    assert first["started_from"] == "start"
    assert 300.0 < first["formants_Hz"][0] < 800.0
    assert first["forces_N"]["MH"] > result["points"][2]["forces_N"]["MH"]
    with xr.open_dataset(saved, engine="h5netcdf") as opened:
        assert opened.sizes["point"] == 4
    before = open_study(store)
    assert before.attrs["start"] == "posture"
    assert main([*GRID, "--store", str(store), "--warm"]) == 0
    assert "grid of 4 points, 4 converged" in capsys.readouterr().out
    xr.testing.assert_identical(open_study(store), before)
    assert main([*GRID, "--store", str(store)]) == 2
    assert "starts from another posture" in capsys.readouterr().err


def test_processes_samples_and_failed_points(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, Any] = {}

    def note(*arguments: Any, **options: Any) -> xr.Dataset:
        given.update(options)
        result = sweep(*arguments, **{**options, "executor": None})
        result["status"] = result["status"].copy(data=np.array(["converged", "stalled", "converged"], dtype=object))
        result["reason"] = result["reason"].copy(data=np.array(["", "no equilibrium: stalled", ""], dtype=object))
        return result

    monkeypatch.setattr("glossa.cli.study_commands.sweep", note)
    sample = ["sweep", "-b", "none", "-a", "tissue.c10=normal:1037:5", "-a", "gravity=upright"]
    assert main([*sample, "--random", "3", "--seed", "1"]) == 2
    assert "--axis gravity: a sample needs LOW:HIGH" in capsys.readouterr().err
    assert main([*sample[:5], "--random", "3", "--seed", "1", "--workers", "2", "--no-contact"]) == 1
    printed = capsys.readouterr()
    assert "1 of 3 points failed, the first: no equilibrium: stalled" in printed.err
    assert "tissue.c10" in printed.out
    assert given["executor"]._max_workers == 2
    assert given["store"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-a", "command.XX=0.5:0.6:2"], "unknown axis 'command.XX'; this scene has command.GGa"),
        (["-a", "gravity"], "--axis must be NAME=VALUES"),
        (["-a", "gravity=upright", "-a", "gravity=none"], "twice"),
        (["-a", "command.GGp=0.5:0.6"], "LOW:HIGH:COUNT"),
        (["-a", "command.GGp=0.5:0.6:1"], "COUNT at least 2"),
        (["-a", "command.GGp=a:b:3"], "'a' is no number"),
        (["-a", "command.GGp=0.5:0.6", "--latin", "3"], "need --seed"),
        (["-a", "command.GGp=0.5:0.6", "--latin", "3", "--random", "3", "--seed", "1"], "choose one of --latin"),
        (["-a", "command.GGp=0.5,0.6", "--seed", "1"], "--seed belongs to"),
        (["-a", "command.GGp=0.5,0.6", "--workers", "0"], "--workers must be a whole number"),
        (["-a", "command.GGp=0.5,0.6", "--base", "y"], "unknown vowel 'y'"),
        (["-a", "command.GGp=0.5,0.6", "--save", "x.csv"], "must end in .nc"),
        (["-a", "command.GGp=0.5,0.6", "--workers", "2", "--scheduler", "tcp://x:1"], "choose one of --workers"),
    ],
)
def test_wrong_input_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert printed.out == ""


def test_help_explains() -> None:
    result = CliRunner().invoke(app, ["sweep", "--help"])
    assert result.exit_code == 0
    assert all(option in result.output for option in ("--axis", "--latin", "--random", "--store", "--workers"))
    assert "Examples" in result.output


def test_pace_in_words() -> None:
    progress = Progress(done=30, total=330, failed=2, resumed=10, seconds=10.0)
    assert pace(progress) == "2/s, 0:02:30 left, 2 failed"
    assert pace(Progress(done=0, total=3, failed=0, resumed=0, seconds=0.0)) == "first points"
    assert pace(Progress(done=3, total=3, failed=0, resumed=3, seconds=0.0)) == ""
