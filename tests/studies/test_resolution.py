"""The resolution study: shared nodes, observed orders, error bars."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from glossa import Speaker
from glossa.errors import InputError
from glossa.studies import error_bars, observed_order, resolution_study
from glossa.studies.resolution import shared_nodes


@pytest.mark.parametrize("levels", [(1, 2, 3), (1, 2, 4), (2, 3, 5)])
@pytest.mark.parametrize("order", [0.7, 1.0, 2.0, 3.3])
def test_order_of_a_power(levels: tuple[int, ...], order: float) -> None:
    a, b, c = (1.0 / r for r in levels)
    assert observed_order(levels, a**order - b**order, b**order - c**order) == pytest.approx(order, abs=1e-9)


@pytest.mark.parametrize(("first", "second"), [(1.0, 5.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1e-9)])
def test_no_order_of_what_falls_as_no_power(first: float, second: float) -> None:
    assert math.isnan(observed_order((1, 2, 3), first, second))


def synthetic(values: list[float]) -> xr.Dataset:
    forces = np.array(values)[:, None, None]
    return xr.Dataset(
        {"forces": (("resolution", "vowel", "muscle"), forces)},
        coords={"resolution": [1, 2, 3], "vowel": ["i"], "muscle": ["GGp"]},
    )


def test_error_bars_of_a_power() -> None:
    bars = error_bars(synthetic([7.0 + 2.0 / r**1.5 for r in (1, 2, 3)]), "forces")
    assert bars.limit.item() == pytest.approx(7.0)
    assert bars.order.item() == pytest.approx(1.5)
    assert bars.error.to_numpy().ravel() == pytest.approx([2.0 / r**1.5 for r in (1, 2, 3)])


def test_error_bars_without_an_order() -> None:
    bars = error_bars(synthetic([5.0, 6.0, 5.5]), "forces")
    assert math.isnan(bars.order.item())
    assert bars.limit.item() == 5.5
    assert bars.error.to_numpy().ravel().tolist() == [0.5, 0.5, 0.5]


def test_shared_nodes_stand_at_the_same_places() -> None:
    coarse, fine = Speaker.reference(), Speaker.reference(2)
    assert np.array_equal(fine.nodes[shared_nodes(2)], coarse.nodes[: len(shared_nodes(1))])


def test_two_resolutions_of_one_vowel() -> None:
    told: list[str] = []
    study = resolution_study([1, 2], ["ə"], progress=told.append, contact=False, hyoid="fixed")
    assert told == ["resolution 1", "resolution 2"]
    assert study.elements.to_numpy().tolist() == [768, 6144]
    assert np.isnan(study.change_rms.to_numpy()[0, 0])
    assert 0.0 < float(study.change_rms[1, 0]) < float(study.change_max[1, 0]) < 2.0
    assert study.forces.shape == (2, 1, 11)
    assert np.isfinite(study.formants.to_numpy()).all()


@pytest.mark.parametrize("levels", [[1], [2, 1], [1, 1], [0, 1], [1.5, 2]])
def test_refuses_resolutions(levels: list[float]) -> None:
    with pytest.raises(InputError):
        resolution_study(levels, ["ə"])  # type: ignore[arg-type]


def test_refuses_error_bars() -> None:
    with pytest.raises(InputError, match="three resolutions"):
        error_bars(synthetic([1.0, 2.0, 3.0]).isel(resolution=[0, 1]), "forces")
    with pytest.raises(InputError, match="quantity must be"):
        error_bars(synthetic([1.0, 2.0, 3.0]), "seconds")
