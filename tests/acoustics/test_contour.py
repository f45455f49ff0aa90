from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from glossa.acoustics.contour import count_zeros

Complex = NDArray[np.complex128]
SQUARE = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])


def outline(steps: int) -> Complex:
    part = np.arange(steps) / steps
    return np.concatenate([a + (b - a) * part for a, b in zip(SQUARE, np.roll(SQUARE, -1), strict=True)])[None, :]


def polynomial(roots: list[complex]):  # type: ignore[no-untyped-def]
    return lambda points, rows: np.prod(points[..., None] - np.array(roots), axis=-1) * np.exp(0.3j * points)  # noqa: ARG005


@pytest.mark.parametrize("steps", [3, 40])
@pytest.mark.parametrize(
    "roots",
    [
        [],
        [0.2 + 0.1j],
        [0.5 + 0.0j, 0.5 + 0.0j],
        [0.3 + 0.999j, 0.3 - 0.4j, 1.001 + 0.2j],
        [0.9999 + 0.0j, 1.0001 + 0.0j, -0.5j],
    ],
)
def test_zeros_inside_are_counted(steps: int, roots: list[complex]) -> None:
    """Whatever the first steps are, also with zeros just inside and just outside the outline."""
    count = count_zeros(polynomial(roots), outline(steps))
    inside = [r for r in roots if abs(r.real) < 1 and abs(r.imag) < 1]
    assert count.zeros.tolist() == [len(inside)]


def test_power_sums_lead_to_the_zeros() -> None:
    roots = [0.4 + 0.3j, -0.2 + 0.1j, 0.6 - 0.5j]
    count = count_zeros(polynomial([*roots, 3.0 + 0.0j]), outline(60))
    all_three = count.guesses(0, np.zeros(0, dtype=np.complex128))
    assert sorted(all_three, key=np.real) == pytest.approx(sorted(roots, key=np.real), abs=5e-3)
    assert count.guesses(0, np.array(roots[:2])) == pytest.approx([roots[2]], abs=5e-3)
    assert count.guesses(0, np.array(roots)).size == 0


@pytest.mark.parametrize("root", [1.0 + 0.0j, 0.123456 - 1.0j])
def test_zero_on_the_outline_is_told(root: complex) -> None:
    assert count_zeros(polynomial([root, 0.0j]), outline(10)).zeros.tolist() == [-1]


def test_values_that_are_not_finite_are_told() -> None:
    def broken(points: Complex, rows: NDArray[np.intp]) -> Complex:
        return np.where((points.real > 0.5) & (rows[:, None] == 1), np.nan, points - 0.1)

    assert count_zeros(broken, np.repeat(outline(20), 3, axis=0)).zeros.tolist() == [1, -1, 1]
