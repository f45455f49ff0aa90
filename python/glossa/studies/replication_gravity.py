"""Rows of a replication: section V, gravity."""

from __future__ import annotations

import math

import numpy as np

from glossa import paper
from glossa.studies.gravity import CARDINALS, LEAST_FORCE
from glossa.studies.replication_row import Row, in_text, number_row, printed_with_bound, statement_row
from glossa.studies.replication_runs import Runs
from glossa.studies.sensitivity_summary import JUST_NOTICEABLE

MM = 1e3

_TIP = {"tip_displacement": "tip, distance from rest", "tip_displacement_backward": "tip backward"}
_FORCE = "GGp_force_change"


def rest_rows(runs: Runs) -> list[Row]:
    """Section V.A: displacements of the tip after the movement without commands, mm."""
    place = "section V.A"
    rows = []
    for claim in paper.rows("section5_gravity.csv"):
        if claim["quantity"] not in _TIP:
            continue
        control, direction = claim["control"], claim["gravity"]
        x, z, note = _tip(runs, control, direction)
        rows.append(
            number_row(
                place,
                f"{control}, {direction}",
                _TIP[claim["quantity"]],
                claim["unit"],
                paper=float(claim["value"]),
                ours=x if claim["quantity"] == "tip_displacement_backward" else math.hypot(x, z),
                rule="displacement",
                printed=printed_with_bound(claim["bound"], claim["value"]),
                note=note,
            )
        )
    _, up, no_fall = _tip(runs, "silent", "upright")
    back, rise, no_silent = _tip(runs, "silent", "supine")
    *held, no_reflex = _tip(runs, "reflex", "supine")
    difference = math.hypot(*held) - math.hypot(back, rise)
    words = "tip, distance from rest, reflex minus silent"
    return [
        *rows,
        _direction("silent, upright", "tip upward", "lowered", up, up < 0.0, no_fall),
        _direction("silent, supine", "tip backward", "backward", back, back > 0.0, no_silent),
        _direction("supine", words, "less by reflex", difference, difference < 0.0, no_silent or no_reflex),
    ]


def _direction(item: str, measure: str, printed: str, ours: float, right: bool, note: str) -> Row:
    return statement_row("section V.A", item, measure, "mm", printed=printed, ours=ours, right=right, note=note)


def _tip(runs: Runs, control: str, direction: str) -> tuple[float, float, str]:
    """Backward and upward displacement of the tip, mm, and why they are NaN."""
    if runs.gravity is None:
        return math.nan, math.nan, runs.reasons.get("gravity", "")
    one = runs.gravity.sel(control=control, gravity=direction)
    x, z = (MM * float(one["final_tip"].sel(axis=axis)) for axis in ("x", "z"))
    return x, z, str(one["final_reason"].item())


def supine_rows(runs: Runs) -> list[Row]:
    """Section V.B: forces of GGp in movements, supine against upright, %; formants; weight of the tongue."""
    place = "section V.B"
    rows = []
    for claim in paper.rows("section5_gravity.csv"):
        if claim["quantity"] != _FORCE:
            continue
        for which in ("peak", "final"):
            ours, note = _of_ggp(runs, claim["control"], f"{which}_change")
            rows.append(
                number_row(
                    place,
                    f"/{claim['control']}/, supine against upright",
                    f"{which} force of GGp",
                    claim["unit"],
                    paper=float(claim["value"]),
                    ours=ours,
                    rule="force change",
                    printed=printed_with_bound(claim["bound"], f"+{claim['value']}"),
                    note=note,
                )
            )
    rows += [_formants(runs, place, vowel) for vowel in CARDINALS]
    for claim in in_text(place):
        rows.append(
            number_row(
                place,
                "tongue",
                "weight",
                claim["unit"],
                paper=float(claim["value"]),
                ours=runs.weight,
                rule="order",
                printed=printed_with_bound(claim["bound"], claim["value"]),
            )
        )
    return rows


def _of_ggp(runs: Runs, vowel: str, quantity: str) -> tuple[float, str]:
    """A number of GGp in a vowel, and why it is NaN."""
    if runs.gravity is None:
        return math.nan, runs.reasons.get("gravity", "")
    value = float(runs.gravity[quantity].sel(vowel=vowel, acting="GGp"))
    if math.isfinite(value):
        return value, ""
    return value, _reason(runs, vowel) or f"GGp pulls with less than {LEAST_FORCE:g} N upright"


def _reason(runs: Runs, vowel: str) -> str:
    """Why movements to a vowel, or their formants, have no numbers."""
    if runs.gravity is None:
        return runs.reasons.get("gravity", "")
    reasons = runs.gravity["vowel_reason"].sel(vowel=vowel).values.tolist()
    return "; ".join(dict.fromkeys(str(reason) for reason in reasons if reason))


def _formants(runs: Runs, place: str, vowel: str) -> Row:
    ours, note = math.nan, _reason(runs, vowel)
    if runs.gravity is not None:
        one = runs.gravity.sel(vowel=vowel)
        shares = one["formant_change"] / one["final_formants"].sel(position="upright")
        ours = 100.0 * float(np.abs(shares.to_numpy()[:3]).max())
    return statement_row(
        place,
        f"/{vowel}/, supine against upright",
        "largest change of F1 to F3",
        "%",
        printed="negligible",
        ours=ours,
        right=ours < 100.0 * JUST_NOTICEABLE,
        note=note or f"right below {100.0 * JUST_NOTICEABLE:g} %",
    )


def gravity_remarks(runs: Runs) -> dict[str, str]:
    """What no single row says, by place."""
    if runs.gravity is None:
        return {}
    swing = runs.gravity["force_swing"].sel(acting="GGp", position="upright")
    swings = {vowel: float(swing.sel(vowel=vowel)) for vowel in swing["vowel"].values.tolist()}
    words = [f"/{vowel}/ {value:.2f} N" for vowel, value in swings.items() if math.isfinite(value)]
    if not words:
        return {}
    return {"section V.B": f"In the last 50 ms of the movements, upright, GGp varies by: {', '.join(words)}."}
