"""Grids and samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glossa import InputError
from glossa.studies import Design, grid, latin_hypercube, monte_carlo

RANGES: dict[str, Any] = {"a": (2.0, 4.0), "b": ("normal", 10.0, 0.5)}


def test_grids_combine_all_values_the_last_axis_fastest() -> None:
    design = grid({"a": [1.0, 2.0, 3.0], "gravity": ["upright", None]})
    assert design.axes == ("a", "gravity")
    assert design.shape == (3, 2)
    assert design.rows == tuple((a, g) for a in (1.0, 2.0, 3.0) for g in ("upright", None))
    assert len(design) == 6
    assert grid({"a": np.array([1.0, 2.0])}).rows == ((1.0,), (2.0,))


@given(n=st.integers(1, 60), seed=st.integers(0, 2**62))
def test_latin_hypercubes_have_one_point_in_every_part(n: int, seed: int) -> None:
    design = latin_hypercube({"a": (2.0, 4.0), "b": (-1.0, 0.0)}, n, seed)
    for column, low, width in zip(np.array(design.rows).T, (2.0, -1.0), (2.0, 1.0), strict=True):
        parts = np.floor((column - low) / width * n - 1e-9 * n).astype(int).clip(0, n - 1)
        assert len(set(parts.tolist())) >= n - 1  # one may round across a border
    assert design == latin_hypercube({"a": (2.0, 4.0), "b": (-1.0, 0.0)}, n, seed)


@pytest.mark.parametrize("sample", [latin_hypercube, monte_carlo])
def test_samples_follow_their_laws_and_seeds(sample: Callable[..., Design]) -> None:
    design = sample(RANGES, 4000, 7)
    a, b = np.array(design.rows).T
    assert a.min() >= 2.0
    assert a.max() <= 4.0
    assert a.mean() == pytest.approx(3.0, abs=4 * 2.0 / np.sqrt(12 * 4000))
    assert b.mean() == pytest.approx(10.0, abs=4 * 0.5 / np.sqrt(4000))
    assert b.std() == pytest.approx(0.5, rel=4 / np.sqrt(2 * 4000))
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(4000)
    assert sample(RANGES, 4000, 7).rows == design.rows
    assert sample(RANGES, 4000, 8).rows != design.rows
    assert design.as_dict() == {"method": sample.__name__, "axes": ("a", "b"), "ranges": RANGES, "seed": 7}


def test_larger_monte_carlo_samples_begin_with_the_smaller_ones() -> None:
    assert monte_carlo(RANGES, 20, 3).rows[:5] == monte_carlo(RANGES, 5, 3).rows


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: grid({}), "at least one axis"),
        (lambda: grid([1, 2]), "maps names of axes"),  # type: ignore[arg-type]
        (lambda: grid({"a": []}), "axis a has no values"),
        (lambda: grid({"a": "upright"}), "axis a: a grid needs a list"),
        (lambda: grid({"a": 3}), "axis a: a grid needs a list"),  # type: ignore[dict-item]
        (lambda: grid({"a": [1.0, 1.0]}), "same value twice"),
        (lambda: grid({name: list(range(1000)) for name in "abc"}), "1000 x 1000 x 1000 is too many"),
        (lambda: monte_carlo({"a": (1.0, 1.0)}, 5, 1), "range must rise"),
        (lambda: monte_carlo({"a": (2.0, 1.0)}, 5, 1), "range must rise"),
        (lambda: monte_carlo({"a": (1.0, float("inf"))}, 5, 1), "must be finite"),
        (lambda: monte_carlo({"a": ("normal", 1.0, 0.0)}, 5, 1), "standard deviation must be positive"),
        (lambda: monte_carlo({"a": ("cauchy", 1.0, 1.0)}, 5, 1), "a range is"),
        (lambda: latin_hypercube({"a": (1.0, 2.0)}, 0, 1), "number of points must be"),
        (lambda: latin_hypercube({"a": (1.0, 2.0)}, 5, -1), "seed must be"),
        (lambda: latin_hypercube({"a": (1.0, 2.0)}, 5, None), "seed must be"),  # type: ignore[arg-type]
        (lambda: latin_hypercube({}, 5, 1), "at least one axis"),
    ],
)
def test_bad_designs_are_refused(make: Callable[[], Design], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
