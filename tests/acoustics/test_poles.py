"""The pole search against closed forms, against bisection, and where it must admit defeat."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from tests.acoustics.tracts import rough, vowels

from glossa import TUBE_CONSTANTS, AreaFunction, TubeConstants
from glossa.acoustics import YieldingWall, poles
from glossa.acoustics.bisection import poles_by_bisection
from glossa.acoustics.poles import Tracts, find_poles
from glossa.acoustics.region import Region

LOSSLESS = TUBE_CONSTANTS["badin"].lossless()
SETS = [
    *TUBE_CONSTANTS.values(),
    LOSSLESS.with_(name="lossless"),
    TUBE_CONSTANTS["badin"].with_(name="rigid lumped", wall=None, sections="lumped"),
    TUBE_CONSTANTS["badin"].with_(name="relaxed cheek", wall=YieldingWall(mass=21.0, resistance=8e3, stiffness=8.45e5)),
]
SHAPES = {
    "smooth": rough(1, 12, 45, 0.35),
    "rough": rough(2, 12, 45, 1.2, 1e-7, 1e-2),
    "nearly closed": rough(3, 12, 30, 1.2, 1e-9, 1e-3),
    "two tubes": rough(4, 12, 2, 1.5, 1e-6, 1e-2),
    "one tube": rough(5, 4, 1, 1.0),
}


def of(lengths: NDArray[np.float64], areas: NDArray[np.float64], constants: TubeConstants) -> Tracts:
    return Tracts(lengths, areas, constants)


def region(tracts: Tracts, top: NDArray[np.float64]) -> Region:
    return Region(top, 0.05 * tracts.spacing, tracts.constants.lowest_frequency)


@pytest.mark.parametrize("sections", [1, 3, 40])
def test_uniform_lossless_tube_has_odd_quarter_waves(sections: int) -> None:
    found = AreaFunction.uniform(0.175, 3e-4, sections).formants(6, constants=LOSSLESS)
    assert found.frequencies == pytest.approx((2.0 * np.arange(6) + 1.0) * 351.0 / (4.0 * 0.175), rel=1e-10)
    assert np.abs(found.bandwidths).max() < 1e-6


@pytest.mark.parametrize(("back", "front", "ratio"), [(0.09, 0.08, 7.0), (0.09, 0.06, 0.125), (0.05, 0.12, 30.0)])
def test_lossless_twin_tube_follows_its_closed_form(back: float, front: float, ratio: float) -> None:
    """tan(k l₁) tan(k l₂) = A₂/A₁, as in Fant (1960), with the poles of the tangents multiplied out."""

    def mismatch(frequency: float) -> float:
        k = 2.0 * np.pi * frequency / 351.0
        crossed = np.sin(k * back) * np.sin(k * front) - ratio * np.cos(k * back) * np.cos(k * front)
        return float(crossed)

    grid = np.arange(1.0, 9000.0, 2.0)
    signs = np.sign([mismatch(f) for f in grid])
    turns = np.flatnonzero(signs[1:] != signs[:-1])[:5]
    expected = [brentq(mismatch, grid[i], grid[i + 1], xtol=1e-10) for i in turns]
    tract = AreaFunction([back, front], [1e-4, ratio * 1e-4])
    assert tract.formants(5, constants=LOSSLESS).frequencies == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("constants", SETS, ids=lambda c: c.name)
def test_every_pole_is_found(shape: str, constants: TubeConstants) -> None:
    """Counted and located by bisection, which knows nothing of the search's first guesses."""
    tracts = of(*SHAPES[shape], constants)
    top = 4.7 * tracts.spacing
    search = find_poles(tracts, top)
    assert not any(search.failures)
    for row in range(0, len(top), 12):
        expected, failure = poles_by_bisection(tracts, region(tracts, top), row)
        assert not failure
        assert len(expected) >= 1
        assert search.poles[row] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("constants", SETS, ids=lambda c: c.name)
def test_poles_are_zeros_and_decay(constants: TubeConstants) -> None:
    tracts = of(*SHAPES["smooth"], constants)
    search = find_poles(tracts, 4.7 * tracts.spacing)
    for row, found in enumerate(search.poles):
        one = tracts.rows(np.array([row]))
        scale = np.abs(one.ratio(found[None, :] + 30.0)).min()
        assert np.abs(one.ratio(found[None, :])).max() < 1e-7 * scale
        assert (np.diff(found.real) > 0.0).all()
        assert found.imag.min() > (-1e-6 if constants.losses is None else 0.5)


@pytest.mark.parametrize("name", ["badin", "story"])
def test_first_guesses_do_not_matter(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Without the minima the poles come from power sums, without these from bisection: always the same poles."""
    tracts = of(*rough(6, 6), TUBE_CONSTANTS[name])
    top = 4.7 * tracts.spacing
    expected = find_poles(tracts, top)
    monkeypatch.setattr(poles, "_minima", lambda points, _: np.full((len(points), 0), np.nan + 0.0j))
    by_sums = find_poles(tracts, top)
    monkeypatch.setattr(poles, "_complete", lambda *_: None)
    by_bisection = find_poles(tracts, top)
    for search in (by_sums, by_bisection):
        assert not any(search.failures)
        for found, pole in zip(search.poles, expected.poles, strict=True):
            assert found == pytest.approx(pole, rel=1e-8)


def test_close_pair_is_told_apart() -> None:
    """Two cavities that hardly know of each other, one open: a narrow and a wide pole 7 Hz apart."""
    constants = TUBE_CONSTANTS["badin"].with_(wall=None)
    tract = AreaFunction([0.08, 0.02, 0.0265], [8e-4, 0.02e-4, 8e-4])
    tracts = of(tract.lengths[None, :], tract.areas[None, :], constants)
    top = np.array([4800.0])
    found = find_poles(tracts, top)
    expected, failure = poles_by_bisection(tracts, region(tracts, top), 0)
    assert not failure
    assert not found.failures[0]
    assert found.poles[0] == pytest.approx(expected, rel=1e-8)
    assert np.diff(found.poles[0].real).min() < 10.0


def test_pole_on_the_border_is_told() -> None:
    tract = AreaFunction.uniform(0.175, 3e-4)
    at = float(tract.formants(3, constants=LOSSLESS).frequencies[2])
    found = find_poles(of(tract.lengths[None, :], tract.areas[None, :], LOSSLESS), np.array([at]))
    assert "on the border" in found.failures[0]
    assert found.poles[0].size == 0


def test_bisection_says_when_it_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    tracts = of(*rough(6, 1), TUBE_CONSTANTS["badin"])
    top = 4.7 * tracts.spacing
    monkeypatch.setattr("glossa.acoustics.bisection.MOST_PIECES", 3)
    found, failure = poles_by_bisection(tracts, region(tracts, top), 0)
    assert "more than 3 pieces" in failure
    assert found.size == 0


def test_first_newton_step_has_the_slope() -> None:
    tracts = of(*rough(7, 3), TUBE_CONSTANTS["maeda"])
    at = np.array([[700.0 + 30.0j, 2100.0 - 10.0j]] * 3, dtype=np.complex128)
    difference = (tracts.ratio(at + 0.01) - tracts.ratio(at - 0.01)) / 0.02
    assert tracts.newton_step(at) == pytest.approx(tracts.ratio(at) / difference, rel=1e-6)


def test_lossless_frequencies_scale_with_length_only() -> None:
    for tract in vowels().values():
        plain = tract.formants(4, constants=LOSSLESS).frequencies
        shorter = AreaFunction(0.8 * tract.lengths, 1.7 * tract.areas).formants(4, constants=LOSSLESS).frequencies
        assert shorter == pytest.approx(plain / 0.8, rel=1e-9)
