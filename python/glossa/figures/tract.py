"""Figures of the vocal tract: cutting planes in the midsagittal section, and the sections themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from glossa.acoustics import AreaFunction
from glossa.anatomy.arrays import FloatArray
from glossa.errors import InputError
from glossa.figures import style
from glossa.figures.midsagittal import draw_panels, set_axes
from glossa.results import Posture
from glossa.tract import Section, Tract

STATUS_COLOURS = {"closed": style.BLUE, "ambiguous": style.ORANGE, "open": style.VERMILION}
"""Of planes and contours, by status of the section."""

OVERHANG = 2.0
"""How far a plane is drawn beyond the airway, mm."""
OPEN = 8.0
"""Half length of the plane of an open section, mm."""


@style.styled
def cutting_planes(posture: Posture, tract: Tract | AreaFunction, *, title: str = "posture") -> Figure:
    """Midsagittal section of a posture with the cutting planes, from wall to wall, and the path of the centroids.

    Every fifth plane is numbered, the glottis is 0.

    Args:
        posture: whose tract it is.
        tract: of :func:`glossa.tract.cut_tract`, or an area function of :func:`glossa.area_function`.
        title: name of the posture, which also sets its colour.

    Raises:
        InputError: an area function that no posture was cut for.
    """
    sections = _sections(tract)
    sheet = style.new_sheet(5.4, 5.6)
    axes = sheet.add_subplot()
    draw_panels([axes], {title: posture})
    set_axes(axes, posture.speaker)
    for status, colour in STATUS_COLOURS.items():
        lines = [_trace(section) for section in sections if section.status == status]
        drawn = LineCollection(lines, colors=colour, linewidths=0.9, zorder=4.5)
        drawn.set_gid(f"planes:{status}")
        axes.add_collection(drawn)
    path = np.array([section.centroid[[0, 2]] for section in sections]) * 1e3
    axes.plot(*path.T, color=style.BLACK, linewidth=1.0, marker=".", markersize=2.5, zorder=4.6)
    for number, section in enumerate(sections):
        if number % 5 == 0:
            x, z = _trace(section)[1]
            axes.annotate(str(number), (x, z), xytext=(2, 2), textcoords="offset points", fontsize=6.5)
    ends = np.concatenate([_trace(section) for section in sections])
    axes.set_xlim(min(axes.get_xlim()[0], ends[:, 0].min() - 3.0), max(axes.get_xlim()[1], ends[:, 0].max() + 3.0))
    axes.set_ylim(min(axes.get_ylim()[0], ends[:, 1].min() - 3.0), max(axes.get_ylim()[1], ends[:, 1].max() + 3.0))
    present = {section.status for section in sections}
    handles = [Line2D([], [], color=c, label=f"{s} section") for s, c in STATUS_COLOURS.items() if s in present]
    axes.legend(handles=[*handles, Line2D([], [], color=style.BLACK, label="centroids")], loc="lower left")
    return sheet


@style.styled
def tract_sections(tract: Tract | AreaFunction, *, numbers: Sequence[int] | None = None, columns: int = 9) -> Figure:
    """The contours of the sections, each in its plane seen from the larynx, palate and rear wall above.

    Args:
        tract: as for :func:`cutting_planes`.
        numbers: which sections, from 0 at the glottis; None: all.
        columns: panels in a row.

    Raises:
        InputError: an area function that no posture was cut for, or no such section.
    """
    sections = _sections(tract)
    chosen = list(range(len(sections)) if numbers is None else numbers)
    unknown = [number for number in chosen if not 0 <= number < len(sections)]
    if unknown or not chosen:
        raise InputError(f"sections are numbered from 0 to {len(sections) - 1}, got {unknown or 'none'}")
    across = min(columns, len(chosen))
    rows = math.ceil(len(chosen) / across)
    sheet = style.new_sheet(0.4 + 1.3 * across, 0.4 + 1.0 * rows)
    panels = sheet.subplots(rows, across, sharex=True, sharey=True, squeeze=False).ravel()
    for axes in panels[len(chosen) :]:
        axes.remove()
    for axes, number in zip(panels, chosen, strict=False):
        _draw_section(axes, sections[number])
        axes.set_title(f"{number}: {sections[number].area * 1e4:.2f} cm²", fontsize=7.0, fontweight="normal")
    bounds = np.array([sections[n].contour.bounds for n in chosen if not sections[n].contour.is_empty]) * 1e3
    if len(bounds):
        panels[0].set_xlim(bounds[:, 0].min() - 1.0, bounds[:, 2].max() + 1.0)
        panels[0].set_ylim(bounds[:, 1].min() - 1.0, bounds[:, 3].max() + 1.0)
    sheet.supxlabel("lateral (mm)", fontsize=8.0)
    sheet.supylabel("in the plane, towards palate and rear wall (mm)", fontsize=8.0)
    return sheet


def _draw_section(axes: Axes, section: Section) -> None:
    colour = STATUS_COLOURS[section.status]
    for polygon in getattr(section.contour, "geoms", [section.contour]):
        if not polygon.is_empty:
            outline = np.asarray(polygon.exterior.coords) * 1e3
            axes.add_patch(Polygon(outline, closed=True, facecolor=colour, alpha=0.3, edgecolor="none"))
            axes.plot(*outline.T, color=colour, linewidth=1.0)
    axes.set_aspect("equal")


def _trace(section: Section) -> FloatArray:
    """(2, 2) x and z in mm: the plane in the midsagittal section, inner end first."""
    low, high = section.midsagittal * 1e3
    low, high = (-OPEN, OPEN) if np.isnan(low) else (low - OVERHANG, high + OVERHANG)
    origin, direction = section.origin[[0, 2]] * 1e3, section.outwards[[0, 2]]
    return np.stack([origin + low * direction, origin + high * direction])


def _sections(tract: Tract | AreaFunction) -> Sequence[Section]:
    cut = tract.sections if isinstance(tract, AreaFunction) else tract
    if not isinstance(cut, Tract):
        raise InputError("this area function has no sections; make it from a posture with glossa.area_function")
    return cut.sections
