"""The size study: factors are counted and grow as powers, vowels are solved, the committed study is shown."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from glossa import Scene, SolveError, Speaker
from glossa.cli import main
from glossa.cli.size_command import size_markdown
from glossa.errors import InputError
from glossa.figures import size
from glossa.studies import size_study
from glossa.studies.peak_memory import peak_memory
from glossa.studies.size import committed_size_study, growth

README = Path(__file__).parents[2] / "README.md"


@pytest.fixture(scope="module")
def committed() -> xr.Dataset:
    return committed_size_study()


@pytest.fixture
def at_home(monkeypatch: pytest.MonkeyPatch) -> None:
    """No processes: quicker, and what is replaced here counts."""
    monkeypatch.setattr("glossa.studies.size.worker_pool", ThreadPoolExecutor)


@pytest.mark.usefixtures("at_home")
def test_solved() -> None:
    study = size_study([1], names=["ə"], contact=False).isel(resolution=0)
    assert float(study["hexahedra"]) == 768.0
    free = Scene(Speaker.reference(), mirror=True, contact=False)._free
    assert float(study["unknowns"]) == free.sum()
    own = study.sel(vowel="ə")
    assert float(own["cpu_seconds"]) > 0.0
    assert 0.0 < float(own["factor_share"]) < 1.0
    assert float(own["factorisations"]) >= 2
    assert own["reason"].item() == ""
    assert study.attrs["study"] == "size"
    assert "contact" not in study.attrs["effects"]


def test_peak_memory() -> None:
    before = peak_memory()
    held = np.ones(int(before) // 8 + 2**21)  # more than all before, and 16 MB
    assert 5e7 < before < peak_memory()
    assert peak_memory() >= held.nbytes


@pytest.mark.slow
def test_processes_hold_less_where_the_mesh_is_coarse() -> None:
    memory = size_study([1, 2], names=["ə"], contact=False)["memory"]
    assert 5e7 < memory[0] < memory[1] < 2e9


@pytest.mark.usefixtures("at_home")
def test_counted_only() -> None:
    study = size_study([], counted=[2], names=["ə"], contact=False).isel(resolution=0)
    for key in ("entries", "flops"):
        assert study[f"factor_{key}"] < study[f"whole_{key}"]  # fibres couple all their nodes
    assert study["factor_entries"] > study["unknowns"]
    for name in ("cpu_seconds", "factorisations", "memory"):
        assert np.isnan(study[name]).all()


@pytest.mark.usefixtures("at_home")
def test_failures_have_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: Any, **__: Any) -> None:
        raise SolveError("no equilibrium today; .posture is the last good state")

    monkeypatch.setattr(Scene, "equilibrate", failing)
    failed = size_study([1], names=["i"], contact=False)
    assert failed["reason"].item() == "no equilibrium today"
    assert np.isnan(failed["cpu_seconds"]).all()


def test_growth_of_a_power(committed: xr.Dataset) -> None:
    made_up = committed.copy()
    made_up["factor_flops"] = 3.0 * committed["unknowns"] ** 2.25
    made_up["cpu_seconds"] = committed["cpu_seconds"] * math.nan
    found = growth(made_up, "factor_flops")
    assert math.isnan(float(found[0]))
    assert found[1:].to_numpy() == pytest.approx(2.25)
    assert np.isnan(growth(made_up, "cpu_seconds")).all()
    with pytest.raises(InputError, match="quantity must be"):
        growth(committed, "hexahedra")
    with pytest.raises(InputError, match="size_study"):
        growth(xr.Dataset(), "memory")


def test_nested_dissection_but_for_the_fibres(committed: xr.Dataset) -> None:
    """Theory 2 and 4/3; with fibres, as at the coarsest resolution, the powers grow with the size."""
    flops, entries = growth(committed, "factor_flops")[2:], growth(committed, "factor_entries")[2:]
    assert (np.abs(flops - 2.0) < 0.15).all()
    assert (np.abs(entries - 4.0 / 3.0) < 0.2).all()
    assert (growth(committed, "whole_flops")[1:] > 2.2).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"resolutions": [1, 1]}, "differ"),
        ({"resolutions": []}, "differ"),
        ({"resolutions": [0]}, "resolution"),
        ({"resolutions": [1], "counted": [1]}, "differ"),
        ({"resolutions": [1], "names": ["y"]}, "y"),
    ],
)
def test_refusals(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        size_study(**options)


def test_figure(committed: xr.Dataset) -> None:
    left, right = size(committed).axes
    assert left.get_xscale() == right.get_yscale() == "log"
    curve = next(line for line in left.lines if line.get_label() == "/i/")
    assert np.asarray(curve.get_ydata()) == pytest.approx(
        committed["cpu_seconds"].sel(vowel="i").to_numpy(), nan_ok=True
    )
    with pytest.raises(InputError, match="size_study"):
        size(xr.Dataset())


def test_readme_shows_the_committed_study(committed: xr.Dataset) -> None:
    """`glossa size --show` renews it."""
    assert "\n".join(size_markdown(committed)) in README.read_text(encoding="utf-8")


def test_command(capsys: pytest.CaptureFixture[str], tmp_path: Path, committed: xr.Dataset) -> None:
    picture = tmp_path / "a.png"
    assert main(["size", "--show", "--plot", str(picture)]) == 0
    assert capsys.readouterr().out.rstrip("\n") == "\n".join(size_markdown(committed))
    assert picture.stat().st_size > 10_000
    assert main(["size", "--show", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["unknowns"] == committed["unknowns"].values.tolist()
    assert result["facts"]["processor"] == committed.attrs["processor"]
    assert result["vowels"]["i"]["factorisations"][0] > 1
    assert result["powers"]["whole_flops"][0] is None
    assert main(["size", "-r", "1.5"]) == 2
    assert "whole numbers" in capsys.readouterr().err
