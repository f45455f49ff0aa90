"""One number or statement of the paper beside ours, and many of them as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import pandas as pd

from glossa import paper
from glossa.studies.replication_rules import AGREES, DIFFERS, FAILED, RIGHT, STATEMENT, VERDICTS, WRONG, verdict

NO_NUMBER = "there is no number"


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row of a replication.

    Attributes:
        place: table or section of the paper.
        item: vowel, muscle, node or condition.
        measure: what is told of it.
        unit: of the numbers.
        printed: as the paper has it.
        paper: its number; NaN of a statement.
        ours: NaN where a solve failed.
        rule: name in :data:`glossa.studies.replication_rules.RULE_WORDS`.
        verdict: of :data:`glossa.studies.replication_rules.VERDICTS`.
        note: why there is no number, or what else has to be known.
    """

    place: str
    item: str
    measure: str
    unit: str
    printed: str
    paper: float
    ours: float
    rule: str
    verdict: str
    note: str = ""

    @property
    def deviation(self) -> float:
        """Ours minus the paper's; of angles between lines, from -90 to 90 degrees."""
        apart = self.ours - self.paper
        return (apart + 90.0) % 180.0 - 90.0 if self.rule == "angle" else apart

    @property
    def deviation_percent(self) -> float:
        """The same in percent of the paper's; NaN where that is 0, an angle, or in percent itself."""
        if not self.paper or self.unit in ("°", "%"):
            return math.nan
        return 100.0 * self.deviation / abs(self.paper)


def number_row(
    place: str,
    item: str,
    measure: str,
    unit: str,
    *,
    paper: float,
    ours: float,
    rule: str,
    printed: str = "",
    note: str = "",
    right: bool = True,
) -> Row:
    """A number beside ours; it differs, too, where the direction is not ``right``."""
    found = verdict(rule, paper, ours)
    if found == AGREES and not right:
        found, note = DIFFERS, note or "wrong direction"
    if found == FAILED:
        note = note or NO_NUMBER
    return Row(
        place=place,
        item=item,
        measure=measure,
        unit=unit,
        printed=printed or f"{paper:g}",
        paper=paper,
        ours=ours,
        rule=rule,
        verdict=found,
        note=note,
    )


def statement_row(
    place: str, item: str, measure: str, unit: str, *, printed: str, ours: float, right: bool, note: str = ""
) -> Row:
    """A statement without a number, with the number of ours that decides."""
    known = math.isfinite(ours)
    return Row(
        place=place,
        item=item,
        measure=measure,
        unit=unit,
        printed=printed,
        paper=math.nan,
        ours=ours,
        rule=STATEMENT,
        verdict=(RIGHT if right else WRONG) if known else FAILED,
        note=note if known else note or NO_NUMBER,
    )


COLUMNS = (
    "place",
    "item",
    "measure",
    "unit",
    "printed",
    "paper",
    "ours",
    "deviation",
    "deviation_percent",
    "rule",
    "verdict",
    "note",
)


def table_of_rows(rows: Sequence[Row]) -> pd.DataFrame:
    """Rows as a table with the columns :data:`COLUMNS`."""
    listed = [{**asdict(row), "deviation": row.deviation, "deviation_percent": row.deviation_percent} for row in rows]
    return pd.DataFrame(listed, columns=list(COLUMNS))


def count_verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of each verdict by place, in the order of the table, and their sum as the last row, "all"."""
    places = list(dict.fromkeys(table["place"]))
    counts = pd.crosstab(table["place"], table["verdict"]).reindex(index=places, columns=list(VERDICTS), fill_value=0)
    counts.loc["all"] = counts.sum()
    counts.insert(0, "rows", counts.sum(axis=1))
    return counts.rename_axis(index="place", columns=None)


_BOUNDS = {"about": "≈ ", "up_to": "up to ", "below": "below ", "order": "on the order of ", "equal": ""}


def printed_with_bound(bound: str, value: str) -> str:
    """A number with its bound, as in the files under ``data/paper``, to print."""
    return f"{_BOUNDS[bound]}{value}"


def in_text(place: str) -> list[dict[str, str]]:
    """The paper's results in running text of sections IV and V that have no file of their own."""
    return [dict(row) for row in paper.rows("in_text/sections_4_and_5.csv") if row["place"] == place]
