"""What ``glossa sensitivity`` prints, the paper's numbers beside ours."""

from __future__ import annotations

from typing import Any

import xarray as xr
from rich.console import Console
from rich.table import Table

from glossa.cli.output import number
from glossa.cli.study_tables import MM, beside, cell, numbers, print_title, table_of


def print_sensitivity(study: xr.Dataset, summary: xr.Dataset) -> None:
    """Formants of every run, ranges, agreement with Table VI, ellipses beside section IV.B."""
    console = Console()
    vowel, runs, failed = study.attrs["vowel"], int(summary["runs"]), int(summary["failed"])
    seconds = float(study["seconds"].sum())
    print_title(console, study, f"/{vowel}/, {runs} runs, {failed} failed, {seconds:.1f} s of computing")
    console.print("Change of formants against the vowel, Hz, by change of the command (%)", highlight=False)
    changes = study["change"].values.tolist()
    shown = table_of("", "", *(f"{change:+g}" for change in changes))
    moved = (study["formants"] - study["vowel_formants"]).to_numpy()[..., :3]
    asked, reasons = study["asked"].to_numpy(), study["reason"].to_numpy()
    for row, muscle in enumerate(study["muscle"].values.tolist()):
        for formant in range(3):
            pairs = zip(moved[row, :, formant].tolist(), asked[row].tolist(), strict=True)
            cells = [cell(value, 0, "+") if wanted else "" for value, wanted in pairs]
            shown.add_row("" if formant else muscle, f"F{formant + 1}", *cells, end_section=formant == 2)
    console.print(shown)
    console.print("Over all runs: here / paper; signs of changes that are 5 Hz or more in the paper", highlight=False)
    shown = table_of("", "range, Hz", "correlation", "slope", "rms, Hz", "same sign")
    for formant in summary["formant"].values.tolist():
        one = summary.sel(formant=formant)
        signs = f"{int(one['same_sign'])} of {int(one['large'])}" if int(one["large"]) else "-"
        measures = (cell(float(one[name]), digits) for name, digits in (("correlation", 2), ("slope", 2), ("rms", 0)))
        shown.add_row(f"F{formant}", beside(float(one["range"]), float(one["paper_range"]), 0), *measures, signs)
    console.print(shown)
    console.print(
        f"{summary.attrs['sigmas']:g}σ ellipses of six nodes, mm: here / paper (section IV.B); they hold "
        f"{100 * float(summary['coverage']):.1f} % of a normal law in two dimensions",
        highlight=False,
    )
    console.print(_ellipse_table(summary))
    if "GGa" in study["muscle"]:
        console.print(_saturation_words(summary), highlight=False)
    for reason in dict.fromkeys(reasons[reasons != ""].tolist()):
        console.print(f"note: {reason}", style="dim", highlight=False)


def _ellipse_table(summary: xr.Dataset) -> Table:
    shown = table_of("", "major axis", "minor axis", "angle, °", "inside, %")
    for node in summary["node"].values.tolist():
        one = summary.sel(panel="all", node=node)
        shown.add_row(
            node,
            *(beside(float(one[name]), float(one[f"paper_{name}"])) for name in ("major", "minor")),
            beside(float(one["angle"]), float(one["paper_angle"]), 0),
            cell(100.0 * float(one["inside"]), 0),
        )
    return shown


def _saturation_words(summary: xr.Dataset) -> str:
    verdict = "refuted" if bool(summary["saturation_refuted"]) else "not refuted"
    course = "rises" if bool(summary["saturation_monotone"]) else "does not rise"
    span = beside(float(summary["saturation_range"]), float(summary["paper_saturation_range"]), 0)
    return f"Saturation by GGa: {verdict}; F1 spans {span} Hz and {course} steadily as the muscle grows stronger"


def sensitivity_json(study: xr.Dataset, summary: xr.Dataset) -> dict[str, Any]:
    """Runs, ranges, agreement and ellipses; null where there is no number."""
    rows = []
    for muscle in study["muscle"].values.tolist():
        for change in study["change"].values.tolist():
            run = study.sel(muscle=muscle, change=change)
            if bool(run["asked"]):
                rows.append(_run_json(run, muscle, change, study))
    by_formant = ("range", "paper_range", "correlation", "slope", "rms")
    counts = ("compared", "large", "same_sign")
    return {
        "speaker": study.attrs["speaker"],
        "vowel": study.attrs["vowel"],
        "converged": bool(study["converged"].to_numpy()[study["asked"].to_numpy()].all()),
        "failed": int(summary["failed"]),
        "vowel_formants_Hz": numbers(study["vowel_formants"], 3),
        "runs": rows,
        "formants": {
            f"F{n}": {name: number(float(summary[name].sel(formant=n)), 6) for name in by_formant}
            | {name: int(summary[name].sel(formant=n)) for name in counts}
            for n in summary["formant"].values.tolist()
        },
        "sigmas": summary.attrs["sigmas"],
        "coverage": number(float(summary["coverage"]), 6),
        "ellipses": {
            panel: {
                node: _ellipse_json(summary.sel(panel=panel, node=node)) for node in summary["node"].values.tolist()
            }
            for panel in summary["panel"].values.tolist()
        },
        "saturation": {
            "F1_range_Hz": number(float(summary["saturation_range"]), 3),
            "paper_F1_range_Hz": number(float(summary["paper_saturation_range"]), 3),
            "monotone": bool(summary["saturation_monotone"]),
            "refuted": bool(summary["saturation_refuted"]),
        },
    }


def _run_json(run: xr.Dataset, muscle: str, change: float, study: xr.Dataset) -> dict[str, Any]:
    moved = run["displacement"].sel(axis=["x", "z"]).to_numpy() * MM
    acting = study["acting"].values.tolist()
    return {
        "muscle": muscle,
        "change_percent": change,
        "converged": bool(run["converged"]),
        "reason": str(run["reason"].item()),
        "started_from": str(run["started"].item()),
        "formants_Hz": numbers(run["formants"], 3),
        "displacement_mm": dict(zip(study["node"].values.tolist(), numbers(moved), strict=True)),
        "forces_N": dict(zip(acting, numbers(run["forces"], 9), strict=True)),
        "iterations": int(run["iterations"]),
        "seconds": number(float(run["seconds"]), 6),
    }


def _ellipse_json(one: xr.Dataset) -> dict[str, Any]:
    names = {"major": "major_mm", "minor": "minor_mm", "angle": "angle_degrees", "inside": "inside"}
    theirs = {f"paper_{name}": f"paper_{key}" for name, key in names.items() if name != "inside"}
    shown = names if one["panel"].item() != "all" else names | theirs
    return {
        "centre_mm": numbers(one["centre"]),
        **{key: number(float(one[name]), 6) for name, key in shown.items()},
        "samples": int(one["samples"]),
    }
