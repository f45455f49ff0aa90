"""What ``glossa stability`` prints: a table for each posture and gradient, or JSON."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr
from rich.console import Console

from glossa.cli.study_tables import MM, cell, numbers, print_title, table_of
from glossa.figures.style import title_of

_ROOT = ("growth", "frequency", "linear_range")


def print_stability(study: xr.Dataset) -> None:
    """Rightmost root at every delay and velocity gain, and the border."""
    console = Console()
    print_title(console, study, "rightmost root of the delayed reflex loop")
    console.print(
        "Growth in 1/s above frequency in Hz, by velocity gain (rows, ms) and delay (columns, ms); last: delay up to "
        "which nothing grows",
        highlight=False,
    )
    for name in study["posture"].to_numpy().tolist():
        for c in study["firing_gradient"].to_numpy().tolist():
            one = study.sel(posture=name, firing_gradient=c)
            console.print(f"{title_of(name)}, c = {c:g} per m", style="bold", highlight=False)
            if str(one["reason"].item()):
                console.print(f"note: {one['reason'].item()}", style="dim", highlight=False)
                continue
            _print_chart(console, one)
            _print_own(console, one, study)


def _print_chart(console: Console, one: xr.Dataset) -> None:
    delays = one["delay"].to_numpy().tolist()
    shown = table_of("µ, ms", *(f"{MM * value:g}" for value in delays), "last")
    border = one["border_delay"].to_series()
    for gain in one["velocity_gain"].to_numpy().tolist():
        row = one.sel(velocity_gain=gain).isel(root=0)
        nearest = float(border.iloc[abs(border.index.to_numpy() - gain).argmin()])
        cells = [_cell(row.sel(delay=value)) for value in delays]
        shown.add_row(f"{MM * gain:g}", *cells, "never" if math.isinf(nearest) else cell(MM * nearest, 1))
    console.print(shown, highlight=False)


def _print_own(console: Console, one: xr.Dataset, study: xr.Dataset) -> None:
    """What drives the root at the scene's own reflex, or near it, where it grows."""
    wanted = {"delay": study.attrs["delay_s"], "velocity_gain": study.attrs["velocity_gain_s"]}
    here = one.sel(wanted, method="nearest").isel(root=0)
    own = {name: float(here[name]) for name in wanted}
    if float(here["growth"]) > 0.0:
        reflex = " and ".join(f"{MM * value:g} ms" for value in own.values())
        console.print(
            f"{float(here['growth']):+.1f} per s at {float(here['frequency']):.1f} Hz, with {reflex}, is driven by "
            f"{here['muscle'].item()} up to a motion of {cell(MM * float(here['linear_range']), 3)} mm, where its "
            "first fibre falls silent",
            highlight=False,
            soft_wrap=True,
        )


def _cell(root: xr.Dataset) -> str:
    growth = float(root["growth"])
    return f"{growth:+.1f}\n{float(root['frequency']):.0f}" if math.isfinite(growth) else "-"


def stability_json(study: xr.Dataset) -> dict[str, Any]:
    """By posture and gradient: border, and roots of every delay and velocity gain."""
    charts = []
    for name in study["posture"].to_numpy().tolist():
        for c in study["firing_gradient"].to_numpy().tolist():
            one = study.sel(posture=name, firing_gradient=c)
            charts.append(
                {
                    "posture": name,
                    "firing_gradient_per_m": c,
                    "reason": str(one["reason"].item()),
                    "border": [
                        {"velocity_gain_s": gain, "delay_s": delay}
                        for gain, delay in zip(numbers(one["border_gain"]), numbers(one["border_delay"]), strict=True)
                    ],
                    "points": _points(one),
                }
            )
    facts = {name: study.attrs[name] for name in ("speaker", "effects", "delay_s", "velocity_gain_s")}
    return {**facts, "charts": charts}


def _points(one: xr.Dataset) -> list[dict[str, Any]]:
    points = []
    for gain in one["velocity_gain"].to_numpy().tolist():
        for delay in one["delay"].to_numpy().tolist():
            here = one.sel(velocity_gain=gain, delay=delay)
            growth, frequency, reach = (numbers(here[name], 9) for name in _ROOT)
            roots = [
                {"growth_per_s": g, "frequency_Hz": f, "linear_range_m": r, "muscle": str(muscle)}
                for g, f, r, muscle in zip(growth, frequency, reach, here["muscle"].to_numpy(), strict=True)
                if g is not None
            ]
            counted = float(here["unstable"])
            points.append(
                {
                    "velocity_gain_s": gain,
                    "delay_s": delay,
                    "unstable_roots": int(counted) if math.isfinite(counted) else None,
                    "roots": roots,
                }
            )
    return points
