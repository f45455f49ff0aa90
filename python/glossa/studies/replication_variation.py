"""Rows of a replication: Table VI and section IV, changes of single commands of /i/."""

from __future__ import annotations

import math

import xarray as xr

from glossa import paper
from glossa.studies.replication_row import Row, in_text, number_row, printed_with_bound, statement_row
from glossa.studies.replication_rules import AGREES
from glossa.studies.replication_runs import VOWEL, Runs
from glossa.studies.sensitivity_summary import JUST_NOTICEABLE, LEAST_CHANGE, sensitivity_summary

MM = 1e3

ROUND = 0.5
"""Minor over major axis above which an ellipse has no clear direction: the paper's own lie at 0.6 and more where it
says so, at 0.5 and less elsewhere.
"""


def table_6(runs: Runs) -> list[Row]:
    """Changes of F1 to F3 by changes of one command, Hz: the paper's are its Table VI minus its Table IV."""
    own = paper.formants_simulated()
    rows = []
    for printed in paper.rows("table6_sensitivity_i.csv"):
        muscle, change = printed["muscle"], float(printed["change_percent"])
        found, note = _changes(runs, muscle, change)
        for number, ours in enumerate(found, start=1):
            value = printed[f"F{number}_Hz"]
            rows.append(
                number_row(
                    "Table VI",
                    f"{muscle} {change:+g} %",
                    f"change of F{number}",
                    "Hz",
                    paper=float(value) - float(own[f"F{number}_Hz"][VOWEL]),
                    ours=ours,
                    rule="formant change",
                    printed=value,
                    note=note,
                )
            )
    return rows


def _changes(runs: Runs, muscle: str, change: float) -> tuple[list[float], str]:
    """Changes of F1 to F3 against the vowel, Hz, and why they are NaN."""
    study = runs.sensitivity
    if study is None:
        return [math.nan] * 3, runs.reasons.get("sensitivity", "")
    run = study.sel(muscle=muscle, change=change)
    moved = (run["formants"] - study["vowel_formants"]).sel(formant=[1, 2, 3])
    return [float(value) for value in moved], str(run["reason"].item())


def _summary(runs: Runs) -> xr.Dataset | None:
    return None if runs.sensitivity is None else sensitivity_summary(runs.sensitivity)


def dispersion_rows(runs: Runs) -> list[Row]:
    """Section IV.B: ellipses of six nodes (whole axes, mm; degrees), and what it tells of single muscles."""
    place, note = "section IV.B", runs.reasons.get("sensitivity", "")
    summary = _summary(runs)
    rows = []
    for printed in paper.rows("section4_dispersion.csv"):
        node = printed["node"]
        item = node.replace("_", " ")
        ours = dict.fromkeys(("major", "minor", "angle"), math.nan)
        if summary is not None:
            ours = {name: float(summary[name].sel(panel="all", node=node)) for name in ours}
        for name in ("major", "minor"):
            theirs, words = float(printed[f"{name}_mm"]), f"{name} axis"
            rows.append(
                number_row(place, item, words, "mm", paper=theirs, ours=ours[name], rule="ellipse axis", note=note)
            )
        if printed["angle_deg"]:
            theirs, words = float(printed["angle_deg"]), "angle to the antero-posterior axis"
            rows.append(number_row(place, item, words, "°", paper=theirs, ours=ours["angle"], rule="angle", note=note))
        else:
            ratio, words = ours["minor"] / ours["major"], "minor over major axis"
            rows.append(
                statement_row(
                    place, item, words, "1", printed="no clear direction", ours=ratio, right=ratio > ROUND, note=note
                )
            )
    return [*rows, *_vertical_spans(runs, place, note)]


def _vertical_spans(runs: Runs, place: str, note: str) -> list[Row]:
    rows = []
    for claim in in_text(place):
        ours = math.nan
        if runs.sensitivity is not None:
            heights = runs.sensitivity["nodes"].sel(muscle=claim["muscle"], axis="z")
            heights = heights.sel(node=["upper_pharyngeal", "pharyngeal"])
            ours = MM * float((heights.max("change") - heights.min("change")).max())
        rows.append(
            number_row(
                place,
                claim["muscle"],
                "vertical span of a pharyngeal node",
                claim["unit"],
                paper=float(claim["value"]),
                ours=ours,
                rule="displacement",
                printed=printed_with_bound(claim["bound"], claim["value"]),
                note=note,
            )
        )
    return rows


def saturation_rows(runs: Runs) -> list[Row]:
    """Section IV.C: spans of the formants over all runs, Hz, and whether F1 follows GGa."""
    place, note = "section IV.C", runs.reasons.get("sensitivity", "")
    summary = _summary(runs)
    rows = []
    for number, claim in enumerate(in_text(place), start=1):
        rows.append(
            number_row(
                place,
                "all runs",
                f"span of F{number}",
                claim["unit"],
                paper=float(claim["value"]),
                ours=math.nan if summary is None else float(summary["range"].sel(formant=number)),
                rule="span",
                printed=printed_with_bound(claim["bound"], claim["value"]),
                note=note,
            )
        )
    rows.append(
        statement_row(
            place,
            "GGa",
            "span of F1",
            "Hz",
            printed="no saturation effect",
            ours=math.nan if summary is None else float(summary["saturation_range"]),
            right=summary is not None and bool(summary["saturation_refuted"]),
            note=note or f"right where GGa alone changes F1 by more than {100.0 * JUST_NOTICEABLE:g} %",
        )
    )
    return rows


def variation_remarks(runs: Runs) -> dict[str, str]:
    """What no single row says, by place."""
    summary = _summary(runs)
    if summary is None or runs.sensitivity is None:
        return {}
    again = int((runs.sensitivity["started"] == "rest").sum())
    rows = [row for row in table_6(runs) if abs(row.paper) >= LEAST_CHANGE]
    words = []
    for n in (1, 2, 3):
        signs = [row.verdict == AGREES for row in rows if row.measure.endswith(f"F{n}")]
        words.append(f"F{n} {float(summary['correlation'].sel(formant=n)):.2f}, {sum(signs)} of {len(signs)}")
    return {
        "Table VI": f"{int(summary['runs'])} runs, {int(summary['failed'])} failed; {again} that failed from the "
        "vowel's posture were solved from rest. Correlation of our changes with the paper's, and same signs where its "
        f"change is {LEAST_CHANGE:g} Hz or more: {'; '.join(words)}.",
        "section IV.B": "Whole axes of 3σ ellipses; the paper does not say whether its own are whole or half axes.",
    }
