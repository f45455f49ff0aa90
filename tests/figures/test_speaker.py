"""The sheet of a speaker's anatomy."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from glossa import InputError, Speaker, figures
from glossa.figures.speaker import STATIONS


def lines(axes: Axes, name: str) -> np.ndarray:
    """(n, 2) all points of the lines of that name, mm."""
    found = [line for line in axes.collections if isinstance(line, LineCollection) and line.get_gid() == name]
    return np.concatenate([np.asarray(path) for line in found for path in line.get_segments()])


def words(sheet: Figure) -> Iterable[str]:
    return [text.get_text() for legend in sheet.legends for text in legend.get_texts()]


def test_sections_show_mesh_walls_and_bone(reference: Speaker) -> None:
    sheet = figures.speaker(reference)
    middle, *frontal, bars = sheet.axes
    mesh = lines(middle, "mesh")
    assert mesh.max(axis=0) == pytest.approx(reference.nodes[reference.midsagittal_nodes][:, [0, 2]].max(axis=0) * 1e3)
    for name, wall in reference.walls.items():
        in_plane = wall.vertices[wall.vertices[:, 1] == 0.0, 2]
        assert lines(middle, f"wall:{name}")[:, 1].max() == pytest.approx(in_plane.max() * 1e3, abs=0.01)
    assert reference.hyoid is not None
    springs = next(line for line in middle.collections if line.get_gid() == "springs")
    assert isinstance(springs, LineCollection)
    assert len(springs.get_segments()) == len(reference.hyoid.springs)
    assert "hyoid" in {patch.get_gid() for patch in middle.patches}
    for axes, letter in zip(frontal, STATIONS, strict=True):
        points = lines(axes, "mesh")
        assert points[:, 0].max() == pytest.approx(-points[:, 0].min())
        assert axes.get_title().startswith(f"{letter}: x = ")
        assert lines(axes, "wall:mandible").size
    heights = sum(bar.get_height() for bar in bars.patches if isinstance(bar, Rectangle))
    assert heights == len(reference.hexahedra)
    assert {"tongue", "hard palate", "hyoid bone", "springs"} <= set(words(sheet))


def test_labels_do_not_overlap(reference: Speaker) -> None:
    sheet = figures.speaker(reference)
    canvas = FigureCanvasAgg(sheet)
    canvas.draw()  # type: ignore[no-untyped-call]
    renderer = canvas.get_renderer()  # type: ignore[no-untyped-call]
    texts = [t for axes in sheet.axes for t in (axes.title, axes.xaxis.label, axes.yaxis.label)]
    boxes = [text.get_window_extent(renderer) for text in (*texts, *sheet.legends)]
    for number, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:number])
        assert box.x0 >= 0.0
        assert box.y0 >= 0.0


def test_poor_elements_stand_out(pb: Speaker) -> None:
    bars = [bar for bar in figures.speaker(pb).axes[-1].patches if isinstance(bar, Rectangle)]
    colours = {bar.get_facecolor() for bar in bars if bar.get_x() < 0.299}
    assert len(colours) == 1
    assert colours.isdisjoint(bar.get_facecolor() for bar in bars if bar.get_x() > 0.299)
    poor = sum(bar.get_height() for bar in bars if bar.get_facecolor() in colours)
    assert poor == pb.quality().below_good


def test_a_bare_body_has_a_sheet_and_one_off_the_midplane_none() -> None:
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float) * 1e-2
    assert len(figures.speaker(Speaker(corners, [list(range(8))])).axes) == 5
    with pytest.raises(InputError, match="no midsagittal section"):
        figures.speaker(Speaker(corners + 0.1, [list(range(8))]))
