from __future__ import annotations

import numpy as np
import pytest
from matplotlib.patches import StepPatch

from glossa import AreaFunction, Formants, InputError, paper
from glossa.figures.acoustics import area_functions, transfer_functions, vowel_chart

TRACTS = {
    "a": AreaFunction([0.09, 0.08], [1e-4, 7e-4]),
    "i": AreaFunction([0.07, 0.03, 0.02, 0.02, 0.02], [8e-4, 0.5e-4, 1e-4, 3e-4, 9e-4]),
}


def test_areas_are_steps_in_centimetres() -> None:
    (axes,) = area_functions(TRACTS).axes
    steps = [patch for patch in axes.patches if isinstance(patch, StepPatch)]
    assert len(steps) == 2
    values, edges, _ = steps[0].get_data()
    assert values == pytest.approx([1.0, 7.0])
    assert edges == pytest.approx([0.0, 9.0, 17.0])
    assert "(cm²)" in axes.get_ylabel()
    assert "glottis (cm)" in axes.get_xlabel()


def test_transfer_functions_have_formants_marked() -> None:
    panels = transfer_functions(TRACTS, constants="story", top=4500.0).axes
    assert [axes.get_title(loc="left") for axes in panels] == ["/a/", "/i/"]
    for axes, tract in zip(panels, TRACTS.values(), strict=True):
        found = tract.formants(4, constants="story")
        expected = [f"F{k} {f:.0f}" for k, f in enumerate(found.frequencies, 1) if f < 4500.0]
        assert [text.get_text() for text in axes.texts] == expected
        frequency, level = np.asarray(axes.lines[0].get_data(), dtype=float)
        response = np.abs(tract.transfer_function(frequency * 1e3, constants="story"))
        assert level == pytest.approx(20.0 * np.log10(response))
        dotted = [float(np.asarray(line.get_xdata())[0]) * 1e3 for line in axes.lines if line.get_linestyle() == ":"]
        assert dotted == pytest.approx([p.real for p in found.poles if 2.0 * p.imag > 350.0 and p.real < 4500.0])
    assert "(kHz)" in panels[-1].get_xlabel()


def test_chart_is_turned_as_phoneticians_do() -> None:
    found = {name: tract.formants() for name, tract in TRACTS.items()}
    (axes,) = vowel_chart(found, paper.formants_simulated()).axes
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    assert left > right
    assert bottom > top
    drawn = [np.asarray(line.get_xydata(), dtype=float) for line in axes.lines]
    points = {(float(point[0, 0]), float(point[0, 1])) for point in drawn if len(point) == 1}
    table = paper.formants_simulated()
    for vowel in table.index:
        assert (table.loc[vowel, "F2_Hz"], table.loc[vowel, "F1_Hz"]) in points
    for one in found.values():
        assert (float(one.frequencies[1]), float(one.frequencies[0])) in points
    assert {text.get_text() for text in axes.texts} == {"/a/", "/i/"}


def test_chart_alone() -> None:
    (axes,) = vowel_chart({"mine": TRACTS["a"].formants()}).axes
    assert axes.get_legend() is None
    assert [text.get_text() for text in axes.texts] == ["mine"]


def test_nothing_to_draw_is_refused() -> None:
    for draw in (area_functions, transfer_functions, vowel_chart):
        with pytest.raises(InputError, match="at least one result"):
            draw({})
    missing = Formants(np.array([500.0, np.nan]), np.array([50.0, np.nan]), np.zeros(0, complex), "lost")
    with pytest.raises(InputError, match="'a' need F1 and F2"):
        vowel_chart({"a": missing})
