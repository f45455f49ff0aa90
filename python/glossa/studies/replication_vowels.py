"""Rows of a replication: Tables II and IV and section III."""

from __future__ import annotations

import math
from collections.abc import Mapping

from glossa import paper
from glossa.studies.replication_row import Row, number_row, printed_with_bound, statement_row
from glossa.studies.replication_runs import VOWEL, Runs, four

MM = 1e3


def table_2(runs: Runs) -> list[Row]:
    """Forces of the vowels, N."""
    rows = []
    for printed in paper.rows("table2_forces.csv"):
        vowel = printed["vowel"]
        posture = runs.vowels.get(vowel)
        note = runs.reasons.get(f"vowels {vowel}", "")
        rows += [
            number_row(
                "Table II",
                f"/{vowel}/",
                muscle,
                "N",
                paper=float(force),
                ours=math.nan if posture is None else float(posture.forces[muscle]),
                rule="force",
                printed=force,
                note=note,
            )
            for muscle, force in printed.items()
            if muscle != "vowel"
        ]
    return rows


def table_4(runs: Runs) -> list[Row]:
    """Formants of the vowels, Hz."""
    rows = []
    for printed in paper.rows("table4_formants_simulated.csv"):
        vowel = printed["vowel"]
        note = runs.reasons.get(f"formants {vowel}") or runs.reasons.get(f"vowels {vowel}", "")
        for number, ours in enumerate(four(runs.formants.get(vowel)).tolist(), start=1):
            value = float(printed[f"F{number}_Hz"])
            rows.append(
                number_row(
                    "Table IV", f"/{vowel}/", f"F{number}", "Hz", paper=value, ours=ours, rule="formant", note=note
                )
            )
    return rows


def single_muscle_rows(runs: Runs) -> list[Row]:
    """Section III.A.1: what each muscle does alone, mm."""
    return [_effect(runs, number, claim) for number, claim in enumerate(paper.rows("section3_single_muscles.csv"))]


def _effect(runs: Runs, number: int, claim: Mapping[str, str]) -> Row:
    found = None if runs.effects is None else runs.effects.iloc[number]
    ours = math.nan if found is None else float(found["ours_mm"])
    right = found is not None and bool(found["right"])
    note = runs.reasons.get("effects", "")
    place, muscle, direction, bound = "section III.A.1", claim["muscle"], claim["direction"], claim["bound"]
    measure = f"{claim['region'].replace('_', ' ')} {direction}"
    if not claim["displacement_mm"]:
        return statement_row(place, muscle, measure, "mm", printed=direction, ours=ours, right=right, note=note)
    return number_row(
        place,
        muscle,
        measure,
        "mm",
        paper=float(claim["displacement_mm"]),
        ours=ours,
        rule="displacement below" if bound == "below" else "displacement",
        printed=printed_with_bound(bound, claim["displacement_mm"]),
        note=note,
        right=right,
    )


_QUANTITIES = {
    "width": ("stretch", 1.0, "1", "mean width over that at rest"),
    "midsagittal_deformation": ("midsagittal_deformation", MM, "mm", "displacement of six midsagittal nodes, rms"),
}


def transversalis_rows(runs: Runs) -> list[Row]:
    """Section III.B: what the transversalis does in /i/, as differences between conditions."""
    rows = []
    for claim in paper.rows("section3_transversalis.csv"):
        name, factor, unit, words = _QUANTITIES[claim["quantity"]]
        first, second, sign = claim["first"], claim["second"], int(claim["sign"])
        ours, note = math.nan, runs.reasons.get("transversalis", "")
        if runs.transversalis is not None:
            one, other = (runs.transversalis.sel(condition=condition) for condition in (first, second))
            ours = factor * float(one[name] - other[name])
            # a reason beside a number is one of the formants, which do not count here
            reasons = (str(each["reason"].item()) for each in (one, other) if not bool(each["converged"]))
            note = "; ".join(dict.fromkeys(reasons))
        rows.append(
            statement_row(
                "section III.B",
                f"/{VOWEL}/, {first} against {second}",
                words,
                unit,
                printed="more" if sign > 0 else "less",
                ours=ours,
                right=ours * sign > 0.0,
                note=note,
            )
        )
    return rows
