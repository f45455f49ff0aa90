"""Symmetric scenes: the full model stays symmetric, and where that is unstable, the study of symmetry tells."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block, hyoid_block
from tests.hard.bodies import column
from tests.hard.checks import asymmetry, farthest, sound

from glossa import VOWELS, InputError, Ramp, Scene, Speaker
from glossa.studies import symmetry


@pytest.mark.parametrize("vowel", ["i", "a"])
def test_full_tongue_stays_symmetric(reference: Speaker, vowel: str) -> None:
    """Hard: rounding differs between left and right, and contact may amplify it. Right: symmetric to 1e-8 m, and equal
    to the mirrored model."""
    full = Scene(reference).equilibrate(VOWELS[vowel])
    sound(full)
    assert asymmetry(reference, full.positions) < 1e-8
    half = Scene(reference, mirror=True).equilibrate(VOWELS[vowel])
    assert farthest(full.positions, half.positions) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("vowel", list(VOWELS))
def test_vowels_are_stable_sideways(reference: Speaker, vowel: str) -> None:
    """Right: a vowel's equilibrium is found again after a nudge of 0.1 mm to one side."""
    result = symmetry(Scene(reference), VOWELS[vowel])
    assert result.symmetric, result


@pytest.mark.slow
def test_full_movement_stays_symmetric(reference: Speaker) -> None:
    """Hard: fifty steps, each of which may amplify what the one before has left. Right: 100 ms of /i/ in the full model
    symmetric to 1e-8 m throughout. (Residuals of 1e-4 of the forces, as of the standard accuracy, leave 7e-8 m.)"""
    movement = Scene(reference).simulate(Ramp(VOWELS["i"]), 0.1, dt=2e-3, accuracy="reference")
    assert max(asymmetry(reference, frame) for frame in movement.positions) < 1e-8


def pressed(slenderness: float) -> Scene:
    return Scene(column(slenderness), fixed=["left"], gravity=None)


def test_a_column_that_buckles_is_told() -> None:
    """Hard: a column pressed beyond its critical load has a straight equilibrium that Newton finds, mirrored and full,
    to the last bit of symmetry. Right: the study's nudge shows that it is unstable, and how far it would go."""
    shortened = {"right": (-0.006, 0.0, 0.0)}
    result = symmetry(pressed(10.0), prescribed=shortened, max_iterations=2000)
    assert not result.symmetric
    assert result.asymmetry < 1e-8
    assert result.apart < 1e-8
    assert result.returned > 5e-3
    assert np.abs(result.mirrored.displacements[:, 1]).max() < 1e-3


def test_a_short_column_is_stable() -> None:
    """Right: below the critical load the nudge comes back."""
    result = symmetry(pressed(6.0), prescribed={"right": (-0.006, 0.0, 0.0)})
    assert result.symmetric
    assert result.returned < 1e-7
    assert result.reason == ""


def test_a_solve_that_fails_is_no_symmetry() -> None:
    """Right: where the nudged solve is given up, the reason is kept and symmetry not claimed."""
    result = symmetry(pressed(10.0), prescribed={"right": (-0.012, 0.0, 0.0)}, max_iterations=20)
    assert "no equilibrium" in result.reason
    assert not result.symmetric
    assert result.returned > 0.0


def test_symmetry_of_hyoid_and_walls() -> None:
    result = symmetry(Scene(hyoid_block(between_walls=True, muscles={"upper": 2.0}), fixed=["right"]), {"upper": 0.7})
    assert result.symmetric, result


def test_bodies_that_are_not_symmetric_are_refused() -> None:
    with pytest.raises(InputError, match="mirror image about y = 0"):
        symmetry(Scene(block(), fixed=["left"]))
    with pytest.raises(InputError, match="nudge \\(m\\) must be positive"):
        symmetry(pressed(6.0), nudge=0.0)
