"""Figures of a replication, each beside the place in the paper that it belongs to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import xarray as xr
from matplotlib.figure import Figure

from glossa import paper
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.figures.acoustics import vowel_chart
from glossa.figures.charts import force_bars
from glossa.figures.contact import contact_map
from glossa.figures.dispersion import dispersion, saturation
from glossa.figures.gravity import gravity_forces, gravity_shapes
from glossa.figures.midsagittal import midsagittal_panels
from glossa.figures.spatial import surfaces
from glossa.figures.transversalis import transversalis
from glossa.studies.replication import Replication


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure of a replication.

    Attributes:
        place: in the paper, as in the rows of the replication.
        caption: what it shows, and which figure of the paper it stands beside.
        figure: None where there are no results to draw.
        reason: why, empty otherwise.
    """

    place: str
    caption: str
    figure: Figure | None
    reason: str = ""


def replication(result: Replication) -> list[Picture]:
    """Figures 5, 7 and 10 to 13 of the paper and charts of its tables, from the results of a replication.

    Figures 1 to 4 show no results, 6 is another view of 5, and 8 and 9 show measurements of people.

    Args:
        result: of :func:`glossa.studies.replicate`.
    """
    runs, speaker = result.runs, result.speaker
    touching = {name: posture for name, posture in runs.vowels.items() if name in ("i", "u")}
    charts: list[tuple[str, str, Callable[[], Figure]]] = [
        ("Table II", "Muscle forces of the vowels beside Table II.", lambda: force_bars(runs.vowels, paper.forces())),
        (
            "Table II",
            "Shapes of the vowels, from the front and from behind, as in the paper's fig. 7.",
            lambda: surfaces(runs.vowels),
        ),
        (
            "Table II",
            "What touches palate and velum in /i/ and /u/, from above, as in the paper's fig. 10.",
            lambda: contact_map(touching),
        ),
        (
            "Table IV",
            "First two formants of the vowels beside Table IV.",
            lambda: vowel_chart(runs.formants, paper.formants_simulated()),
        ),
        (
            "section III.A.1",
            "Each muscle alone, rest dotted, as in the paper's fig. 5.",
            lambda: midsagittal_panels(runs.muscles, columns=4),
        ),
        (
            "section III.B",
            "/i/ with the transversalis by reflex, silent, and activated voluntarily.",
            lambda: _of(runs.transversalis, speaker, transversalis),
        ),
        (
            "section IV.B",
            "Scatter of six nodes over the runs of Table VI, as in the paper's fig. 11.",
            lambda: _of(runs.sensitivity, speaker, dispersion),
        ),
        (
            "section IV.C",
            "Formants of /i/ against the command of GGa, beside Table VI.",
            lambda: _of(runs.sensitivity, speaker, lambda study, _: saturation(study)),
        ),
        (
            "section V.A",
            "Shapes after 1 s without commands, as in the paper's figs 12 and 13.",
            lambda: _of(runs.gravity, speaker, gravity_shapes),
        ),
        (
            "section V.B",
            "Force of GGp in movements to vowels, upright and supine.",
            lambda: _of(runs.gravity, speaker, lambda study, _: gravity_forces(study)),
        ),
    ]
    return [_picture(place, caption, draw) for place, caption, draw in charts]


def _of(study: xr.Dataset | None, speaker: Speaker, draw: Callable[[xr.Dataset, Speaker], Figure]) -> Figure:
    if study is None:
        raise InputError("the study failed")
    return draw(study, speaker)


def _picture(place: str, caption: str, draw: Callable[[], Figure]) -> Picture:
    try:
        return Picture(place=place, caption=caption, figure=draw())
    except InputError as error:
        return Picture(place=place, caption=caption, figure=None, reason=str(error))
