"""Sweeps: what every axis changes, and what is refused."""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.study_runs import same, small_scene

from glossa import LIPS, VOWELS, InputError, MotorCommands, Reflex, Scene, Speaker, Stiffening, Yeoh
from glossa.studies import as_grid, grid, latin_hypercube, monte_carlo, open_study, sweep
from glossa.studies.axes import known_axes
from glossa.studies.sweep import sweep_points


@pytest.fixture(scope="module")
def scene() -> Scene:
    return small_scene()


@pytest.fixture(scope="module")
def tongue(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True, tissue=Yeoh(1000.0, 400.0))


def test_grids_run_and_fold_into_their_axes(scene: Scene, tmp_path: Path) -> None:
    design = grid({"command.upper": [0.9, 0.7, 0.8], "gravity": ["upright", "none"]})
    result = sweep(scene, design, {"lower": 0.9}, store=tmp_path / "s.study", positions=True)
    assert result["command.upper"].to_numpy().tolist() == [0.9, 0.9, 0.7, 0.7, 0.8, 0.8]
    assert result["gravity"].to_numpy().tolist() == ["upright", "none"] * 3
    folded = as_grid(result)
    assert dict(folded["forces"].sizes) == {"command.upper": 3, "gravity": 2, "muscle": 2}
    assert folded["command.upper"].to_numpy().tolist() == [0.9, 0.7, 0.8]
    bare = Scene(scene.speaker, fixed=["left"], gravity=None)
    posture = bare.equilibrate({"lower": 0.9, "upper": 0.7})
    found = folded.sel({"command.upper": 0.7, "gravity": "none"})
    assert found["forces"].to_numpy().tolist() == posture.forces.tolist()
    assert np.array_equal(found["positions"], posture.positions)
    folded.to_netcdf(tmp_path / "s.nc", engine="h5netcdf")
    xr.testing.assert_identical(as_grid(open_study(tmp_path / "s.study")), folded)


def test_samples_run_with_their_seed_written_down(scene: Scene) -> None:
    design = latin_hypercube({"command.upper": (0.7, 0.9), "tissue.c10": ("normal", 1000.0, 10.0)}, 4, 3)
    result = sweep(scene, design, None)
    written = json.loads(result.attrs["design"])
    assert written == {
        "method": "latin_hypercube",
        "axes": ["command.upper", "tissue.c10"],
        "ranges": {"command.upper": [0.7, 0.9], "tissue.c10": ["normal", 1000.0, 10.0]},
        "seed": 3,
        "base": None,
    }
    assert result["tissue.c10"].attrs["units"] == "Pa"
    assert set(result["status"].to_numpy()) == {"converged"}
    assert len(set(result["forces"].sel(muscle="upper").to_numpy().tolist())) == 4
    same(sweep(scene, design, None), result)
    with pytest.raises(InputError, match="only a grid has a dimension"):
        as_grid(result)


def test_each_axis_changes_what_it_says(tongue: Scene) -> None:
    values: dict[str, list[Any]] = {
        "command.GGp": [0.6],
        "change.Sty": [-5.0],
        "tissue.c10": [900.0],
        "tissue.c20": [300.0],
        "tissue.poissons_ratio": [0.49],
        "tissue.density": [1000.0],
        "firing_gradient": [50.0],
        "stiffening.peak_multiplier": [7.0],
        "friction": [0.3],
        "reflex.delay": [0.01],
        "reflex.velocity_gain": [0.02],
        "gravity": [(1.0, 0.0, -2.0)],
        "lips.length": [0.012],
        "lips.area": [2e-4],
        "shape.vault_height": [1.5],
        "shape.rear_wall": [-1.0],
    }
    points, units = sweep_points(tongue, grid(values), "i")
    assert len(points) == 1
    point = points[0]
    expected = VOWELS["i"].with_(GGp=0.6).scaled("Sty", 0.95)
    assert MotorCommands(point.commands) == expected
    assert point.scene == {
        "tissue": Yeoh(900.0, 300.0, poissons_ratio=0.49, density=1000.0),
        "firing_gradient": 50.0,
        "stiffening": Stiffening(peak_multiplier=7.0),
        "friction": 0.3,
        "reflex": Reflex(delay=0.01, velocity_gain=0.02),
        "gravity": (1.0, 0.0, -2.0),
    }
    assert point.lips == (0.012, 2e-4)
    assert point.shape == {"vault_height": 1.5, "rear_wall": -1.0}
    assert point.labels["gravity"] == "1.0,0.0,-2.0"
    assert point.labels["change.Sty"] == -5.0
    assert units["lips.area"] == "m2"
    assert units["change.Sty"] == "%"
    assert "gravity" not in units
    only_one, _ = sweep_points(tongue, grid({"tissue.c20": [300.0]}), "i")
    assert only_one[0].scene == {"tissue": Yeoh(1000.0, 300.0)}


def test_lips_are_those_of_the_base_unless_given(tongue: Scene) -> None:
    design = grid({"gravity": ["upright"]})
    assert sweep_points(tongue, design, "u")[0][0].lips == "u"
    assert sweep_points(tongue, design, "u", lips="i")[0][0].lips == "i"
    assert sweep_points(tongue, design, VOWELS["u"])[0][0].lips is None
    area, _ = sweep_points(tongue, grid({"lips.area": [1e-4]}), "u")
    assert area[0].lips == (LIPS["u"].length, 1e-4)
    named, _ = sweep_points(tongue, grid({"lips": ["i", (0.01, 2e-4)]}), "u")
    assert [point.lips for point in named] == ["i", (0.01, 2e-4)]
    assert named[1].labels["lips"] == "0.01,0.0002"


def test_known_axes_follow_scene_and_base(scene: Scene, tongue: Scene) -> None:
    assert {"command.upper", "command.lower"} <= set(known_axes(scene, {}))
    assert "friction" not in known_axes(scene, {})
    assert not any(name.startswith("change.") for name in known_axes(scene, {}))
    stiff = Scene(scene.speaker, fixed=["left"], stiffening=False, reflex=None)
    assert not any(name.startswith(("stiffening", "reflex")) for name in known_axes(stiff, {}))
    assert {"change.GGp", "friction", "shape.vault_height"} <= set(known_axes(tongue, VOWELS["i"]))


def test_axes_that_do_nothing_to_equilibria_are_told_of(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="glossa"):
        result = sweep(scene, grid({"reflex.delay": [0.005, 0.02]}), {"upper": 0.8})
    assert "reflex.delay acts on movements only" in caplog.text
    first, second = result["forces"].to_numpy().tolist()
    assert first == second


@pytest.mark.parametrize(
    ("values", "base", "message"),
    [
        ({"command.XY": [0.5]}, "i", r"unknown axis 'command.XY'; this scene has command.GGa, .*gravity"),
        ({"landmarks": [0.5]}, "i", "unknown axis 'landmarks'"),
        ({"shape.beard": [0.5]}, "i", "unknown axis 'shape.beard'"),
        ({"change.GGp": [5.0]}, None, "unknown axis 'change.GGp'"),
        ({"command.GGp": [0.6, -0.1]}, "i", r"axis command.GGp = -0.1 \(point 1\): .*must be positive"),
        ({"command.GGp": ["much"]}, "i", "must be a number"),
        ({"gravity": ["sideways"]}, "i", "gravity must be 'upright'"),
        ({"tissue.poissons_ratio": [0.5]}, "i", "Poisson's ratio"),
        ({"tissue.c10": ["stiff"]}, "i", "tissue.c10 must be a number"),
        ({"friction": [-1.0]}, "i", "must not be negative"),
        ({"lips": ["y"]}, "i", "no lips known for 'y'"),
        ({"lips.area": [1.0]}, "i", "lip area must be in m²"),
        ({"lips.area": [1e-4]}, None, "it has none; give lips"),
        ({"lips.area": [1e-4], "lips": ["i"]}, "i", "set the same lips"),
        ({"change.GGp": [1.0], "command.GGp": [0.5]}, "i", "set the same command"),
        ({"shape.vault_height": [99.0]}, "i", "must lie between"),
        ({"gravity": ["upright"]}, "y", "unknown base 'y'"),
    ],
)
def test_impossible_sweeps_are_refused(tongue: Scene, values: dict[str, list[Any]], base: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        sweep(tongue, grid(values), base)


def test_names_cannot_be_sampled(tongue: Scene) -> None:
    with pytest.raises(InputError, match="gravity has no numbers to sample"):
        sweep(tongue, monte_carlo({"gravity": (0.0, 1.0)}, 3, 1))
    with pytest.raises(InputError, match="design must be a Design"):
        sweep(tongue, {"gravity": ["upright"]})  # type: ignore[arg-type]
