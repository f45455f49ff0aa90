"""F1 that is damped away must not lend its number to F2."""

from __future__ import annotations

import numpy as np
import pytest
from tests.acoustics.tracts import rough, vowels

from glossa import TUBE_CONSTANTS, AreaFunction, SolveError, TubeConstants
from glossa.acoustics import MeanLosses, YieldingWall, formants
from glossa.acoustics.numbering import first_is_missing, undamped
from glossa.acoustics.poles import Tracts

NARROW = [1e-4, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7, 1e-7]


def narrowed(area: float) -> AreaFunction:
    return AreaFunction([0.1, 0.02, 0.05], [3e-4, area, 3e-4])


@pytest.mark.parametrize("name", ["badin", "maeda", "story"])
def test_closing_tract_keeps_its_first_formant(name: str) -> None:
    """The wall's mass keeps F1 near 200 Hz however narrow the constriction."""
    found = formants([narrowed(area) for area in NARROW], 3, constants=name)
    assert set(found.reasons) == {""}
    assert (np.diff(found.frequencies[:, 0]) < 0.0).all()
    assert found.frequencies[-1, 0] > 150.0
    assert np.ptp(found.frequencies[2:, 1]) < 60.0


def test_lost_first_formant_is_nan() -> None:
    """VocalTractLab's wall resists so much that F1 disappears as the tract closes; F2 stays F2."""
    found = formants([narrowed(area) for area in NARROW], 3, constants="vocaltractlab")
    lost = np.isnan(found.frequencies[:, 0])
    assert lost.tolist() == [False] * 4 + [True] * 3
    assert [bool(reason) for reason in found.reasons] == lost.tolist()
    assert np.isfinite(found.frequencies[:, 1:]).all()
    assert np.ptp(found.frequencies[2:, 1]) < 60.0
    assert np.ptp(found.frequencies[2:, 2]) < 60.0
    with pytest.raises(SolveError, match="F1 is damped so much that it is no resonance"):
        narrowed(1e-6).formants(constants="vocaltractlab")


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
def test_open_tracts_are_left_alone(name: str) -> None:
    lengths, areas = rough(30, 60, 30, 0.5, least=1e-5)
    tracts = Tracts(lengths, areas, TUBE_CONSTANTS[name])
    found = formants(areas, 4, lengths=lengths, constants=name)
    assert not first_is_missing(tracts, list(found.poles)).any()
    assert not any("damped" in reason for reason in found.reasons)
    for tract in vowels().values():
        assert tract.formants(2, constants=name).reason == ""


def test_poles_without_the_first_are_noticed() -> None:
    """The first pole taken away by hand from tracts whose F1 is checked."""
    lengths, areas = rough(31, 40, 30, 0.3, least=3e-5)
    tracts = Tracts(lengths, areas, TUBE_CONSTANTS["badin"])
    cut = [one.poles[1:] for one in formants(areas, 4, lengths=lengths)]
    assert first_is_missing(tracts, cut).all()


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
def test_undamped_tract_has_narrow_poles(name: str) -> None:
    constants = undamped(TUBE_CONSTANTS[name])
    found = narrowed(1e-6).formants(2, constants=constants.with_(radiation="none"))
    assert np.abs(found.bandwidths).max() < 2.0
    assert constants.losses is None


def test_nothing_is_damped_without_losses() -> None:
    constants = TubeConstants(radiation="series")
    tracts = Tracts(np.array([[0.1, 0.07]]), np.array([[1e-4, 2e-4]]), constants)
    assert not first_is_missing(tracts, [np.array([1500.0 + 3.0j, 2500.0 + 5.0j])]).any()
    thick = constants.with_(losses=MeanLosses(drag=400.0, conduction=4.0), wall=YieldingWall(mass=20, resistance=1e4))
    assert undamped(thick).wall == YieldingWall(mass=20, resistance=10.0)
