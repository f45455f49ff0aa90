"""What tests of the paper's studies share: the built-in speaker without contact, which is solved quickly."""

from __future__ import annotations

from typing import Any

import xarray as xr

from glossa import VOWELS, Scene, Speaker, paper
from glossa.studies import sensitivity


def quick_scene(speaker: Speaker, **options: Any) -> Scene:
    """A mirrored scene without contact."""
    return Scene(speaker, mirror=True, contact=False, **options)


def papers_own(study: xr.Dataset) -> xr.Dataset:
    """A copy of a study of /i/ whose formants are those of the paper."""
    copy = study.copy(deep=True)
    own = paper.formants_simulated().loc["i", ["F1_Hz", "F2_Hz", "F3_Hz"]].to_numpy(dtype=float)
    copy["vowel_formants"][:3] = own
    for (muscle, change), values in zip(paper.sensitivity_i().index, paper.sensitivity_i().to_numpy(), strict=True):
        copy["formants"].loc[{"muscle": muscle, "change": change, "formant": [1, 2, 3]}] = values
    return copy


def some_runs(scene: Scene) -> xr.Dataset:
    """Three runs of GGa and three of SL around /i/."""
    assert "i" in VOWELS
    return sensitivity(scene, "i", {"GGa": (-10.0, -5.0, 5.0), "SL": (-10.0, -8.0, -5.0)})
