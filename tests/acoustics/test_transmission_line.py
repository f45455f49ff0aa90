from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.acoustics.tracts import rough

from glossa import TUBE_CONSTANTS, AreaFunction, InputError, TubeConstants
from glossa.acoustics.transmission_line import flow_ratio, flow_ratio_gradient, flow_ratio_slope

NAMES = list(TUBE_CONSTANTS)
FREQUENCY = np.array([[90.0 + 20.0j, 500.0 + 0.0j, 1700.0 + 60.0j, 4300.0 - 30.0j]])
OMEGA = np.asarray(2.0 * np.pi * FREQUENCY, dtype=np.complex128)


def sets() -> list[TubeConstants]:
    lumped = [TUBE_CONSTANTS["badin"].with_(sections="lumped", name="lumped")]
    return [*TUBE_CONSTANTS.values(), *lumped, TUBE_CONSTANTS["badin"].lossless()]


def test_lossless_uniform_tube_is_a_cosine() -> None:
    constants = TUBE_CONSTANTS["badin"].lossless()
    tract = AreaFunction.uniform(0.175, 3e-4, 7)
    frequency = np.linspace(20.0, 7000.0, 200)
    expected = np.cos(2.0 * np.pi * frequency * 0.175 / 351.0)
    assert 1.0 / tract.transfer_function(frequency, constants=constants) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("cut", [0.5, 0.123])
def test_cutting_sections_changes_nothing(name: str, cut: float) -> None:
    """Exact sections: two of one area are one of their length together."""
    lengths, areas = rough(1, 3, 20)
    whole = flow_ratio(np.repeat(OMEGA, 3, axis=0), lengths, areas, TUBE_CONSTANTS[name])
    finer = np.stack([lengths * cut, lengths * (1.0 - cut)], axis=2).reshape(3, 40)
    parts = flow_ratio(np.repeat(OMEGA, 3, axis=0), finer, np.repeat(areas, 2, axis=1), TUBE_CONSTANTS[name])
    assert np.abs(parts / whole - 1.0).max() < 1e-12
    one, two = AreaFunction(lengths[0], areas[0]), AreaFunction(finer[0], np.repeat(areas[0], 2))
    a, b = (tract.formants(2, constants=name) for tract in (one, two))
    assert b.frequencies == pytest.approx(a.frequencies, rel=1e-9)
    assert b.bandwidths == pytest.approx(a.bandwidths, rel=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_long_sections_by_exponentials_equal_short_ones_by_series(name: str) -> None:
    """|q| above 4 takes another way of computing: one section of 30 cm against sixty of 0.5 cm."""
    one = flow_ratio(OMEGA, np.array([[0.3]]), np.array([[2e-4]]), TUBE_CONSTANTS[name])
    sixty = flow_ratio(OMEGA, np.full((1, 60), 0.005), np.full((1, 60), 2e-4), TUBE_CONSTANTS[name])
    assert np.abs(one / sixty - 1.0).max() < 1e-11


def test_sections_of_no_length_change_nothing() -> None:
    lengths, areas = rough(2, 1, 10)
    for constants in sets():
        plain = flow_ratio(OMEGA, lengths, areas, constants)
        longer = flow_ratio(OMEGA, np.c_[[[0.0, 0.0]], lengths], np.c_[[[1e-4, 5e-4]], areas], constants)
        assert longer == pytest.approx(plain, rel=1e-15)


def test_lumped_sections_converge_at_second_order() -> None:
    constants = TUBE_CONSTANTS["badin"]
    exact = AreaFunction.uniform(0.175, 1e-4).formants(3, constants=constants).frequencies
    errors = []
    for sections in (25, 50, 100):
        tract = AreaFunction.uniform(0.175, 1e-4, sections)
        errors.append(np.abs(tract.formants(3, constants=constants.with_(sections="lumped")).frequencies - exact))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx(np.full((2, 3), 2.0), abs=0.02)
    assert errors[0].min() > 0.01


@pytest.mark.parametrize("constants", sets(), ids=lambda c: f"{c.name}-{c.sections}-{c.radiation}")
@pytest.mark.parametrize("sections", [2, 12])
def test_derivatives(constants: TubeConstants, sections: int) -> None:
    """By frequency, area and length against central differences; two sections take the exponentials."""
    lengths, areas = rough(4, 1, sections)
    value, slope = flow_ratio_slope(OMEGA, lengths, areas, constants)
    assert value == pytest.approx(flow_ratio(OMEGA, lengths, areas, constants), rel=1e-14)
    by_omega, by_area, by_length = flow_ratio_gradient(OMEGA, lengths, areas, constants)
    assert by_omega == pytest.approx(slope, rel=1e-10)
    step = 0.01
    difference = flow_ratio(OMEGA + step, lengths, areas, constants) - flow_ratio(
        OMEGA - step, lengths, areas, constants
    )
    assert close(slope, difference / (2.0 * step))
    for gradient, values, which in ((by_area, areas, 1), (by_length, lengths, 0)):
        for k in range(sections):
            change = np.zeros_like(values)
            change[0, k] = h = 1e-5 * values[0, k]
            above, below = [lengths, areas], [lengths, areas]
            above[which], below[which] = values + change, values - change
            difference = flow_ratio(OMEGA, above[0], above[1], constants)
            difference = (difference - flow_ratio(OMEGA, below[0], below[1], constants)) / (2.0 * h)
            assert close(gradient[..., k], difference)
            assert np.abs(gradient[..., k]).max() > 0.0


def close(analytic: NDArray[np.complex128], difference: NDArray[np.complex128]) -> bool:
    return bool(np.abs(analytic - difference).max() < 1e-7 * np.abs(analytic).max())


def test_tract_gives_no_energy() -> None:
    """With losses every pole decays: D has no zero on or below the real axis, and |H| stays finite."""
    lengths, areas = rough(5, 20)
    frequency = np.broadcast_to(np.arange(5.0, 8000.0, 5.0), (20, 1599))
    for name in NAMES:
        for depth in (0.0, 20.0, 80.0):
            omega = 2.0 * np.pi * (np.maximum(frequency, 4.0 * depth) - 1j * depth)
            ratio = flow_ratio(omega, lengths, areas, TUBE_CONSTANTS[name])
            turns = np.diff(np.unwrap(np.angle(ratio), axis=1).T, axis=0)
            assert turns.min() > -0.5
            assert np.abs(ratio).min() > 1e-4


@pytest.mark.parametrize("shape", [(), (5,), (2, 3)])
def test_transfer_function_keeps_shapes(shape: tuple[int, ...]) -> None:
    tract = AreaFunction.uniform(0.17, 3e-4)
    response = tract.transfer_function(np.full(shape, 300.0))
    assert response.shape == shape
    assert response == pytest.approx(np.full(shape, complex(tract.transfer_function(300.0))))


@pytest.mark.parametrize("name", NAMES)
def test_all_flow_passes_at_zero_frequency(name: str) -> None:
    assert abs(AreaFunction.uniform(0.17, 3e-4).transfer_function(0.0, constants=name)) == pytest.approx(1.0, abs=1e-3)


def test_bad_frequencies_are_refused() -> None:
    tract = AreaFunction.uniform(0.17, 3e-4)
    with pytest.raises(InputError, match="finite and not negative"):
        tract.transfer_function([100.0, -1.0])
    with pytest.raises(InputError, match="finite and not negative"):
        tract.transfer_function(np.nan)
    with pytest.raises(InputError, match="real numbers in Hz"):
        tract.transfer_function("low")
