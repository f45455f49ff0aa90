"""Bars of forces and traces of movements."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.patches import Rectangle

from glossa import InputError, Movement, Posture, paper
from glossa.figures import force_bars, movement_traces
from glossa.figures.style import VOWEL_COLOURS, colours_of


def test_bars_are_forces_beside_the_papers(postures: dict[str, Posture]) -> None:
    figure = force_bars(postures, paper.forces())
    assert len(figure.axes) == 2
    bars = [patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle)]
    assert [bar.get_height() for bar in bars[:11]] == pytest.approx(postures["i"].forces.to_list())
    assert [bar.get_height() for bar in bars[11:]] == pytest.approx(list(paper.forces().loc["i"]))
    assert [label.get_text() for label in figure.axes[1].get_xticklabels()] == list(postures["i"].forces.index)
    assert all("(N)" in axes.get_ylabel() for axes in figure.axes)


@pytest.mark.parametrize("published", [None, pd.DataFrame({"GGp": [1.0]}, index=["elsewhere"])])
def test_bars_alone_where_nothing_is_published(postures: dict[str, Posture], published: pd.DataFrame | None) -> None:
    figure = force_bars(postures, published)
    assert [len(axes.patches) for axes in figure.axes] == [11, 11]


def test_bars_need_a_posture() -> None:
    with pytest.raises(InputError, match="at least one posture"):
        force_bars({})


def test_traces_follow_tip_dorsum_and_active_muscles(movement: Movement) -> None:
    backward, upward, force = movement_traces(movement).axes
    assert [line.get_label() for line in backward.lines[:2]] == ["tip", "dorsum"]
    tip = movement.speaker.node_sets["tip"][0]
    expected = (movement.positions[:, tip, 2] - movement.speaker.nodes[tip, 2]) * 1e3
    assert np.asarray(upward.lines[0].get_ydata()) == pytest.approx(expected)
    assert np.abs(expected).max() > 0.1
    shown = {text.get_text() for text in force.texts}
    assert {"GGp", "MH"} <= shown
    assert "Vert" not in shown
    assert len(force.lines) == len(shown)
    assert "ms" in force.get_xlabel()


def test_colours_are_kept_for_vowels_and_distinct_for_others() -> None:
    assert colours_of("iəua") == VOWEL_COLOURS
    mixed = colours_of(["rest", "i", "other"])
    assert mixed["i"] == VOWEL_COLOURS["i"]
    assert len(set(mixed.values())) == 3
