"""Random commands of all muscles, cold and warm; README.md tells of 2,200 of them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from tests.hard import random_commands as drawn

from glossa import VOWELS, Scene, SolveError, Speaker, studies


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return Scene(reference, mirror=True)


def cold_and_warm(scene: Scene, which: str, count: int) -> tuple[xr.Dataset, xr.Dataset]:
    """The same commands from rest and from /i/."""
    design, start = drawn.design(which, count), scene.equilibrate(VOWELS["i"])
    cold = studies.sweep(scene, design, None, positions=True)
    return cold, studies.sweep(scene, design, None, positions=True, start=start)


@pytest.mark.parametrize("which", list(drawn.RANGES))
def test_random_commands(scene: Scene, which: str) -> None:
    """Hard: eleven muscles anywhere between full shortening and silence. Right: an equilibrium for every one, without
    inverted element, nowhere deeper in a wall than contact allows."""
    drawn.check(studies.sweep(scene, drawn.design(which, 5), None))


@pytest.mark.slow
@pytest.mark.parametrize(("which", "count"), [("wide", 200), ("common", 2000)])
def test_many_random_commands(scene: Scene, which: str, count: int) -> None:
    """Hard: two thousand times what may go wrong once. Right: converged but for at most one in five hundred, which is
    refused with its reason; where cold and warm starts end apart, contact made hard joins them, or both are
    equilibria that are found again after a nudge."""
    cold, warm = cold_and_warm(scene, which, count)
    for study in (cold, warm):
        failed = study["status"] != "converged"
        assert int(failed.sum()) <= count // 500
        assert all(study["reason"].values[failed.values])
        drawn.check(study.isel(point=np.flatnonzero(~failed.values)))
    apart = np.flatnonzero(drawn.distances(cold, warm) > drawn.SAME)
    doubtful = [int(point) for point in apart[:20] if not told_apart(scene, cold, warm, int(point))]
    assert len(doubtful) <= 2, doubtful


def told_apart(scene: Scene, cold: xr.Dataset, warm: xr.Dataset, point: int) -> bool:
    """Whether two results are shown to be one equilibrium, or two."""
    one, other = (study["positions"].values[point] for study in (cold, warm))
    try:
        compared = drawn.compare(scene, drawn.commands_of(cold, point), one, other, seed=point)
    except SolveError:
        return False
    return compared.same or compared.both_real
