"""The command line: output, files, exit codes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.io import wavfile
from typer.testing import CliRunner

import glossa
from glossa import MUSCLES, Movement, Posture, Scene, SolveError, SolveInterrupted, Speaker
from glossa.cli import app, main
from glossa.cli.options import with_picture_names
from glossa.studies import effect_costs

COMMANDS = ("vowels", "vowel", "movement", "muscle", "muscles", "speaker", "size", "costs", "view")
ENTRY = {
    "converged",
    "forces_N",
    "formants_Hz",
    "tip_displacement_mm",
    "dorsum_displacement_mm",
    "contact",
    "hyoid_displacement_mm",
    "iterations",
    "seconds",
}


def check_entry(entry: dict[str, Any], *, sounds: bool = True) -> None:
    assert entry["converged"] is True
    assert tuple(entry["forces_N"]) == MUSCLES
    assert all(isinstance(force, float) and force >= 0.0 for force in entry["forces_N"].values())
    if sounds:
        assert len(entry["formants_Hz"]) == 4
        assert 200.0 < entry["formants_Hz"][0] < 900.0
        assert sorted(entry["formants_Hz"]) == entry["formants_Hz"]
    else:
        assert entry["formants_Hz"] is None
    for point in ("tip", "dorsum"):
        assert [type(x) for x in entry[f"{point}_displacement_mm"]] == [float, float]
    assert list(entry["contact"]) == list(Speaker.reference().walls)
    for wall in entry["contact"].values():
        assert wall["area_mm2"] >= 0.0
        assert [type(x) for x in wall["force_N"]] == [float] * 3
        assert (wall["area_mm2"] > 0.0) == any(wall["force_N"])
    assert [type(x) for x in entry["hyoid_displacement_mm"]] == [float, float]
    assert isinstance(entry["iterations"], int)
    assert entry["seconds"] > 0.0


def test_json_of_vowels_is_all_of_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vowels", "--json"]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert printed.err == ""
    assert set(result) == {"speaker", "vowels"}
    assert result["speaker"] == Speaker.reference().name
    assert list(result["vowels"]) == ["i", "ə", "u", "a"]
    for entry in result["vowels"].values():
        assert set(entry) == ENTRY
        check_entry(entry)
    assert max(result["vowels"]["i"]["forces_N"], key=result["vowels"]["i"]["forces_N"].__getitem__) == "GGp"


def test_tables_of_vowels(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vowels", "--gravity", "none", "--epg"]) == 0
    text = capsys.readouterr().out
    assert "25.82" in text  # Table II, /i/, GGp
    assert "gravity" not in text
    assert "note:" not in text
    contact = ("hard_palate", "mandible", "hyoid", "Palatogram", "# # . . . . # #")
    for word in (*MUSCLES, "/ə/", "dorsum z", *contact, "2095", "length"):
        assert word in text


def test_without_contact_and_hyoid_nothing_of_them_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vowel", "@", "--no-contact", "--hyoid", "fixed", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["contact"], result["hyoid_displacement_mm"]) == (None, None)
    assert main(["muscle", "MH", "--no-contact", "--hyoid", "fixed"]) == 0
    text = capsys.readouterr().out
    assert "hard_palate" not in text
    assert "hyoid" not in text.lower()


def test_friction_and_palatogram(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "contact.png"
    results = []
    for option in (["--friction", "0"], ["--epg", "--plot-contact", str(picture)]):
        assert main(["vowel", "i", "--json", *option]) == 0
        results.append(json.loads(capsys.readouterr().out))
    smooth, rough = (result["contact"]["hard_palate"]["force_N"] for result in results)
    assert smooth != pytest.approx(rough, rel=1e-2)
    assert "palatogram" not in results[0]
    rows = results[1]["palatogram"]["rows"]
    assert [len(row) for row in rows] == [8] * 8
    assert (rows[0][0], rows[0][-1], set("".join(rows))) == (" ", " ", {" ", "0", "1"})
    share = "".join(rows).count("1") / 62
    assert results[1]["palatogram"]["percent"] == pytest.approx(100 * share, abs=1e-3)
    assert picture.stat().st_size > 10_000


def test_costs(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    computed = effect_costs(Speaker.reference(), "i", 0.004, repetitions=1)
    asked: list[tuple[object, ...]] = []

    def costs(*arguments: object, **options: object) -> xr.Dataset:
        asked.append((*arguments[1:], options))
        return computed

    monkeypatch.setattr("glossa.cli.commands.effect_costs", costs)
    assert main(["costs", "@", "--until", "0.004", "--repetitions", "7", "--json"]) == 0
    assert asked == [("ə", 0.004, {"dt": 0.002, "mirror": True, "repetitions": 7})]
    result = json.loads(capsys.readouterr().out)
    names = ["tissue and muscles", "contact, walls out of reach", "+ contact", "+ friction", "+ hyoid", "+ gravity"]
    assert list(result["scenes"]) == names
    assert all(scene["seconds"] > 0.0 for scene in result["scenes"].values())
    assert list(result["left_out_mm"]) == ["contact", "friction", "hyoid", "gravity"]
    assert result["left_out_mm"]["gravity"]["tip_change_end"] > 0.0
    assert main(["costs"]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in (*names, "factorisations", "at the end"))


def test_vowel_accepts_at_sign_and_writes_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plot, mesh = tmp_path / "schwa.svg", tmp_path / "schwa.vtu"
    assert main(["vowel", "@", "--json", "--plot", str(plot), "--vtk", str(mesh)]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert (result.pop("vowel"), result.pop("speaker")) == ("ə", Speaker.reference().name)
    check_entry(result)
    assert plot.stat().st_size > 1000
    import meshio

    assert meshio.read(mesh).cells_dict["hexahedron"].shape == Speaker.reference().hexahedra.shape
    assert printed.err.count("wrote") == 2


def test_vowel_sounds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound, tract, formants = tmp_path / "a.wav", tmp_path / "tract.png", tmp_path / "formants.png"
    options = ["--wav", str(sound), "--plot-tract", str(tract), "--plot-formants", str(formants)]
    assert main(["vowel", "a", *options]) == 0
    rate, samples = wavfile.read(sound)
    assert rate == 44100
    assert len(samples) == pytest.approx(0.5 * rate, abs=1)
    assert np.abs(samples).max() > 0.5 * np.iinfo(samples.dtype).max
    assert tract.stat().st_size > 1000
    assert formants.stat().st_size > 1000
    assert "1296" in capsys.readouterr().out  # Table IV, /a/, F2


def test_movement_sounds(tmp_path: Path) -> None:
    sound = tmp_path / "a.wav"
    assert main(["movement", "a", "--until", "0.02", "--accuracy", "draft", "--wav", str(sound)]) == 0
    rate, samples = wavfile.read(sound)
    assert len(samples) == pytest.approx(0.22 * rate, abs=1)


def test_a_muscle_alone_has_no_formants(capsys: pytest.CaptureFixture[str]) -> None:
    """Table IV gives lips to vowels only."""
    assert main(["muscle", "GGp", "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)
    check_entry(entry, sounds=False)


def test_half_and_whole_model_agree(capsys: pytest.CaptureFixture[str]) -> None:
    results = []
    for option in ("--mirror", "--no-mirror"):
        assert main(["vowel", "ə", option, "--json"]) == 0
        results.append(json.loads(capsys.readouterr().out))
    # Both solved to a residual of 1e-8 of the force scale; numbers are printed to 1e-9.
    assert results[0]["forces_N"] == pytest.approx(results[1]["forces_N"], abs=1e-5)


def test_muscle_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["muscle", "GGp", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["muscle"], result["command"]) == ("GGp", 0.75)
    assert [name for name, force in result["forces_N"].items() if force > 0.0] == ["GGp"]


def test_movement_prints_saves_and_plots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    saved, plot = tmp_path / "u.nc", tmp_path / "u.png"
    options = ["--until", "0.01", "--accuracy", "draft", "--save", str(saved), "--plot", str(plot), "--json"]
    assert main(["movement", "u", *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["vowel"], result["converged"]) == ("u", True)
    times = result["times_s"]
    assert (times[0], times[-1]) == (0.0, pytest.approx(0.01))
    assert len(result["tip_displacement_mm"]) == len(result["forces_N"]["Sty"]) == len(times)
    assert len(result["contact"]["mandible"]["area_mm2"]) == len(result["hyoid_displacement_mm"]) == len(times)
    assert [len(force) for force in result["contact"]["mandible"]["force_N"]] == [3] * len(times)
    assert Movement.load(saved, Speaker.reference()).times.tolist() == times
    assert plot.stat().st_size > 5000


def test_muscles_and_speaker(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["muscles", "--json"]) == 0
    assert tuple(json.loads(capsys.readouterr().out)["muscles"]) == MUSCLES
    copy = tmp_path / "copy.json"
    assert main(["speaker", "--save", str(copy)]) == 0
    assert capsys.readouterr().out == ""
    assert main(["speaker", "--speaker", str(copy), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["fingerprint"] == Speaker.reference().fingerprint
    assert "hard_palate" in summary["walls"]
    assert summary["contact_faces"]["hard_palate"] == len(Speaker.reference().contact_faces["hard_palate"])
    assert main(["speaker", "--speaker", str(copy), "--summary"]) == 0
    assert Speaker.reference().summary() in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["vowel", "q"], "unknown vowel 'q'"),
        (["vowel"], "Missing argument"),
        (["nosuch"], "No such command"),
        (["vowels", "--frobnicate"], "No such option"),
        (["vowels", "--resolution", "many"], "Invalid value"),
        (["vowels", "--resolution", "0"], "resolution must be at least 1"),
        (["vowels", "--speaker", "nosuch"], "no such file or folder"),
        (["vowels", "--speaker", "x", "--resolution", "2"], "built-in speaker only"),
        (["vowels", "--gravity", "sideways"], "upright, supine or none"),
        (["vowel", "i", "--friction", "-1"], "friction must lie between"),
        (["vowel", "i", "--hyoid", "loose"], "--hyoid must be mobile or fixed"),
        (["vowel", "i", "--no-contact", "--epg"], "this scene has none"),
        (["vowel", "i", "--no-contact", "--plot-contact", "i.png"], "this scene has none"),
        (["vowel", "i", "--plot-contact", "i.doc"], "must end in"),
        (["costs", "--repetitions", "0"], "repetitions must be a whole number"),
        (["vowel", "i", "--plot", "nosuch/i.png"], "no folder nosuch"),
        (["vowel", "i", "--plot", "i.doc"], "must end in"),
        (["vowel", "i", "--vtk", "i.stl"], "must end in"),
        (["muscle", "XYZ"], "unknown muscle 'XYZ'"),
        (["muscle", "GGp", "--command", "-1"], "must be positive"),
        (["movement", "i", "--until", "nan"], "until must be finite"),
        (["movement", "i", "--accuracy", "perfect"], "accuracy must be"),
        (["view", "i", "--screenshot", "i.gif"], "must end in"),
    ],
)
def test_input_faults_are_one_line_and_code_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("glossa: ")
    assert printed.err.count("\n") == 1
    assert message in printed.err


def test_a_broken_speaker_file_is_an_input_fault(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.json"
    broken.write_text('{"format": "glossa-speaker", "nodes": [[0, 0')
    assert main(["vowels", "--speaker", str(broken)]) == 2
    assert "broken.json" in capsys.readouterr().err


def test_a_missing_extra_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert main(["view"]) == 2
    assert "pip install 'glossa[view]'" in capsys.readouterr().err


def test_a_failed_solve_is_code_1(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def fail(*_: object, **__: object) -> Posture:
        raise SolveError("no equilibrium: stalled; .posture is the last good state", status="stalled")

    monkeypatch.setattr(Scene, "equilibrate", fail)
    assert main(["muscle", "GGp"]) == 1
    assert capsys.readouterr().err == "glossa: no equilibrium: stalled\n"


def test_ctrl_c_is_code_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def stop(*_: object, **__: object) -> Posture:
        raise SolveInterrupted("equilibrium interrupted; .posture is the last good state")

    monkeypatch.setattr(Scene, "equilibrate", stop)
    assert main(["vowels"]) == 130
    assert capsys.readouterr().err == "glossa: equilibrium interrupted\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_has_examples(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200"})
    assert result.exit_code == 0
    assert f"glossa {command}" in result.output
    assert "Example" in result.output


def test_help_and_version() -> None:
    result = CliRunner().invoke(app, [])
    assert result.exit_code == 0
    assert all(command in result.output for command in COMMANDS)
    assert CliRunner().invoke(app, ["--version"]).output.strip() == glossa.__version__


def test_plot_without_a_name_is_named_after_the_command() -> None:
    assert with_picture_names(["vowel", "@", "--plot", "--json"]) == ["vowel", "@", "--plot=vowel-schwa.png", "--json"]
    assert with_picture_names(["vowels", "--plot-3d"]) == ["vowels", "--plot-3d=vowels-3d.png"]
    assert with_picture_names(["vowel", "i", "--plot-contact"]) == ["vowel", "i", "--plot-contact=vowel-i-contact.png"]
    assert with_picture_names(["muscles", "--plot", "a.pdf"]) == ["muscles", "--plot", "a.pdf"]


def test_as_a_process_in_a_plain_terminal(tmp_path: Path) -> None:
    """Without UTF-8 the output stays readable JSON, and pictures appear where the process runs."""
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    path = os.pathsep.join([str(Path(glossa.__file__).parents[1]), environment.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "glossa.cli", "vowel", "@", "--json", "--plot"],
        cwd=tmp_path,
        env={**environment, "PYTHONPATH": path},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.decode("ascii"))["vowel"] == "ə"
    assert (tmp_path / "vowel-schwa.png").is_file()
