"""Section III.A.1 on the built-in speaker, which was not calibrated on it."""

from __future__ import annotations

import pandas as pd
import pytest

from glossa import Scene, Speaker
from glossa.errors import InputError
from glossa.studies import muscle_effects


@pytest.fixture(scope="module")
def effects(reference: Speaker) -> pd.DataFrame:
    return muscle_effects(Scene(reference, mirror=True))


def test_every_direction_is_right(effects: pd.DataFrame) -> None:
    assert len(effects) == 36
    assert effects["right"].all(), effects[~effects["right"]]


def test_two_thirds_of_the_magnitudes_agree(effects: pd.DataFrame) -> None:
    stated = effects["agrees"].notna()
    assert stated.sum() == 28
    assert (effects["agrees"][stated].astype(bool)).mean() >= 2.0 / 3.0, effects[stated]


def test_needs_a_mobile_hyoid(reference: Speaker) -> None:
    with pytest.raises(InputError, match="mobile hyoid"):
        muscle_effects(Scene(reference, mirror=True, hyoid="fixed"))
