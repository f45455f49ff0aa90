"""``glossa accuracy``: tables, JSON, Markdown, files, refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from glossa import SolveInterrupted
from glossa.cli import main
from glossa.cli.accuracy_output import accuracy_markdown
from glossa.studies.accuracy import AccuracySettings, committed_study, presets

README = Path(__file__).parents[2] / "README.md"


@pytest.fixture(scope="module")
def study() -> xr.Dataset:
    return committed_study()


def test_readme_shows_the_committed_study(study: xr.Dataset) -> None:
    """`glossa accuracy --show --markdown` renews it."""
    assert accuracy_markdown(study) in README.read_text(encoding="utf-8")


def test_shows_the_committed_study(capsys: pytest.CaptureFixture[str], tmp_path: Path, study: xr.Dataset) -> None:
    picture = tmp_path / "a.png"
    assert main(["accuracy", "--show", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    for words in (
        study.attrs["processor"],
        "Equilibria",
        "Movements",
        "SDIRK2: 5 ms",
        "* pays",
        "Presets",
        "no contact",
    ):
        assert words in text
    assert picture.stat().st_size > 10_000
    assert main(["accuracy", "--show", "--markdown"]) == 0
    printed = capsys.readouterr().out
    assert printed.rstrip("\n") == accuracy_markdown(study)
    assert '| movements, `"standard"` |' in printed


def test_json(capsys: pytest.CaptureFixture[str], study: xr.Dataset) -> None:
    assert main(["accuracy", "--show", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert len(result["choices"]) == study.sizes["choice"]
    assert result["facts"]["processor"] == study.attrs["processor"]
    draft = result["presets"]["movement, draft"]
    assert draft["nodes_mm"] == pytest.approx(presets(study)["nodes_mm"].to_dict()["movement", "draft"], abs=1e-9)
    first = result["choices"][0]["vowels"]["i"]
    assert len(first["nodes_mm"]) == 6
    assert len(first["formant_Hz"]) == 4
    assert len(first["force_N"]) == 11
    assert first["stated_mm"] is None
    assert any(choice["pays"]["nodes"] for choice in result["choices"])


def test_quick(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tiny = AccuracySettings(
        vowels=("ə",),
        moving=(),
        resolutions=(1,),
        residuals=(),
        gaps=(),
        threads=(),
        effects=("gravity",),
        repetitions=1,
    )
    monkeypatch.setattr("glossa.cli.accuracy_command.QUICK", tiny)
    table = tmp_path / "a.nc"
    assert main(["accuracy", "--quick", "--repetitions", "2", "--save", str(table)]) == 0
    printed = capsys.readouterr()
    assert "half: full" in printed.out
    assert "own settings, best of 2" in " ".join(printed.out.split())
    assert str(table) in printed.err
    with xr.open_dataset(table, engine="h5netcdf") as saved:
        assert saved.attrs["study"] == "accuracy"
        assert saved.attrs["repetitions"] == 2
        assert saved["vowel"].values.tolist() == ["ə"]


def test_failed_solves_are_told(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, study: xr.Dataset
) -> None:
    failed = study.copy(deep=True)
    failed["reason"] = failed["reason"].astype(object)
    failed["reason"][0, 0] = "no equilibrium today"
    monkeypatch.setattr("glossa.cli.accuracy_command.accuracy_study", lambda *_, **__: failed)
    assert main(["accuracy", "--quick"]) == 1
    assert "1 solves failed, the first: no equilibrium today" in capsys.readouterr().err


def test_interruption(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise SolveInterrupted("study interrupted: 3 of 9 solves are finished; .study holds their choices")

    monkeypatch.setattr("glossa.cli.accuracy_command.accuracy_study", stopped)
    assert main(["accuracy", "--quick"]) == 130
    assert capsys.readouterr().err == "glossa: study interrupted: 3 of 9 solves are finished\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--resolutions", "1,2.5"], "whole numbers"),
        (["--resolutions", "2,3"], "rise from 1"),
        (["--resolutions", "much"], "numbers with commas"),
        (["--repetitions", "0"], "repetitions"),
        (["--show", "--quick"], "computes nothing"),
        (["--show", "--json", "--markdown"], "choose one"),
        (["--plot", "picture.txt"], "must end in"),
        (["--save", "table.csv"], "must end in"),
        (["--speaker", "nobody"], "no such file"),
    ],
)
def test_wrong_input_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_explains_itself(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", "--help"]) == 0
    text = capsys.readouterr().out
    for words in ("Example", "--json", "--show", "--quick"):
        assert words in text
