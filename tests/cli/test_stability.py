"""``glossa stability``: table, JSON, files, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray as xr

from glossa.cli import main
from glossa.studies.stability import committed_stability


@pytest.fixture(scope="module")
def study() -> xr.Dataset:
    return committed_stability()


def test_shows_the_committed_study(capsys: pytest.CaptureFixture[str], tmp_path: Path, study: xr.Dataset) -> None:
    picture = tmp_path / "s.png"
    assert main(["stability", "--show", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    for words in (study.attrs["speaker"], "/i/, c = 40 per m", "/a/, c = 112 per m", "nothing grows"):
        assert words in text
    first = study.sel(posture="u", firing_gradient=40.0, velocity_gain=0.01, delay=0.017).isel(root=0)
    found = f"{float(first['growth']):+.1f}"
    assert f"{found} per s at {float(first['frequency']):.1f} Hz, with 17 ms and 10 ms, is driven by IL" in text
    assert picture.stat().st_size > 10_000


def test_json(capsys: pytest.CaptureFixture[str], study: xr.Dataset) -> None:
    assert main(["stability", "--show", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert len(result["charts"]) == study.sizes["posture"] * study.sizes["firing_gradient"]
    chart = result["charts"][0]
    own = study.sel(posture=chart["posture"], firing_gradient=chart["firing_gradient_per_m"])
    assert len(chart["points"]) == study.sizes["delay"] * study.sizes["velocity_gain"]
    for point in chart["points"]:
        there = own.sel(velocity_gain=point["velocity_gain_s"], delay=point["delay_s"])
        assert point["roots"][0]["growth_per_s"] == pytest.approx(float(there["growth"][0]), abs=1e-8)
    assert len(chart["border"]) == study.sizes["border_gain"]


@pytest.mark.slow
def test_computes_a_small_chart(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    stored = tmp_path / "s.nc"
    few = ["--delays", "5,17", "--gains", "0,10", "--gradients", "40"]
    assert main(["stability", "i", *few, "--save", str(stored), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    with xr.open_dataset(stored, engine="h5netcdf") as opened:
        saved = opened.load()
    committed = committed_stability().sel(
        posture=["i"], firing_gradient=[40.0], velocity_gain=[0.0, 0.01], delay=[0.005, 0.017]
    )
    assert saved["growth"].values[..., 0] == pytest.approx(committed["growth"].values[..., 0], rel=0.02, abs=0.02)
    assert result["charts"][0]["points"][0]["unstable_roots"] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["y"], "unknown vowel 'y'"),
        (["--delays", "17,5"], "delays must be one or more numbers that rise"),
        (["--gains", "ten"], "--gains must be numbers"),
        (["--show", "--gradients", "40"], "--show computes nothing"),
        (["--plot", "s.txt"], "s.txt"),
    ],
)
def test_refusals(capsys: pytest.CaptureFixture[str], arguments: list[str], message: str) -> None:
    assert main(["stability", *arguments]) == 2
    assert message in capsys.readouterr().err
