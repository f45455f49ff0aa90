from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from glossa import AreaFunction, InputError, Posture, area_function
from glossa.figures.tract import OVERHANG, cutting_planes, tract_sections


def planes_of(axes: Axes) -> dict[str, list[np.ndarray]]:
    found = [c for c in axes.collections if isinstance(c, LineCollection) and str(c.get_gid()).startswith("planes:")]
    return {str(c.get_gid()).removeprefix("planes:"): [np.asarray(s) for s in c.get_segments()] for c in found}


def test_every_plane_is_drawn_from_wall_to_wall(postures: dict[str, Posture]) -> None:
    area = area_function(postures["i"], "i")
    sheet = cutting_planes(postures["i"], area, title="i")
    sheet.savefig(BytesIO())
    (axes,) = sheet.axes
    drawn = planes_of(axes)
    assert {k: len(v) for k, v in drawn.items()} == {
        status: len(area.sections.with_status(status)) for status in ("closed", "ambiguous", "open")
    }
    lengths = [np.linalg.norm(line[1] - line[0]) for line in drawn["closed"]]
    expected = [s.sagittal_distance * 1e3 + 2.0 * OVERHANG for s in area.sections if s.status == "closed"]
    assert lengths == pytest.approx(expected)
    path = max((np.asarray(line.get_xydata()) for line in axes.lines if line.get_marker() == "."), key=len)
    assert path == pytest.approx(area.sections.centroids[:, [0, 2]] * 1e3)
    assert {"0", "20", "40"} <= {text.get_text() for text in axes.texts}
    assert "(mm)" in axes.get_xlabel()


def test_everything_drawn_lies_in_the_picture(postures: dict[str, Posture]) -> None:
    (axes,) = cutting_planes(postures["a"], area_function(postures["a"], "a")).axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    ends = np.concatenate([line for lines in planes_of(axes).values() for line in lines])
    assert left < ends[:, 0].min() < ends[:, 0].max() < right
    assert low < ends[:, 1].min() < ends[:, 1].max() < high


def test_sections_are_drawn_with_their_contours(postures: dict[str, Posture]) -> None:
    area = area_function(postures["a"], "a")
    sheet = tract_sections(area, numbers=[3, 30])
    sheet.savefig(BytesIO())
    panels = sheet.axes
    assert len(panels) == 2
    for axes, number in zip(panels, (3, 30), strict=True):
        outline = np.asarray(axes.lines[0].get_xydata())
        assert outline == pytest.approx(np.asarray(area.sections[number].contour.exterior.coords) * 1e3)
        assert axes.get_title().startswith(f"{number}: {area.areas[number] * 1e4:.2f} cm²")
    assert len(tract_sections(area.sections).axes) == len(area.sections)


def test_what_has_no_sections_is_refused(postures: dict[str, Posture]) -> None:
    with pytest.raises(InputError, match="no sections"):
        cutting_planes(postures["a"], AreaFunction.uniform(0.17, 3e-4))
    area = area_function(postures["a"], "a")
    with pytest.raises(InputError, match="numbered from 0 to 44, got \\[45\\]"):
        tract_sections(area, numbers=[45])
    with pytest.raises(InputError, match="got none"):
        tract_sections(area, numbers=[])
