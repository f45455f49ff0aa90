from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from glossa import TUBE_CONSTANTS, InputError, TubeConstants
from glossa.acoustics import BoundaryLayer, MeanLosses, ResonantWall, YieldingWall
from glossa.acoustics.constants import tube_constants

OMEGA = np.array([[2000.0 + 300.0j, 15000.0 + 900.0j, 700.0 + 0.0j]], dtype=np.complex128)


def test_names() -> None:
    assert set(TUBE_CONSTANTS) == {"badin", "praat", "maeda", "vocaltractlab", "story"}
    assert all(TUBE_CONSTANTS[name].name == name for name in TUBE_CONSTANTS)
    assert tube_constants("maeda") is TUBE_CONSTANTS["maeda"]
    own = TubeConstants(sound_speed=340.0)
    assert tube_constants(own) is own


def test_losses_per_length_are_those_of_the_formulas() -> None:
    """A = 2 cm² at 1 kHz by hand, in the cgs units of the sources."""
    omega, area = 2.0 * math.pi * 1000.0, 2.0
    rho, c, mu, eta, conduction, heat = 1.14e-3, 35100.0, 1.86e-4, 1.4, 5.5e-5, 0.24
    perimeter = 2.0 * math.sqrt(math.pi * area)
    resistance = perimeter / area**2 * math.sqrt(omega * rho * mu / 2.0)
    thermal = perimeter * (eta - 1.0) / (rho * c**2) * math.sqrt(omega * conduction / (2.0 * heat * rho))
    wall = perimeter / (1600.0 + 1j * omega * 1.4)
    series = resistance + 1j * omega * rho / area
    shunt = thermal + wall + 1j * omega * area / (rho * c**2)
    values, _ = TUBE_CONSTANTS["badin"].line(np.array([[omega + 0.0j]]))
    z1, z2, y1, y2 = (complex(np.broadcast_to(value, (1, 1))[0, 0]) for value in values)
    metre = area * 1e-4
    assert z1 / metre + z2 / metre**1.5 == pytest.approx(series * 1e7, rel=1e-9)  # g/(cm⁵ s) in kg/(m⁵ s)
    assert y1 * metre + y2 * metre**0.5 == pytest.approx(shunt * 1e-3, rel=1e-9)  # cm³ s/g in m³ s/kg


def test_radiation_by_hand() -> None:
    omega, area = np.array([[6000.0 + 0.0j]]), np.array([[3e-4]])
    mass = 1j * 6000.0 * 8.0 * 1.14 / (3.0 * math.pi * math.sqrt(math.pi * 3e-4))
    series, _, _ = TUBE_CONSTANTS["badin"].load(omega, area)
    assert series[0, 0] == pytest.approx(1.14 * 6000.0**2 / (2.0 * math.pi * 351.0) + mass)
    parallel, _, _ = TUBE_CONSTANTS["vocaltractlab"].load(omega, area)
    plate = 128.0 * 1.14 * 350.0 / (9.0 * math.pi**2 * 3e-4)
    assert 1.0 / parallel[0, 0] == pytest.approx(1.0 / plate + 1.0 / mass)
    assert TUBE_CONSTANTS["badin"].lossless().load(omega, area)[0][0, 0] == 0.0


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
def test_slopes_are_those_of_the_values(name: str) -> None:
    constants = TUBE_CONSTANTS[name].with_(
        wall=TUBE_CONSTANTS[name].wall or YieldingWall(mass=20, resistance=2e4, stiffness=5e5)
    )
    step = 1e-3
    _, slopes = constants.line(OMEGA)
    above, _ = constants.line(OMEGA + step)
    below, _ = constants.line(OMEGA - step)
    for slope, high, low in zip(slopes, above, below, strict=True):
        difference = (np.broadcast_to(high, OMEGA.shape) - np.broadcast_to(low, OMEGA.shape)) / (2.0 * step)
        assert np.broadcast_to(slope, OMEGA.shape) == pytest.approx(difference, rel=1e-6, abs=1e-18)
    area = np.array([[2e-4]])
    _, by_omega, by_area = constants.load(OMEGA, area)
    difference = (constants.load(OMEGA + step, area)[0] - constants.load(OMEGA - step, area)[0]) / (2.0 * step)
    assert by_omega == pytest.approx(difference, rel=1e-6)
    small = np.array([[1e-9]])
    difference = (constants.load(OMEGA, area + small)[0] - constants.load(OMEGA, area - small)[0]) / (2.0 * small)
    assert by_area == pytest.approx(difference, rel=1e-6)
    assert np.abs(by_area).min() > 0.0


def test_wall_below_its_resonance_is_left_out() -> None:
    assert TUBE_CONSTANTS["badin"].lowest_frequency == 1.0
    assert TUBE_CONSTANTS["maeda"].lowest_frequency == pytest.approx(71.2, abs=0.1)
    assert TUBE_CONSTANTS["story"].lowest_frequency == 15.0
    assert TUBE_CONSTANTS["praat"].lowest_frequency == 1.0


def test_changes() -> None:
    changed = TUBE_CONSTANTS["badin"].with_(wall=None, sections="lumped")
    assert changed.wall is None
    assert changed.sections == "lumped"
    assert changed.losses == TUBE_CONSTANTS["badin"].losses
    with pytest.raises(InputError, match="no attribute 'walls'; they have name, sound_speed"):
        TUBE_CONSTANTS["badin"].with_(walls=None)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sound_speed": 35100.0}, "sound_speed must be in m/s"),
        ({"density": 1.14e-3}, "density must be in kg/m³"),
        ({"density": np.nan}, "density .* finite"),
        ({"losses": 3.0}, "losses must be a BoundaryLayer"),
        ({"wall": "soft"}, "wall must be a YieldingWall"),
        ({"radiation": "horn"}, "radiation must be one of 'series', 'parallel', 'none'"),
        ({"sections": "T"}, "sections must be one of 'exact', 'lumped'"),
    ],
)
def test_bad_constants_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        TubeConstants(**changes)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (BoundaryLayer, {"viscosity": -1.0}, "viscosity"),
        (BoundaryLayer, {"heat_ratio": 0.9}, "heat_ratio must be at least 1"),
        (BoundaryLayer, {"reactance": 1}, "reactance must be True or False"),
        (MeanLosses, {"drag": -1.0, "conduction": 4.0}, "drag"),
        (YieldingWall, {"mass": 0.0, "resistance": 1.0}, "wall mass"),
        (YieldingWall, {"mass": 14.0, "resistance": 1.0, "stiffness": -1.0}, "wall stiffness"),
        (ResonantWall, {"tract_frequency": 200.0, "wall_frequency": -1.0, "drag": 1.0}, "wall_frequency"),
    ],
)
def test_bad_parts_are_refused(kind: Any, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        kind(**values)


@pytest.mark.parametrize("choice", ["Badin", "", 3, None])
def test_unknown_sets_are_refused(choice: Any) -> None:
    with pytest.raises(InputError, match="constants"):
        tube_constants(choice)
