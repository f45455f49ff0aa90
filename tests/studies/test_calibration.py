"""Calibration: what the built-in speaker reaches, and that the method finds its way back."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from glossa import paper
from glossa.errors import InputError
from glossa.studies.calibration import (
    VOWEL_NAMES,
    Outcome,
    calibrate,
    calibrated_parameters,
    effects,
    large_forces,
    outcome,
    summary,
)

BUILT_IN = {name: parameter.value for name, parameter in calibrated_parameters().items()}


@pytest.fixture(scope="module")
def built_in() -> Outcome:
    return outcome(BUILT_IN)


def test_large_forces_are_those_of_table_2() -> None:
    table = paper.forces()
    assert len(large_forces()) == 15
    assert all(
        float(table.to_numpy()[list(table.index).index(v)][list(table.columns).index(m)]) > 1.0
        for v, m in large_forces()
    )


def test_formants_of_table_4(built_in: Outcome) -> None:
    deviation = np.abs(built_in.formant_ratios - 1.0)
    assert deviation.shape == (4, 4)
    assert deviation.max() < 0.10, deviation
    assert deviation.mean() <= 0.05


def test_large_forces_of_table_2(built_in: Outcome) -> None:
    assert np.abs(built_in.force_ratios - 1.0).max() < 0.30, dict(
        zip(large_forces(), built_in.force_ratios, strict=True)
    )


def test_silent_muscles_stay_silent(built_in: Outcome) -> None:
    wanted = paper.forces().loc[list(VOWEL_NAMES)].to_numpy(dtype=float)
    assert built_in.forces[wanted == 0.0].max() < 0.3


def test_speaker_stays_sound(built_in: Outcome) -> None:
    assert built_in.jacobian > 0.3
    assert 90e-6 < built_in.volume < 105e-6
    assert built_in.overlap < 1e-3


def test_every_value_lies_within_its_limits() -> None:
    for parameter in calibrated_parameters().values():
        assert parameter.limits[0] <= parameter.value <= parameter.limits[1]
        assert parameter.meaning


@pytest.mark.slow
def test_finds_its_way_back() -> None:
    """Two parameters moved away: the cost falls at every step, and the others do not move."""
    moved = {"velum": 1.0, "root_back": -0.8}
    start = {name: value + moved.get(name, 0.0) for name, value in BUILT_IN.items()}
    start = {name: float(np.clip(v, *calibrated_parameters()[name].limits)) for name, v in start.items()}
    costs: list[float] = []
    with ThreadPoolExecutor(1) as executor:
        history = calibrate(start, 2, names=moved, executor=executor, progress=lambda _, cost, __: costs.append(cost))
    assert len(history) == len(costs) + 1 >= 2
    assert costs == sorted(costs, reverse=True)
    assert all(history[-1].values[name] == start[name] for name in start if name not in moved)
    assert summary(history[-1])[0] < summary(history[0])[0]


@pytest.mark.slow
def test_effects_tell_what_each_value_does() -> None:
    values = {"front_height": BUILT_IN["front_height"] or 0.5}
    with ThreadPoolExecutor(1) as executor:
        table = effects(values, executor=executor)
    assert list(table.parameter) == ["none", "front_height"]
    assert float(table.mean_deviation[0]) != float(table.mean_deviation[1])


@pytest.mark.parametrize(
    ("values", "message"),
    [({"nose": 1.0}, "no shape parameter 'nose'"), ({"velum": 99.0}, "velum must lie between")],
)
def test_refuses_values(values: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        outcome(values)


def test_refuses_parameters_that_are_not_calibrated() -> None:
    with pytest.raises(InputError, match="'pharynx_length' is not calibrated; those that are"):
        calibrate({"pharynx_length": 1.0}, 1)
    with pytest.raises(InputError, match="'nose' is not calibrated"):
        calibrate(None, 1, names=["nose"])
