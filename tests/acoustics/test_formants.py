from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.acoustics.tracts import TWO_TUBES, rough, vowels

from glossa import TUBE_CONSTANTS, AreaFunction, Formants, InputError, SolveError
from glossa.acoustics import formants
from glossa.acoustics.formants import WIDEST

OPEN_FRONT = AreaFunction([0.07, 0.03, 0.02, 0.02, 0.02], [8e-4, 0.5e-4, 1e-4, 3e-4, 9e-4])
"""A mouth that opens like a horn: its front cavity loses its energy through the lips."""
WIDE_OPEN = AreaFunction.uniform(0.1, 60e-4)


def test_result() -> None:
    found = TWO_TUBES["a"].formants()
    assert isinstance(found, Formants)
    assert len(found) == 4
    assert found.frequencies.shape == found.bandwidths.shape == (4,)
    assert (np.diff(found.frequencies) > 0.0).all()
    assert found.reason == ""
    assert repr(found).startswith("Formants(F1 782 (")
    with pytest.raises(ValueError, match="read-only"):
        found.frequencies[0] = 1.0


def test_wide_poles_are_listed_but_not_counted() -> None:
    found = OPEN_FRONT.formants(4, constants="story")
    wide = 2.0 * found.poles.imag > WIDEST
    assert wide.any()
    assert found.bandwidths.max() <= WIDEST
    assert found.frequencies == pytest.approx(found.poles.real[~wide][:4])
    assert found.poles.real[wide].min() < found.frequencies[-1]


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
def test_poles_and_peaks_agree_where_formants_are_narrow(name: str) -> None:
    """A resonance of bandwidth B at distance Δ of its neighbours has its peak within about B²/Δ of the pole."""
    for tract in vowels().values():
        poles = tract.formants(2, constants=name)
        peaks = tract.formants(2, constants=name, method="peaks")
        apart = abs(poles.frequencies[1] - poles.frequencies[0])
        limit = 2.0 * poles.bandwidths**2 * (1.0 / apart + 1.0 / poles.frequencies)
        assert (np.abs(peaks.frequencies - poles.frequencies) < limit).all()
        assert peaks.bandwidths == pytest.approx(poles.bandwidths, rel=0.35)


@pytest.mark.parametrize("method", ["poles", "peaks"])
def test_tracts_of_unequal_counts_together(method: str) -> None:
    tracts = list(vowels().values())
    table = formants(tracts, 3, method=method)
    assert len(table) == len(tracts)
    assert table.frequencies.shape == (len(tracts), 3)
    for together, tract in zip(table, tracts, strict=True):
        alone = tract.formants(3, method=method)
        assert together.frequencies == pytest.approx(alone.frequencies, rel=1e-8)
        assert together.bandwidths == pytest.approx(alone.bandwidths, rel=1e-5)
    assert [one.frequencies[0] for one in table[1:3]] == table.frequencies[1:3, 0].tolist()


def test_arrays_and_area_functions_are_the_same() -> None:
    lengths, areas = rough(8, 5)
    from_arrays = formants(areas, 4, lengths=lengths).frequencies
    assert formants(areas, 4, lengths=lengths[0]).frequencies.tolist() == from_arrays.tolist()
    tracts = [AreaFunction(*pair) for pair in zip(lengths, areas, strict=True)]
    assert formants(tracts, 4).frequencies.tolist() == from_arrays.tolist()


def test_same_bits_again() -> None:
    lengths, areas = rough(9, 10)
    one, two = (formants(areas, 4, lengths=lengths) for _ in range(2))
    assert one.frequencies.tobytes() == two.frequencies.tobytes()
    assert one.bandwidths.tobytes() == two.bandwidths.tobytes()


@pytest.mark.parametrize("method", ["poles", "peaks"])
def test_thousand_tracts_have_their_formants(method: str) -> None:
    lengths, areas = rough(10, 200 if method == "peaks" else 1000, 45, 0.35)
    table = formants(areas, 4, lengths=lengths, method=method)
    assert set(table.reasons) == {""}
    assert np.isfinite(table.frequencies).all()
    assert (np.diff(table.frequencies, axis=1) > 0.0).all()
    assert table.frequencies.min() > 50.0


def test_what_is_not_found_is_told() -> None:
    table = formants([TWO_TUBES["a"], WIDE_OPEN], 4, constants="story")
    assert table.reasons[1].startswith("only ")
    assert "wider than 350 Hz and not counted" in table.reasons[1]
    assert np.isnan(table.frequencies[1, -1])
    assert np.isfinite(table.frequencies[1, 0])
    assert table[1].reason == table.reasons[1]
    assert "nan" in repr(table[1])
    with pytest.raises(SolveError, match=r"only \d of 4 formants") as raised:
        WIDE_OPEN.formants(constants="story")
    assert raised.value.status == table.reasons[1]


def test_poles_that_cannot_be_told_are_not_given(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("glossa.acoustics.poles._newton", lambda t, r, g, f=None: [np.zeros(0, complex)] * len(g))  # noqa: ARG005
    monkeypatch.setattr("glossa.acoustics.bisection.MOST_PIECES", 2)
    with pytest.raises(SolveError, match="more than 2 pieces"):
        TWO_TUBES["a"].formants()
    table = formants([TWO_TUBES["a"]], 2)
    assert np.isnan(table.frequencies).all()
    assert np.isnan(table.bandwidths).all()


@pytest.mark.parametrize(
    ("tracts", "changes", "message"),
    [
        (TWO_TUBES["a"], {}, "one alone has the method"),
        ([], {}, "not empty, got shape"),
        ([TWO_TUBES["a"], 3.0], {}, "tracts must all be AreaFunction"),
        ([TWO_TUBES["a"]], {"lengths": [0.1, 0.1]}, "area functions bring their own"),
        ([[1e-4, 2e-4]], {}, "need lengths"),
        ([[1e-4, 2e-4]], {"lengths": [0.1]}, r"lengths must have shape \(1, 2\) or \(2,\), got \(1, 1\)"),
        ([[1e-4, 2e-4], [1e-4, -2e-4]], {"lengths": [0.1, 0.1]}, "tract 1: area of section 1"),
        ([[1e-4, 2e-4], [1e-4, 5.0]], {"lengths": [0.1, 0.1]}, "tract 1: area of section 1 is 5 m²"),
        ([1e-4, 2e-4], {"lengths": [0.1, 0.1]}, r"array \(tracts, sections\)"),
        ([TWO_TUBES["a"]], {"n": 0}, "n must be a whole number from 1 to 40"),
        ([TWO_TUBES["a"]], {"method": "lpc"}, "method must be one of 'poles', 'peaks'"),
        ([TWO_TUBES["a"]], {"constants": "air"}, "constants must be one of 'badin'"),
    ],
)
def test_bad_input_is_refused(tracts: Any, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        formants(tracts, **changes)
