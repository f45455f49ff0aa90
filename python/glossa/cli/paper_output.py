"""What ``glossa gravity``, ``transversalis`` and ``delay`` print, the paper's numbers beside ours."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console

from glossa import paper
from glossa.anatomy.arrays import FloatArray
from glossa.cli.output import number
from glossa.cli.study_tables import MM, beside, cell, numbers, print_title, table_of
from glossa.studies.gravity import DIRECTIONS, FORCES

# Gravity


def print_gravity(study: xr.Dataset) -> None:
    """Displacements of the tip beside section V.A, forces of GGp beside section V.B."""
    console = Console()
    print_title(console, study, "gravity")
    console.print("Tip without commands, mm from rest: x backward, z upward; after the movement", highlight=False)
    shown = table_of("", "x", "z", "distance", "in equilibrium", "paper")
    for control in study["control"].values.tolist():
        for direction in DIRECTIONS:
            one = study.sel(control=control, gravity=direction)
            x, z = (float(one["final_tip"].sel(axis=axis)) * MM for axis in ("x", "z"))
            length = {how: _length(one[f"{how}_tip"].to_numpy()) * MM for how in ("final", "static")}
            shown.add_row(
                f"{control}, {direction}",
                *(cell(value, 2, "+") for value in (x, z)),
                cell(length["final"]),
                cell(length["static"]),
                _told_by_paper(control, direction),
            )
    console.print(shown)
    console.print(
        f"Vowels in movements of {study.attrs['vowel_until_s'] * MM:g} ms, supine against upright: force of GGp at its "
        "peak, at the end (and its range in the last 50 ms upright), and in equilibrium, here / paper; largest "
        "displacement of a node; formants, Hz",
        highlight=False,
    )
    shown = table_of("", "peak, %", "end, %", "swing, N", "static, %", "nodes, mm", "F1 F2 F3")
    for vowel in study["vowel"].values.tolist():
        one = study.sel(vowel=vowel)
        theirs = _paper_value(vowel, "supine")
        peak, final, static = (float(one[f"{which}_change"].sel(acting="GGp")) for which in FORCES)
        shown.add_row(
            f"/{vowel}/",
            beside(peak, theirs),
            beside(final, theirs),
            cell(float(one["force_swing"].sel(acting="GGp", position="upright"))),
            beside(static, theirs),
            cell(float(one["node_change"].max()) * MM),
            " ".join(cell(float(value), 0, "+") for value in one["formant_change"].to_numpy()[:3]),
        )
    console.print(shown)
    reasons = [study[name].values.ravel().tolist() for name in ("static_reason", "final_reason", "vowel_reason")]
    for reason in dict.fromkeys(reason for several in reasons for reason in several if reason):
        console.print(f"note: {reason}", style="dim", highlight=False)


def _paper_value(control: str, direction: str) -> float:
    table = paper.gravity()
    row = table[(table["control"] == control) & (table["gravity"] == direction)]
    return float(row["value"].iloc[0]) if len(row) else math.nan


def _told_by_paper(control: str, direction: str) -> str:
    table = paper.gravity()
    row = table[(table["control"] == control) & (table["gravity"] == direction)]
    if not len(row):
        return ""
    backward = ", backward" if str(row["quantity"].iloc[0]).endswith("backward") else ""
    return f"{float(row['value'].iloc[0]):g}{backward}"


def _length(vector: FloatArray) -> float:
    return float(np.sqrt((vector**2).sum()))


def gravity_json(study: xr.Dataset) -> dict[str, Any]:
    """Tip displacements by control and gravity; forces, nodes and formants of vowels; null where there is no number."""
    controls: dict[str, Any] = {}
    for control in study["control"].values.tolist():
        controls[control] = {}
        for direction in DIRECTIONS:
            one = study.sel(control=control, gravity=direction)
            controls[control][direction] = {
                "final_tip_mm": numbers(one["final_tip"].sel(axis=["x", "z"]) * MM),
                "static_tip_mm": numbers(one["static_tip"].sel(axis=["x", "z"]) * MM),
                "paper_mm": number(_paper_value(control, direction)),
                "reason": str(one["final_reason"].item() or one["static_reason"].item()),
            }
    acting = study["acting"].values.tolist()
    vowels: dict[str, Any] = {}
    for vowel in study["vowel"].values.tolist():
        one = study.sel(vowel=vowel)
        vowels[vowel] = {
            "paper_GGp_change_percent": number(_paper_value(vowel, "supine")),
            **{
                f"{which}_change_percent": dict(zip(acting, numbers(one[f"{which}_change"]), strict=True))
                for which in FORCES
            },
            "node_change_mm": dict(zip(study["node"].values.tolist(), numbers(one["node_change"] * MM), strict=True)),
            "formant_change_Hz": numbers(one["formant_change"], 3),
            "by_position": {
                position: {
                    **{
                        f"{which}_force_N": dict(
                            zip(acting, numbers(one[f"{which}_force"].sel(position=position), 9), strict=True)
                        )
                        for which in FORCES
                    },
                    "formants_Hz": numbers(one["final_formants"].sel(position=position), 3),
                    "reason": str(one["vowel_reason"].sel(position=position).item()),
                }
                for position in study["position"].values.tolist()
            },
        }
    facts = {"speaker": study.attrs["speaker"], "until_s": float(study["time"][-1])}
    return {**facts, "without_commands": controls, "vowels": vowels}


# Transversalis


def print_transversalis(study: xr.Dataset) -> None:
    """Width, midsagittal section, forces and formants in each condition."""
    console = Console()
    print_title(console, study, f"the transversalis in /{study.attrs['vowel']}/")
    conditions = study["condition"].values.tolist()
    shown = table_of("", *conditions)

    def row(words: str, values: Any, digits: int = 2) -> None:
        shown.add_row(words, *(cell(float(value), digits) for value in values))

    row("force of Trans, N", study["forces"].sel(muscle="Trans"))
    row("mean width over that at rest", study["stretch"], 3)
    row("widest growth of width, mm", study["widening"] * MM)
    row("midsagittal area over that at rest", study["midsagittal_area"], 3)
    row("displacement of six nodes, rms, mm", study["midsagittal_deformation"] * MM)
    row("palatal node upward, mm", study["displacement"].sel(node="palatal", axis="z") * MM)
    for formant in (1, 2, 3):
        row(f"F{formant}, Hz", study["formants"].sel(formant=formant), 0)
    console.print(shown)
    for first, second, quantity, sign in paper.transversalis().itertuples(index=False):
        found = _difference(study, first, second, quantity)
        words = "not known" if not math.isfinite(found) else "here, too" if found * sign > 0.0 else "not here"
        told = "more" if sign > 0 else "less"
        console.print(f"paper: {told} {quantity.replace('_', ' ')} {first} than {second}: {words}", highlight=False)
    for reason in dict.fromkeys(reason for reason in study["reason"].values.tolist() if reason):
        console.print(f"note: {reason}", style="dim", highlight=False)


_QUANTITIES = {"width": "stretch", "midsagittal_deformation": "midsagittal_deformation"}


def _difference(study: xr.Dataset, first: str, second: str, quantity: str) -> float:
    values = study[_QUANTITIES[quantity]]
    return float(values.sel(condition=first) - values.sel(condition=second))


def transversalis_json(study: xr.Dataset) -> dict[str, Any]:
    """By condition; and the paper's statements with what is found here, null where it is not known."""
    conditions = {}
    for condition in study["condition"].values.tolist():
        one = study.sel(condition=condition)
        moved = one["displacement"].sel(axis=["x", "z"]).to_numpy() * MM
        conditions[condition] = {
            "converged": bool(one["converged"]),
            "reason": str(one["reason"].item()),
            "stretch": number(float(one["stretch"])),
            "widening_mm": number(float(one["widening"]) * MM, 6),
            "midsagittal_area": number(float(one["midsagittal_area"])),
            "midsagittal_deformation_mm": number(float(one["midsagittal_deformation"]) * MM, 6),
            "displacement_mm": dict(zip(study["node"].values.tolist(), numbers(moved), strict=True)),
            "forces_N": dict(zip(study["muscle"].values.tolist(), numbers(one["forces"], 9), strict=True)),
            "formants_Hz": numbers(one["formants"], 3),
        }
    claims = []
    for first, second, quantity, sign in paper.transversalis().itertuples(index=False):
        found = _difference(study, first, second, quantity)
        agrees = found * sign > 0.0 if math.isfinite(found) else None
        claims.append({"first": first, "second": second, "quantity": quantity, "sign": int(sign), "agrees": agrees})
    facts = {name: study.attrs[name] for name in ("speaker", "vowel", "voluntary")}
    return {**facts, "conditions": conditions, "paper": claims}


# Delay


def print_delay(study: xr.Dataset) -> None:
    """Peak speeds, changes of the paths and forces for each delay."""
    console = Console()
    own = study.attrs["reference_delay_s"] * MM
    print_title(console, study, f"movement to /{study.attrs['vowel']}/ by delay of the reflex")
    console.print(
        "Peak speeds of the tip and of the fastest of six nodes, mm/s; largest distance of a node from its path with "
        f"{own:g} ms; how far one still moves in the last 50 ms; peak forces",
        highlight=False,
    )
    strongest = study["peak_force"].max("delay").to_series().sort_values(ascending=False).index[:3].tolist()
    shown = table_of(
        "delay",
        "tip, mm/s",
        "fastest",
        "path, mm",
        "swing, mm",
        *(f"{muscle}, N" for muscle in strongest),
    )
    for value in study["delay"].values.tolist():
        one = study.sel(delay=value)
        shown.add_row(
            f"{value * MM:g} ms",
            cell(float(one["peak_speed"].sel(node="apical")) * MM, 0),
            cell(float(one["peak_speed"].max()) * MM, 0),
            cell(float(one["path_change"].max()) * MM),
            cell(float(one["swing"].max()) * MM),
            *(cell(float(one["peak_force"].sel(muscle=muscle))) for muscle in strongest),
        )
    console.print(shown)
    for reason in dict.fromkeys(reason for reason in study["reason"].values.tolist() if reason):
        console.print(f"note: {reason}", style="dim", highlight=False)


def delay_json(study: xr.Dataset) -> dict[str, Any]:
    """By delay; traces of the six nodes (x, z) over time."""
    nodes, muscles = study["node"].values.tolist(), study["muscle"].values.tolist()
    runs = []
    for value in study["delay"].values.tolist():
        one = study.sel(delay=value)
        traces = (one["trace"].sel(axis=["x", "z"]) * MM).transpose("node", "time", "axis")
        runs.append(
            {
                "delay_s": value,
                "reason": str(one["reason"].item()),
                "peak_speed_mm_per_s": dict(zip(nodes, numbers(one["peak_speed"] * MM, 3), strict=True)),
                "path_change_mm": dict(zip(nodes, numbers(one["path_change"] * MM), strict=True)),
                "swing_mm": dict(zip(nodes, numbers(one["swing"] * MM), strict=True)),
                "peak_force_N": dict(zip(muscles, numbers(one["peak_force"]), strict=True)),
                "final_force_N": dict(zip(muscles, numbers(one["final_force"]), strict=True)),
                "displacement_mm": dict(zip(nodes, numbers(traces, 4), strict=True)),
            }
        )
    facts = {name: study.attrs[name] for name in ("speaker", "vowel", "reference_delay_s")}
    return {**facts, "times_s": numbers(study["time"]), "runs": runs}
