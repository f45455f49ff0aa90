"""What ``glossa replicate`` prints: tables for people, JSON for machines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

from glossa.cli.output import number
from glossa.cli.study_tables import cell, table_of
from glossa.studies.replication import Replication
from glossa.studies.replication_rules import AGREES, DIFFERS, FAILED, RIGHT, RULE_WORDS, VERDICTS, WRONG

GRIDS = {"Table II": ("measure", "item"), "Table IV": ("item", "measure"), "Table VI": ("item", "measure")}
"""Places that are printed as grids, and what their rows and columns stand for."""

DIGITS = {"N": 2, "Hz": 0, "mm": 1, "%": 1, "°": 0, "1": 3}
"""Decimals by unit."""

TITLES = {
    "Table II": "forces of the vowels, N",
    "Table IV": "formants of the vowels, Hz",
    "section III.A.1": "single muscles",
    "section III.B": "the transversalis",
    "Table VI": "changes of formants by changes of commands of /i/, Hz",
    "section IV.B": "dispersion of six nodes",
    "section IV.C": "spans of the formants; saturation",
    "section V.A": "gravity without commands",
    "section V.B": "gravity and vowels",
}
"""What each place is about."""

MISSING = (
    "Figures 8 and 9 of the paper show measurements of people (CT of speaker PB; palatograms of American English "
    "vowels, Stone & Lundberg 1996). They are not ours to have; nothing here stands beside them."
)

_LOOKS = {AGREES: "", DIFFERS: "yellow", RIGHT: "", WRONG: "yellow", FAILED: "red"}
_MARKS = {AGREES: "", DIFFERS: " *", RIGHT: "", WRONG: " *", FAILED: " !"}


def shown(row: pd.Series[Any], name: str, sign: bool = False) -> str:
    """A number of a row with the decimals of its unit."""
    return cell(float(row[name]), DIGITS.get(str(row["unit"]), 2), "+" if sign else "")


def is_change(row: pd.Series[Any]) -> bool:
    """Whether a row tells a difference, whose sign is shown."""
    return row["rule"] in ("formant change", "force change")


def print_replication(result: Replication) -> None:
    """A table for each place, and how many rows agree."""
    console = Console()
    totals = totals_by_place(result)
    title = f"{result.provenance['speaker']}: the paper replicated"
    console.print(title, style="bold", highlight=False, soft_wrap=True)
    for place, rows in result.rows.groupby("place", sort=False):
        words = f"{place}: {TITLES[str(place)]}; {_counted(totals[str(place)])}"
        console.print(words, highlight=False, style="bold")
        console.print(_grid(rows, *GRIDS[str(place)]) if place in GRIDS else _list(rows), highlight=False)
        if str(place) in result.remarks:
            console.print(result.remarks[str(place)], style="dim", highlight=False)
        for reason in dict.fromkeys(rows.loc[rows["verdict"] == FAILED, "note"]):
            console.print(f"note: {reason}", style="dim", highlight=False)
    console.print("Here / paper; * differs, or is not as the paper says; ! no number of ours", highlight=False)
    for name in dict.fromkeys(result.rows["rule"]):
        console.print(f"{name}: {RULE_WORDS[name]}", style="dim", highlight=False)
    console.print(_totals(result))
    console.print(MISSING, style="dim", highlight=False)


def totals_by_place(result: Replication) -> dict[str, dict[str, int]]:
    """Rows of each verdict, by place; the last entry is "all"."""
    return {
        str(place): {str(name): int(value) for name, value in row.items()} for place, row in result.totals.iterrows()
    }


def _counted(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{int(counts[name])} {name}" for name in VERDICTS if counts[name])


def _grid(rows: pd.DataFrame, down: str, across: str) -> Table:
    columns = list(dict.fromkeys(rows[across]))
    table = table_of("", *columns)
    for heading, several in rows.groupby(down, sort=False):
        table.add_row(str(heading), *(_cell(several[several[across] == column].iloc[0]) for column in columns))
    return table


def _cell(row: pd.Series[Any]) -> Text:
    verdict, sign = str(row["verdict"]), is_change(row)
    words = f"{shown(row, 'ours', sign)} / {shown(row, 'paper', sign)}{_MARKS[verdict]}"
    return Text(words, style=_LOOKS[verdict])


def _list(rows: pd.DataFrame) -> Table:
    table = Table()
    for heading, justify in (("", "left"), ("", "left"), ("here", "right"), ("paper", "right"), ("", "left")):
        table.add_column(heading, justify="right" if justify == "right" else "left")
    table.add_column("verdict")
    for _, row in rows.iterrows():
        verdict = str(row["verdict"])
        table.add_row(
            str(row["item"]),
            str(row["measure"]),
            shown(row, "ours", is_change(row)),
            str(row["printed"]),
            str(row["unit"]).replace("1", ""),
            Text(verdict, style=_LOOKS[verdict]),
        )
    return table


def _totals(result: Replication) -> Table:
    table = table_of("", *map(str, result.totals.columns))
    for place, counts in totals_by_place(result).items():
        if place == "all":
            table.add_section()
        table.add_row(place, *map(str, counts.values()))
    return table


def replication_json(result: Replication) -> dict[str, Any]:
    """Every row, totals by place, remarks, rules and provenance; null where there is no number."""
    numbers = ("paper", "ours", "deviation", "deviation_percent")
    rows = [
        {str(name): number(float(value), 6) if name in numbers else value for name, value in row.items()}
        for row in result.rows.to_dict("records")
    ]
    return {
        "speaker": result.provenance["speaker"],
        "provenance": result.provenance,
        "totals": totals_by_place(result),
        "remarks": result.remarks,
        "rules": {name: RULE_WORDS[name] for name in dict.fromkeys(result.rows["rule"])},
        "rows": rows,
    }
