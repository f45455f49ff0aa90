"""Estimated errors of postures as a table, and what the commands print of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.study_runs import small_scene

from glossa import Posture, Scene, SolveError, Speaker
from glossa.cli import main
from glossa.studies import formant_error, spatial_errors
from glossa.studies.vowels import vowels


@pytest.fixture(scope="module")
def postures() -> dict[str, Posture]:
    scene = small_scene()
    return {"rest": scene.equilibrate(), "bent": scene.equilibrate({"upper": 0.8})}


def test_table(postures: dict[str, Posture]) -> None:
    scene = small_scene()
    table = spatial_errors(scene, postures)
    for name, posture in postures.items():
        error = scene.spatial_error(posture)
        row = table.sel(posture=name)
        assert float(row["root_mean_square"]) == pytest.approx(error.root_mean_square)
        assert float(row["largest"]) == pytest.approx(error.largest)
        assert row["forces"].to_numpy() == pytest.approx(error.forces.to_numpy())
    assert table["cpu_seconds"].min() > 0.0
    assert np.isnan(table["formants"]).all()
    assert table["reason"].values.tolist() == ["", ""]
    assert table.attrs["study"] == "spatial_errors"


def test_what_has_not_converged_has_no_error(postures: dict[str, Posture], monkeypatch: pytest.MonkeyPatch) -> None:
    scene = small_scene()
    with pytest.raises(SolveError) as failed:
        scene.equilibrate({"upper": 0.8}, max_iterations=1)
    table = spatial_errors(scene, {"bent": failed.value.posture})
    assert table["reason"].values.tolist() == ["the posture has not converged"]
    assert np.isnan(table["root_mean_square"]).all()

    def failing(*_: Any, **__: Any) -> None:
        raise SolveError("no equilibrium today; .posture is the last good state")

    monkeypatch.setattr(Scene, "spatial_error", failing)
    assert spatial_errors(scene, postures)["reason"].values.tolist() == ["no equilibrium today"] * 2


def made_up(scene: Scene, names: list[str]) -> xr.Dataset:
    """A table of the tongue, without its solves."""
    muscles, walls = list(scene.speaker.muscles), list(scene.speaker.walls)
    n = len(names)
    forces = np.zeros((n, len(muscles)))
    forces[:, muscles.index("GGp")] = -1.17
    return xr.Dataset(
        {
            "root_mean_square": ("posture", np.full(n, 1.25e-3)),
            "largest": ("posture", np.full(n, 6.5e-3)),
            "forces": (("posture", "muscle"), forces),
            "formants": (("posture", "formant"), np.full((n, 4), -12.0)),
            "touched_areas": (("posture", "wall"), np.full((n, len(walls)), 3e-4)),
            "cpu_seconds": ("posture", np.full(n, 12.3)),
            "reason": ("posture", np.array(["told"] * n, dtype=object)),
        },
        coords={"posture": names, "muscle": muscles, "wall": walls, "formant": [1, 2, 3, 4]},
    )


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Speaker | None]:
    """Finer speakers that commands ask for, in place of the solves."""
    found: list[Speaker | None] = []

    def table(scene: Scene, postures: dict[str, Posture], *, finer: Speaker | None) -> xr.Dataset:
        found.append(finer)
        return made_up(scene, list(postures))

    monkeypatch.setattr("glossa.cli.commands.spatial_errors", table)
    return found


def test_printed(capsys: pytest.CaptureFixture[str], asked: list[Speaker | None]) -> None:
    assert main(["vowel", "@", "--spatial-error"]) == 0
    text = capsys.readouterr().out
    for words in ("Estimated error of the mesh", "1.25", "6.50", "GGp, N", "-1.17", "F4, Hz", "-12", "12.3", "told"):
        assert words in text
    assert "HG, N" not in text
    assert asked == [None]


def test_json(capsys: pytest.CaptureFixture[str], asked: list[Speaker | None]) -> None:
    assert main(["vowels", "--spatial-error", "--json"]) == 0
    for entry in json.loads(capsys.readouterr().out)["vowels"].values():
        error = entry["spatial_error"]
        assert error["root_mean_square_mm"] == 1.25
        assert error["forces_N"]["GGp"] == -1.17
        assert error["touched_areas_mm2"]["mandible"] == 300.0
    assert asked == [None]


@pytest.mark.slow
def test_own_landmarks_are_divided_as_they_are(
    capsys: pytest.CaptureFixture[str], asked: list[Speaker | None], tmp_path: Path
) -> None:
    own = tmp_path / "own.toml"
    own.write_text("[shape]\nvault_height = 1.0\n", encoding="utf-8")
    assert main(["vowel", "@", "--spatial-error", "--landmarks", str(own)]) == 0
    assert "Estimated" in capsys.readouterr().out
    assert asked[0] is not None
    assert asked[0].fingerprint == Speaker.reference(2, own).fingerprint


@pytest.mark.slow
def test_formants_of_a_vowel(reference: Speaker) -> None:
    """/u/ beside the limits of resolutions 1, 2 and 3: 40, 94, 1 and -5 Hz; 48, 66, 22 and 8 seen."""
    scene = Scene(reference, mirror=True)
    posture = vowels(scene, ["u"])["u"]
    error = scene.spatial_error(posture)
    lacking, reason = formant_error(error, "u")
    assert reason == ""
    assert 0.5 < lacking[0] / 40.0 < 2.0
    assert 0.5 < lacking[1] / 94.0 < 2.0
    assert np.abs(lacking[2:]).max() < 50.0
