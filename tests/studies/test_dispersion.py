"""Dispersion ellipses against normal laws whose answer is known, and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glossa import InputError
from glossa.studies.dispersion import angle_between, coverage, dispersion_ellipse


def cross(major: float, minor: float, degrees: float) -> np.ndarray:
    """Five points with standard deviations ``major`` and ``minor`` (divisor n - 1) in directions that are known."""
    turn = math.radians(degrees)
    axes = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    ends = math.sqrt(2.0) * np.array([[major, 0.0], [-major, 0.0], [0.0, minor], [0.0, -minor], [0.0, 0.0]])
    return np.asarray(ends @ axes)


@given(
    st.floats(0.5, 20.0),
    st.floats(0.01, 0.9),
    st.floats(0.0, 179.9),
    st.floats(0.5, 5.0),
    st.tuples(st.floats(-50, 50), st.floats(-50, 50)),
)
def test_axes_and_angle_are_those_of_the_cloud(
    major: float, ratio: float, degrees: float, sigmas: float, centre: tuple[float, float]
) -> None:
    ellipse = dispersion_ellipse(cross(major, ratio * major, degrees) + centre, sigmas)
    assert ellipse.semi_major == pytest.approx(sigmas * major, rel=1e-9)
    assert ellipse.semi_minor == pytest.approx(sigmas * ratio * major, rel=1e-6)
    assert ellipse.major == 2.0 * ellipse.semi_major
    assert ellipse.minor == 2.0 * ellipse.semi_minor
    assert angle_between(ellipse.angle, degrees) < 1e-4
    assert 0.0 <= ellipse.angle < 180.0
    assert ellipse.centre == pytest.approx(centre, abs=1e-9)


def test_covariance_is_the_unbiased_one() -> None:
    points = np.random.default_rng(3).normal(size=(7, 2)) * [3.0, 1.0]
    ellipse = dispersion_ellipse(points, 1.0)
    variances = np.linalg.eigvalsh(np.cov(points.T))
    assert [ellipse.semi_minor**2, ellipse.semi_major**2] == pytest.approx(variances)


def test_coverage_is_that_of_two_dimensions() -> None:
    assert coverage(3.0) == pytest.approx(0.98889, abs=1e-5)
    assert coverage(1.0) == pytest.approx(0.39347, abs=1e-5)
    points = np.random.default_rng(1).multivariate_normal([1.0, 2.0], [[4.0, 1.5], [1.5, 1.0]], 100_000)
    for sigmas in (1.0, 2.0, 3.0):
        ellipse = dispersion_ellipse(points, sigmas)
        assert ellipse.inside == pytest.approx(ellipse.coverage, abs=0.006)


def test_forward_with_upward_is_more_than_90_degrees() -> None:
    # x backward, z upward: forward and up is (-1, 1), as the apex in fig. 11
    points = np.array([[-2.0, 2.0], [2.0, -2.0], [0.3, 0.3], [-0.3, -0.3]])
    assert dispersion_ellipse(points).angle == pytest.approx(135.0)


def test_outline_and_axis_lie_on_the_ellipse() -> None:
    ellipse = dispersion_ellipse(cross(2.0, 1.0, 30.0) + np.array([5.0, -3.0]), 2.0)
    turn = math.radians(30.0)
    along, across = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    away = ellipse.outline() - [5.0, -3.0]
    assert ((away @ along / 4.0) ** 2 + (away @ across / 2.0) ** 2) == pytest.approx(1.0)
    assert ellipse.outline()[0] == pytest.approx(ellipse.outline()[-1])
    assert np.ptp(ellipse.major_axis() @ along) == pytest.approx(8.0)
    assert np.ptp(ellipse.major_axis() @ across) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        ([[0.0, 0.0], [1.0, 1.0]], "at least 3 samples, got 2"),
        (np.zeros((0, 2)), "at least 3"),
        ([[1.0, 2.0]] * 5, "one point"),
        ([[0.0, 0.0], [1.0, 2.0], [2.0, 4.0], [-1.0, -2.0]], "one line"),
        ([[0.1, 0.3], [0.2, 0.6], [0.7, 2.1]], "one line"),
        ([[0.0, 0.0], [1.0, math.nan], [2.0, 1.0]], "finite; sample 1"),
        ([[0.0, 0.0], [1.0, math.inf], [2.0, 1.0]], "finite; sample 1"),
        ([0.0, 1.0, 2.0], "shape"),
        (np.zeros((4, 3)), "shape"),
        ("many", "array of numbers"),
    ],
)
def test_too_few_and_degenerate_samples_are_refused(samples: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        dispersion_ellipse(samples)  # type: ignore[arg-type]


@pytest.mark.parametrize("sigmas", [0.0, -1.0, math.nan])
def test_sigmas_must_be_positive(sigmas: float) -> None:
    with pytest.raises(InputError, match="sigmas"):
        dispersion_ellipse(cross(2.0, 1.0, 0.0), sigmas)


def test_angles_between_directions_without_sense() -> None:
    assert angle_between(179.0, 2.0) == pytest.approx(3.0)
    assert angle_between(10.0, 100.0) == pytest.approx(90.0)
    assert angle_between(30.0, 30.0) == 0.0
