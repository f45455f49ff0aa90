"""Own landmarks and quality on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from glossa import Speaker
from glossa.anatomy.shape import shape_parameters
from glossa.cli import main


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text("[shape]\nvault_height = 2\n", encoding="utf-8")
    return path


def test_speaker_with_landmarks(mine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = mine.parent / "copy.json"
    assert main(["speaker", "--landmarks", str(mine), "--json", "--save", str(copy)]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    made = Speaker.reference(1, mine)
    assert (result["speaker"], result["fingerprint"]) == ("mine, resolution 1", made.fingerprint)
    assert Speaker.load(copy).fingerprint == made.fingerprint
    quality = result["quality"]
    assert quality["scaled_jacobian"]["min"] == pytest.approx(made.quality().jacobian_min, abs=1e-6)
    assert quality["clearance_mm"]["hard_palate"] == pytest.approx(
        made.quality().clearance["hard_palate"] * 1e3, abs=1e-5
    )
    assert quality["notes"] == []
    assert main(["speaker", "--landmarks", str(mine), "-r", "2"]) == 0
    text = capsys.readouterr().out
    assert text == f"{(fine := Speaker.reference(2, mine)).summary()}\n{fine.quality().text()}\n"


def test_plot_is_named_after_the_command(
    mine: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(mine.parent)
    assert main(["speaker", "--landmarks", str(mine), "--plot"]) == 0
    assert (mine.parent / "speaker.png").stat().st_size > 20_000
    assert "wrote speaker.png" in capsys.readouterr().err


def test_other_commands_take_landmarks(mine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vowel", "@", "--landmarks", str(mine), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["speaker"] == "mine, resolution 1"
    assert main(["muscles", "--landmarks", str(mine), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["speaker"] == "mine, resolution 1"


def test_list_of_shape_parameters(mine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speaker", "--shape"]) == 0
    text = capsys.readouterr().out
    for name, parameter in shape_parameters().items():
        assert name in text
        assert parameter.meaning.split()[0] in text
    assert main(["speaker", "--shape", "--landmarks", str(mine), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    vault = shape_parameters()["vault_height"]
    assert result["landmarks"] == "mine"
    assert result["shape"]["vault_height"] == {
        "value": vault.value + 2.0,
        "limits": list(vault.limits),
        "unit": vault.unit,
        "meaning": vault.meaning,
    }


def test_what_falls_short_is_told(mine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine.write_text("[shape]\nrear_wall = -1.8\n", encoding="utf-8")
    assert main(["muscles", "--landmarks", str(mine), "--json"]) == 0
    printed = capsys.readouterr()
    json.loads(printed.out)
    assert printed.err.startswith("glossa: warning: mine, resolution 1: the tongue at rest overlaps wall pharynx by 1.")


@pytest.mark.parametrize(
    ("arguments", "text", "message"),
    [
        (["vowels"], "[shape]\nvault_height = 99\n", "mine.toml: [shape] vault_height must lie between"),
        (["speaker"], "[shape]\nnose = 1\n", "mine.toml: [shape] has no parameter 'nose'; known are"),
        (["speaker", "--shape"], "[shape", "mine.toml: Expected"),
        (["muscle", "GGp"], "[larynx_front]\nx = [125, 126.5, 136, 133.5, 121, 118, 117]\n", "the airway is closed"),
        (["speaker", "-s", "other.json"], "", "--landmarks changes the built-in speaker only"),
        (["speaker", "--shape", "-s", "other.json"], "", "--shape lists parameters of the built-in speaker"),
        (["speaker", "--plot", "x.doc"], "", "must end in"),
    ],
)
def test_faults_are_one_line_and_code_2(
    arguments: list[str], text: str, message: str, mine: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine.write_text(text, encoding="utf-8")
    assert main([*arguments, "--landmarks", str(mine)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert message in printed.err


def test_a_missing_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speaker", "--landmarks", str(tmp_path / "none.toml")]) == 2
    assert "cannot read the landmarks" in capsys.readouterr().err
