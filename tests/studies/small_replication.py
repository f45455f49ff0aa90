"""A replication from small real results: no contact, short movements, six runs of Table VI."""

from __future__ import annotations

from typing import Any

import pytest
import xarray as xr
from tests.studies.paper_runs import quick_scene

from glossa import Scene, Speaker
from glossa.studies import Replication, gravity, replicate, sensitivity, sensitivity_changes
from glossa.studies import replication_runs as runs

CHANGED = {"GGa": (-10.0, -5.0, 5.0), "SL": (-10.0, -8.0, -5.0)}
"""Runs of Table VI that are made."""


def short_gravity(scene: Scene, vowels: Any, *, progress: Any = None) -> xr.Dataset:
    """Movements of 20 ms."""
    return gravity(scene, vowels, until=0.02, vowel_until=0.02, progress=progress)


def some_changes(scene: Scene, vowel: str, **options: Any) -> xr.Dataset:
    """A study with every place of Table VI, but only the runs of ``CHANGED`` in it."""
    study = sensitivity(scene, vowel, CHANGED, **options)
    changes = sensitivity_changes(vowel)
    return study.reindex(
        muscle=list(changes),
        change=sorted({change for several in changes.values() for change in several}),
        fill_value={"asked": False, "converged": False, "reason": "not run", "started": "", "iterations": 0},
    )


def shorten(patch: pytest.MonkeyPatch) -> None:
    """Put these in the place of the long studies."""
    patch.setattr(runs, "gravity", short_gravity)
    patch.setattr(runs, "sensitivity", some_changes)


def small_replication(speaker: Speaker) -> Replication:
    """The replication itself."""
    with pytest.MonkeyPatch.context() as patch:
        shorten(patch)
        return replicate(quick_scene(speaker))
