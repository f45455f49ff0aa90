"""Formants computed by other programs, with their constants: see ``shared/reference/acoustics``."""

from __future__ import annotations

import numpy as np
import pytest
from tests.acoustics.tracts import reference

from glossa import TUBE_CONSTANTS, AreaFunction

CASES = ("generic neutral", "DRM neutral", "Fant 4-tube neutral")
FANT = np.concatenate([np.full(60, 1.0), np.full(60, np.exp(-2.5)), np.full(60, 1.0), np.full(20, np.exp(-0.5))])


@pytest.mark.parametrize("name", CASES)
def test_transmission_line_program(name: str) -> None:
    """Complex poles, lumped sections; printed with four decimals."""
    case = next(case for case in reference("transmission_line.json")["cases"] if case["name"] == name)
    areas = FANT if name.startswith("Fant") else np.ones(case["n"])
    assert areas.size == case["n"]
    tract = AreaFunction(np.full(case["n"], case["length_cm"] / case["n"]) * 1e-2, areas * 1e-4)
    constants = TUBE_CONSTANTS["badin"].with_(sections="lumped")
    if not case["wall"]:
        constants = constants.with_(wall=None)
    found = tract.formants(len(case["F_Hz"]), constants=constants).frequencies
    assert np.abs(found - case["F_Hz"]).max() < 2e-4
    exact = tract.formants(len(case["F_Hz"]), constants=constants.with_(sections="exact")).frequencies
    assert 1e-3 < np.abs(exact - found).max() < 0.2


@pytest.mark.parametrize("vowel", ["a", "i", "x"])
def test_praat(vowel: str) -> None:
    """Peaks of the spectrum, printed with one decimal."""
    values = reference("praat.json")
    case = values["vowels"][vowel]
    areas = np.array(case["area_cm2"]) * 1e-4
    tract = AreaFunction(np.full(areas.size, values["section_length_cm"] * 1e-2), areas)
    found = tract.formants(4, constants="praat", method="peaks").frequencies
    assert np.abs(found - case["F_Hz"]).max() < 0.1
