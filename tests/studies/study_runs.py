"""What tests of studies share: a body that is solved in milliseconds, points on it, and comparisons of results."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr
from tests.blocks import block

import glossa
from glossa import Scene
from glossa.studies import Point, Progress

BOOKKEEPING = ("seconds", "worker")
"""What differs between runs of the same study."""


def small_scene(cells: tuple[int, int, int] = (4, 2, 2)) -> Scene:
    """A block on a wall with two muscles."""
    return Scene(block(cells, muscles={"upper": 2.0, "lower": 2.0}), fixed=["left"])


def commands(count: int) -> list[Point]:
    """Points of one scene."""
    values = np.linspace(0.7, 0.95, count).tolist()
    return [Point(commands={"upper": value}, labels={"command": value}) for value in values]


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    """Equal to the last bit, but for who computed a point and how long that took."""
    xr.testing.assert_identical(one.drop_vars(BOOKKEEPING), other.drop_vars(BOOKKEEPING))


def after(count: int, action: Callable[[], None]) -> Callable[[Progress], None]:
    """A progress callback that acts once, when so many points are done."""
    acted: list[bool] = []

    def watch(progress: Progress) -> None:
        if progress.done >= count and not acted:
            acted.append(True)
            action()

    return watch


def environment() -> dict[str, str]:
    """Variables for a process that imports the same glossa."""
    path = os.pathsep.join([str(Path(glossa.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
