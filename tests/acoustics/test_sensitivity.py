from __future__ import annotations

import numpy as np
import pytest
from tests.acoustics.tracts import vowels

from glossa import TUBE_CONSTANTS, AreaFunction, InputError, TubeConstants
from glossa.acoustics import formants

SETS = [
    *TUBE_CONSTANTS.values(),
    TUBE_CONSTANTS["badin"].with_(name="lumped", sections="lumped"),
    TUBE_CONSTANTS["badin"].lossless().with_(name="lossless"),
]


@pytest.mark.parametrize("constants", SETS, ids=lambda c: c.name)
@pytest.mark.parametrize("name", ["a", "u", "rough"])
def test_against_differences(constants: TubeConstants, name: str) -> None:
    """Formants by some sections' areas and lengths; the differences have an error of about 1e-8 of their own."""
    tract = vowels()[name]
    n, sections = 2, tract.areas.size
    by_area = tract.sensitivity(n, constants=constants)
    by_length = tract.sensitivity(n, constants=constants, by="length")
    assert by_area.shape == by_length.shape == (n, sections)
    chosen = sorted({0, sections // 2, sections - 1})
    changes = 1e-4 * np.eye(sections)[chosen]
    for result, lengths, areas, values in (
        (by_area, 0.0 * changes, changes, tract.areas),
        (by_length, changes, 0.0 * changes, tract.lengths),
    ):
        above, below = (
            formants(
                tract.areas * (1.0 + s * areas), n, lengths=tract.lengths * (1.0 + s * lengths), constants=constants
            )
            for s in (1.0, -1.0)
        )
        difference = (above.frequencies - below.frequencies) / (2e-4 * values[chosen, None])
        analytic = result[:, chosen].T
        assert analytic == pytest.approx(difference, abs=1e-6 * np.abs(result).max())
        assert np.abs(difference).max() > 0.0


def test_relative_sums_of_a_lossless_tract() -> None:
    """All areas by one factor change nothing; all lengths by one factor change every formant by its inverse."""
    constants = TUBE_CONSTANTS["badin"].lossless()
    for tract in vowels().values():
        by_area = tract.sensitivity(4, constants=constants, relative=True)
        by_length = tract.sensitivity(4, constants=constants, by="length", relative=True)
        assert by_area.sum(axis=1) == pytest.approx(np.zeros(4), abs=1e-9)
        assert by_length.sum(axis=1) == pytest.approx(-np.ones(4), abs=1e-9)
        assert np.abs(by_area).max() > 0.05


def test_relative_is_the_derivative_of_logarithms() -> None:
    tract = vowels()["e"]
    plain = tract.sensitivity(3)
    found = tract.formants(3).frequencies
    assert tract.sensitivity(3, relative=True) == pytest.approx(plain * tract.areas / found[:, None])


def test_constriction_near_the_lips_lowers_every_formant() -> None:
    """Of a uniform tube (Chiba & Kajiyama 1941): flow is largest at the lips, pressure at the glottis."""
    relative = AreaFunction.uniform(0.175, 3e-4, 35).sensitivity(3, relative=True)
    assert (relative[:, -2] > 0.0).all()
    assert (relative[:, 0] < 0.0).all()


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(InputError, match="by must be one of 'area', 'length'"):
        vowels()["a"].sensitivity(by="volume")
    with pytest.raises(InputError, match="relative must be True or False"):
        vowels()["a"].sensitivity(relative=1)  # type: ignore[arg-type]
