"""Figure of an accuracy study: errors against seconds, on logarithmic axes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from glossa.figures import style
from glossa.studies.accuracy_choices import KINDS, MESH, SOLVE, STEPS
from glossa.studies.accuracy_summary import check_accuracy, pareto, worst

COLOURS: Mapping[str, str] = MappingProxyType(
    {
        "mesh": style.BLUE,
        "element": style.ORANGE,
        "preset": style.GREEN,
        "residual": style.YELLOW,
        "contact": style.VERMILION,
        "half": style.PURPLE,
        "threads": style.SKY,
        "SDIRK2": style.BLUE,
        "BDF2": style.VERMILION,
        "backward Euler": style.ORANGE,
        "adaptive": style.GREEN,
        "effects": style.REST,
    }
)

MARKERS: Mapping[str, str] = MappingProxyType({"half": "s", "threads": "D", "effects": "x"})

NEAR = 0.06
"""Points nearer than this share of a power of ten in both directions have one label."""

FEW_POWERS = 2.5
"""Of ten, along an axis with three labels for each."""

_TITLES = {"posture": "equilibria", "movement": "movements"}
_WORDS = {
    "contact": "tolerance of contact",
    "residual": "tolerance of the residual",
    "half": "mirrored or full",
    "effects": "an effect left out",
}
_PANELS = (("nodes", 1e3, "error at six nodes (mm)"), ("force", 1.0, "force (N)"), ("formant", 1.0, "formants (Hz)"))
_TIMES = {"wall_seconds": "wall time (s)", "cpu_seconds": "processor time (s)"}
_FRONTS = {MESH: ":", SOLVE: "-", STEPS: "-"}


@style.styled
def accuracy(result: xr.Dataset, cost: str = "wall_seconds") -> Figure:
    """Largest error of each choice against its mean time: mm, N and Hz side by side, equilibria above movements.

    A family of choices has a colour, those that pay a ring and a black line: nothing is both quicker and more exact
    among what is measured against the same (dotted: against the limit of fine meshes). Crosses are no errors: they show
    what leaving an effect out changes. Errors of zero have no place on the axes.

    Args:
        result: of :func:`glossa.studies.accuracy_study`.
        cost: "wall_seconds" or "cpu_seconds".

    Raises:
        InputError: another study, or an unknown cost.
    """
    check_accuracy(result)
    marked = {measure: pareto(result, measure, cost) for measure, _, _ in _PANELS}
    table = worst(result)
    kinds = [kind for kind in KINDS if kind in table["kind"].to_numpy()]
    sheet = style.new_sheet(10.4, 0.5 + 3.4 * len(kinds))
    rows = sheet.subplots(len(kinds), len(_PANELS), squeeze=False)
    for row, kind in zip(rows, kinds, strict=True):
        for axes, (measure, scale, words) in zip(row, _PANELS, strict=True):
            chosen = table["kind"] == kind
            _draw(axes, table.isel(choice=chosen), table[measure][chosen] * scale, cost)
            _draw_front(axes, table, table[measure] * scale, marked[measure] & chosen, cost)
            axes.set_xscale("log")
            axes.set_yscale("log")
            _set_ticks(axes)
            axes.set_xlabel(_TIMES[cost])
            axes.set_ylabel(words)
            axes.grid(visible=True, color=style.FAINT, linewidth=0.3)
        _name_points(row[0], table.isel(choice=table["kind"] == kind), cost)
        row[0].set_title(_TITLES[kind], loc="left")
        row[-1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0)
    return sheet


def _draw(axes: Axes, table: xr.Dataset, errors: xr.DataArray, cost: str) -> None:
    for family in dict.fromkeys(table["family"].to_numpy().tolist()):
        own = (table["family"] == family) & (errors > 0.0) & np.isfinite(table[cost])
        marker = MARKERS.get(family, "o")
        (line,) = axes.plot(
            table[cost][own],
            errors[own],
            marker=marker,
            markersize=4.5,
            color=COLOURS[family],
            linestyle="" if marker != "o" else "-",
            linewidth=1.2,
            label=_WORDS.get(family, family),
        )
        line.set_gid(f"family:{family}")


def _draw_front(axes: Axes, table: xr.Dataset, errors: xr.DataArray, marked: xr.DataArray, cost: str) -> None:
    for against, dashes in _FRONTS.items():
        own = marked & (table["against"] == against) & (errors > 0.0)
        if not bool(own.any()):
            continue
        seconds, size = table[cost][own].to_numpy(), errors[own].to_numpy()
        order = np.lexsort((size, seconds))
        (line,) = axes.plot(
            seconds[order],
            size[order],
            linestyle=dashes,
            color=style.BLACK,
            linewidth=0.9,
            marker="o",
            markersize=8.5,
            markerfacecolor="none",
            label="pays" + (", among meshes" if against == MESH else ""),
            zorder=1.5,
        )
        line.set_gid(f"front:{against}")


def _name_points(axes: Axes, table: xr.Dataset, cost: str) -> None:
    """Labels beside the points; of several at nearly the same place the first."""
    named: list[np.ndarray] = []
    for number in range(table.sizes["choice"]):
        one = table.isel(choice=number)
        place = np.array([float(one[cost]), float(one["nodes"]) * 1e3])
        if not np.isfinite(place).all() or place[1] <= 0.0:
            continue
        if not any((np.abs(np.log10(place / other)) < NEAR).all() for other in named):
            named.append(place)
            x, y = place.tolist()
            label = str(one["label"].item())
            axes.annotate(label, (x, y), xytext=(5, 3), textcoords="offset points", fontsize=6.0, color=style.REST)


def _set_ticks(axes: Axes) -> None:
    """Plain numbers at 1, 2 and 5 of every power of ten; only at 1 where there are many powers."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        few = np.log10(high / low) < FEW_POWERS
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
