"""Midsagittal figures: what is in them and where."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from glossa import InputError, Posture, Speaker
from glossa.figures import midsagittal, midsagittal_panels, overview
from glossa.figures.style import VOWEL_COLOURS
from glossa.studies import rest_posture


def tongue_lines(axes: Axes) -> list[Line2D]:
    """Outlines of tongues: what surrounds them is named."""
    return [line for line in axes.lines if line.get_gid() is None]


def test_one_picture_has_rest_dotted_and_every_posture(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures).axes
    rest, *others = tongue_lines(axes)
    assert rest.get_label() == "rest"
    assert rest.get_linestyle() == "--"  # what matplotlib calls any dash pattern of its own
    assert [line.get_label() for line in others] == ["/i/", "/a/"]
    assert [line.get_color() for line in others] == [VOWEL_COLOURS["i"], VOWEL_COLOURS["a"]]
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["rest", "/i/", "/a/"]


def test_axes_are_millimetres_with_the_tip_on_the_left(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures["i"]).axes
    assert axes.get_aspect() == 1.0
    assert "mm" in axes.get_xlabel()
    assert "mm" in axes.get_ylabel()
    left, right = axes.get_xlim()
    tip = postures["i"].node_set("tip")[0, 0] * 1e3
    assert left < tip < (left + right) / 2
    drawn = tongue_lines(axes)[1].get_xydata()
    outline_nodes = postures["i"].node_set("dorsum")[:, [0, 2]] * 1e3
    gaps = np.linalg.norm(np.asarray(drawn)[None] - outline_nodes[:, None], axis=2).min(axis=1)
    assert gaps.max() < 1e-9  # the curve passes through every node
    assert np.ptp(outline_nodes) > 1.0


def test_rest_can_be_left_out(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures, rest=False).axes
    assert len(tongue_lines(axes)) == 2


def test_attachments_are_marked(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures).axes
    marks = {c.get_gid(): c for c in axes.collections if isinstance(c, LineCollection)}
    assert set(marks) == {"held:jaw", "held:hyoid"}
    assert all(len(mark.get_segments()) > 0 for mark in marks.values())
    assert {text.get_text() for text in axes.texts} == {"jaw", "hyoid"}


def test_panels(postures: dict[str, Posture]) -> None:
    figure = midsagittal_panels(postures, columns=1)
    assert [axes.get_title() for axes in figure.axes] == ["/i/", "/a/"]
    assert figure.axes[0].get_xlim() == figure.axes[1].get_xlim()
    assert not figure.axes[0].get_xlabel()
    assert figure.axes[1].get_xlabel()


def test_vowels_differ_as_a_phonetician_expects(postures: dict[str, Posture]) -> None:
    """The drawn tongue of /i/ is higher and further forward at its highest point than that of /a/."""
    (axes,) = midsagittal(postures, rest=False).axes
    tops = []
    for line in tongue_lines(axes):
        points = np.asarray(line.get_xydata())
        tops.append(points[points[:, 1].argmax()])
    assert tops[0][1] > tops[1][1] + 5.0
    assert tops[0][0] < tops[1][0]


def test_walls_of_pb_are_cut(pb: Speaker) -> None:
    (axes,) = midsagittal({"rest of PB": rest_posture(pb)}).axes
    assert {line.get_gid() for line in axes.lines} >= {
        "wall:hard_palate",
        "wall:soft_palate",
        "wall:mandible",
        "wall:hyoid bone",
    }


def test_overview_has_shapes_above_bars(postures: dict[str, Posture], tmp_path: Path) -> None:
    from glossa import paper

    figure = overview(postures, paper.forces())
    assert len(figure.axes) == 4
    assert [len(axes.patches) for axes in figure.axes[2:]] == [22, 22]
    figure.savefig(tmp_path / "overview.pdf")
    assert (tmp_path / "overview.pdf").stat().st_size > 10_000


def test_no_posture_and_two_speakers_are_refused(postures: dict[str, Posture]) -> None:
    with pytest.raises(InputError, match="at least one posture"):
        midsagittal({})
    other = Speaker(
        postures["i"].speaker.nodes,
        postures["i"].speaker.hexahedra,
        muscles=postures["i"].speaker.muscles,
        node_sets={"jaw": postures["i"].speaker.node_sets["jaw"]},
    )
    with pytest.raises(InputError, match="one speaker"):
        midsagittal_panels({"i": postures["i"], "x": rest_posture(other)})
