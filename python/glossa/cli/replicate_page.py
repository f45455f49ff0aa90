"""The page that ``glossa replicate --html`` writes: one file, nothing fetched, pictures inside."""

from __future__ import annotations

import base64
import importlib.resources
import io
from collections.abc import Mapping, Sequence
from html import escape
from string import Template
from typing import Any

import pandas as pd

from glossa.cli.replicate_output import MISSING, TITLES, is_change, shown, totals_by_place
from glossa.cli.study_tables import cell
from glossa.figures.replication import Picture
from glossa.studies.replication import Replication
from glossa.studies.replication_rules import RULE_WORDS

DOTS_PER_INCH = 110

_LABELS = {
    "glossa_version": "glossa",
    "kernel": "processor kernel",
    "speaker": "speaker",
    "speaker_fingerprint": "fingerprint of the speaker",
    "effects": "effects",
    "scene": "scene",
    "residual_tolerance": "tolerance of residuals, over the scale of forces",
    "gap_tolerance_m": "tolerance of penetration, m",
}


def replication_page(result: Replication, pictures: Sequence[Picture]) -> str:
    """The whole page; the same text for the same results and newly made pictures.

    Args:
        result: of :func:`glossa.studies.replicate`.
        pictures: of :func:`glossa.figures.replication.replication`.
    """
    source = importlib.resources.files("glossa.cli").joinpath("replicate_page.html")
    return Template(source.read_text(encoding="utf-8")).substitute(
        title=escape(f"The paper replicated: {result.provenance['speaker'] or 'unnamed speaker'}"),
        summary=_summary(totals_by_place(result)),
        missing=escape(MISSING),
        sections="\n".join(
            _section(str(place), rows, result.remarks.get(str(place), ""), pictures)
            for place, rows in result.rows.groupby("place", sort=False)
        ),
        rules=_definitions({name: RULE_WORDS[name] for name in dict.fromkeys(result.rows["rule"])}),
        provenance=_definitions({_LABELS[name]: value for name, value in result.provenance.items()}),
    )


def _anchor(place: str) -> str:
    return place.lower().replace(" ", "-").replace(".", "-")


def _row(heading: str, cells: Sequence[str], kind: str = "") -> str:
    """A row of a table from finished cells."""
    attribute = f' class="{kind}"' if kind else ""
    return f'<tr{attribute}><th scope="row">{heading}</th>{"".join(cells)}</tr>'


def _number(words: str) -> str:
    return f'<td class="number">{escape(words)}</td>'


def _table(caption: str, headings: Sequence[tuple[str, bool]], rows: Sequence[str], foot: str = "") -> str:
    """A table; headings with whether numbers stand below them."""
    heads = "".join(
        f'<th scope="col"{" class=" + chr(34) + "number" + chr(34) if right else ""}>{escape(words)}</th>'
        for words, right in headings
    )
    end = f"<tfoot>{foot}</tfoot>" if foot else ""
    body = "\n".join(rows)
    return (
        f'<div class="wide" role="region" tabindex="0" aria-label="{escape(caption)}"><table>'
        f"<caption>{escape(caption)}</caption><thead><tr>{heads}</tr></thead>\n<tbody>{body}</tbody>{end}</table></div>"
    )


def _summary(counts: dict[str, dict[str, int]]) -> str:
    headings = [("place in the paper", False), *((name, True) for name in counts["all"])]
    cells = {place: [_number(str(value)) for value in row.values()] for place, row in counts.items()}
    last = cells.pop("all")
    rows = [
        _row(f'<a href="#{_anchor(place)}">{escape(place)}</a>, {escape(TITLES[place])}', row)
        for place, row in cells.items()
    ]
    return _table("How many numbers and statements agree", headings, rows, _row("all", last))


def _section(place: str, rows: pd.DataFrame, remark: str, pictures: Sequence[Picture]) -> str:
    headings = [
        ("of", False),
        ("what", False),
        ("unit", False),
        ("printed", True),
        ("paper", True),
        ("here", True),
        ("deviation", True),
        ("%", True),
        ("verdict", False),
        ("rule", False),
        ("note", False),
    ]
    body = [_line(row) for _, row in rows.iterrows()]
    parts = [f'<h2 id="{_anchor(place)}">{escape(place[0].upper() + place[1:])}: {escape(TITLES[place])}</h2>']
    if remark:
        parts.append(f"<p>{escape(remark)}</p>")
    parts += [_figure(picture) for picture in pictures if picture.place == place]
    parts.append(_table(f"{place}, paper and here", headings, body))
    return "\n".join(parts)


def _line(row: pd.Series[Any]) -> str:
    sign = is_change(row)
    cells = [
        f"<td>{escape(str(row['measure']))}</td>",
        f"<td>{escape(str(row['unit']).replace('1', ''))}</td>",
        _number(str(row["printed"])),
        _number(shown(row, "paper", sign)),
        _number(shown(row, "ours", sign)),
        _number(shown(row, "deviation", True)),
        _number(cell(float(row["deviation_percent"]), 0, "+")),
        f'<td class="verdict">{escape(str(row["verdict"]))}</td>',
        f"<td>{escape(str(row['rule']))}</td>",
        f"<td>{escape(str(row['note']))}</td>",
    ]
    return _row(escape(str(row["item"])), cells, str(row["verdict"]))


def _figure(picture: Picture) -> str:
    caption = escape(picture.caption)
    if picture.figure is None:
        return f"<p>{caption} Not drawn: {escape(picture.reason)}</p>"
    buffer = io.BytesIO()
    picture.figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )


def _definitions(entries: Mapping[str, str]) -> str:
    listed = "\n".join(f"<dt>{escape(name)}</dt><dd>{escape(words)}</dd>" for name, words in entries.items())
    return f"<dl>\n{listed}\n</dl>"
