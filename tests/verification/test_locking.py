"""Volumetric locking: plain Q1 locks near incompressibility, mean dilatation (Q1P0) does not."""

from __future__ import annotations

import pytest
from tests.blocks import block, nearest

from glossa import Scene, Yeoh

POINT = (0.06, 0.02, 0.02)


def sag(cells: tuple[int, int, int], element: str, poissons_ratio: float) -> float:
    """Downward displacement in mm of the end of the cantilever under its weight."""
    speaker = block(cells)
    tissue = Yeoh(1037.0, 486.0, poissons_ratio=poissons_ratio)
    posture = Scene(speaker, fixed=["left"], element=element, tissue=tissue).equilibrate()
    return float(-1e3 * posture.displacements[nearest(speaker, POINT), 2])


def test_q1_locks_and_q1p0_does_not() -> None:
    limit = 24.23  # mesh limit of P1 (shared/reference/solvers), +- 0.04, at nu = 0.499 to a promille of kappa
    coarse, fine = sag((3, 2, 2), "Q1P0", 0.499), sag((6, 4, 4), "Q1P0", 0.499)
    assert coarse == pytest.approx(limit, rel=0.15)
    assert fine == pytest.approx(limit, rel=0.06)
    assert sag((6, 4, 4), "Q1", 0.499) < 0.55 * limit
    assert sag((12, 8, 8), "Q1", 0.499) < 0.65 * limit  # refinement is no cure


def test_q1p0_does_not_depend_on_the_bulk_modulus() -> None:
    loose, stiff = sag((6, 4, 4), "Q1P0", 0.499), sag((6, 4, 4), "Q1P0", 0.4999)
    assert stiff == pytest.approx(loose, rel=0.005)
    assert stiff != loose
    assert sag((6, 4, 4), "Q1", 0.4999) < 0.85 * sag((6, 4, 4), "Q1", 0.499)


def test_the_elements_agree_where_nothing_locks() -> None:
    """At nu = 0.3 both are plain displacement elements to first order; their difference falls with the mesh."""
    coarse = sag((6, 4, 4), "Q1P0", 0.3) / sag((6, 4, 4), "Q1", 0.3) - 1.0
    fine = sag((12, 8, 8), "Q1P0", 0.3) / sag((12, 8, 8), "Q1", 0.3) - 1.0
    assert 0.0 < coarse < 0.1
    assert 0.0 < fine < 0.5 * coarse
