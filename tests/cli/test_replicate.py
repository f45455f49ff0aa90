"""``glossa replicate``: tables, JSON, page, exit codes."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from tests.studies.paper_runs import quick_scene
from tests.studies.small_replication import shorten, small_replication

from glossa import SolveError, Speaker
from glossa.cli import main, replicate_command
from glossa.cli.replicate_output import totals_by_place
from glossa.cli.replicate_page import replication_page
from glossa.figures.replication import Picture, replication
from glossa.studies import Replication, replicate
from glossa.studies import replication_runs as runs_module
from glossa.studies.replication_runs import Runs

VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """What the tests look at in a page; raises where tags do not match."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def of(self, *names: str) -> Iterator[dict[str, str | None]]:
        return (attributes for tag, attributes in self.tags if tag in names)


@pytest.fixture(scope="module")
def result(reference: Speaker) -> Replication:
    return small_replication(reference)


@pytest.fixture(scope="module")
def pictures(result: Replication) -> list[Picture]:
    return replication(result)


@pytest.fixture(scope="module")
def page(result: Replication, pictures: list[Picture]) -> str:
    return replication_page(result, pictures)


@pytest.fixture
def quick(result: Replication, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replicate_command, "replicate", lambda *_, **__: result)


# The page


def test_page_is_well_formed_and_needs_no_other_file(page: str) -> None:
    parsed = Page(page)
    assert page.startswith("<!DOCTYPE html>")
    assert not list(parsed.of("script", "link", "iframe", "object", "base"))
    for _, attributes in parsed.tags:
        for name in ("src", "href", "srcset", "action", "style"):
            value = attributes.get(name)
            assert value is None or value.startswith(("data:image/png;base64,", "#")), value
    assert not re.search(r"https?:|//[a-z]|@import|url\(", re.sub(r"base64,[^\"]*", "", page))
    assert "$" not in re.sub(r"base64,[^\"]*", "", page)


def test_page_can_be_read_by_everyone(page: str) -> None:
    parsed = Page(page)
    assert next(parsed.of("html"))["lang"] == "en"
    assert len(list(parsed.of("h1"))) == 1
    assert len(list(parsed.of("caption"))) == len(list(parsed.of("table"))) == 10
    assert all(attributes["scope"] in ("col", "row") for attributes in parsed.of("th"))
    assert all(attributes["alt"] for attributes in parsed.of("img"))
    identities = [attributes["id"] for _, attributes in parsed.tags if "id" in attributes]
    assert len(set(identities)) == len(identities)
    targets = [str(attributes["href"]) for attributes in parsed.of("a")]
    assert len(targets) == 9
    assert all(target.removeprefix("#") in identities for target in targets)


def test_page_has_every_row_and_its_provenance(page: str, result: Replication) -> None:
    parsed = Page(page)
    verdicts = [attributes.get("class") for attributes in parsed.of("tr")]
    for verdict in ("agrees", "differs", "right", "wrong", "failed"):
        assert verdicts.count(verdict) == totals_by_place(result)["all"][verdict]
    text = " ".join(parsed.text)
    assert "Figures 8 and 9 of the paper show measurements" in text
    for value in result.provenance.values():
        assert value in text
    for remark in result.remarks.values():
        assert remark in text


def test_page_shows_the_figures(page: str, pictures: list[Picture]) -> None:
    drawn = [picture for picture in pictures if picture.figure is not None]
    sources = [str(attributes["src"]) for attributes in Page(page).of("img")]
    assert len(sources) == len(drawn)
    for source in sources:
        data = base64.b64decode(source.removeprefix("data:image/png;base64,"), validate=True)
        assert data.startswith(b"\x89PNG")
        assert len(data) > 5_000
    missing = [picture for picture in pictures if picture.figure is None]
    assert [picture.caption for picture in missing] == [
        "What touches palate and velum in /i/ and /u/, from above, as in the paper's fig. 10."
    ]  # the quick scene has no contact
    assert missing[0].reason in " ".join(Page(page).text)


@pytest.mark.slow
def test_page_is_the_same_for_the_same_results(page: str, result: Replication) -> None:
    assert replication_page(result, replication(result)) == page  # figures lay themselves out anew once drawn


def test_names_of_speakers_are_escaped(result: Replication) -> None:
    named = replace(result, provenance={**result.provenance, "speaker": '<b>&"x"</b> $y'})
    text = replication_page(named, [])
    Page(text)
    assert "<b>" not in text
    assert "&lt;b&gt;&amp;&quot;x&quot;&lt;/b&gt; $y" in text


def test_figures_of_failed_studies_are_left_out(result: Replication) -> None:
    empty = replication(replace(result, runs=Runs()))
    assert all(picture.figure is None and picture.reason for picture in empty)


# The command


@pytest.mark.usefixtures("quick")
def test_text(capsys: pytest.CaptureFixture[str], result: Replication) -> None:
    assert main(["replicate"]) == 1  # the small replication leaves most of Table VI out
    printed = capsys.readouterr()
    assert f"{totals_by_place(result)['all']['failed']} of 307 rows have no number of ours" in printed.err
    for words in ("Table II: forces of the vowels, N", "GGa -10 %", "differs", "Figures 8 and 9", "section V.B"):
        assert words in printed.out
    assert re.search(r"all +│ +307", printed.out)


@pytest.mark.usefixtures("quick")
def test_json(capsys: pytest.CaptureFixture[str], result: Replication) -> None:
    assert main(["replicate", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"speaker", "provenance", "totals", "remarks", "rules", "rows"}
    assert len(found["rows"]) == found["totals"]["all"]["rows"] == 307
    row = found["rows"][2]
    assert (row["place"], row["item"], row["measure"], row["paper"]) == ("Table II", "/i/", "GGp", 25.82)
    assert row["deviation"] == pytest.approx(row["ours"] - row["paper"], abs=1e-5)
    failed = [row for row in found["rows"] if row["verdict"] == "failed"]
    assert failed
    assert all(row["ours"] is None and row["note"] for row in failed)
    assert set(found["rules"]) == set(result.rows["rule"])


def test_the_command_runs_writes_its_page_and_tells_what_it_does(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shorten(monkeypatch)
    file, store = tmp_path / "paper.html", tmp_path / "i.study"
    assert main(["replicate", "--no-contact", "--html", str(file), "--store", str(store), "--json"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["speaker"] == "reference, resolution 1"
    assert printed.err.count("Table VI: commands of /i/") == 1
    assert "section V: silent, supine" in printed.err
    assert f"wrote {file}" in printed.err
    Page(file.read_text(encoding="utf-8"))
    assert store.stat().st_size > 0


def test_without_failures_the_exit_code_is_0(
    capsys: pytest.CaptureFixture[str], result: Replication, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = replace(result, rows=result.rows[result.rows["verdict"] != "failed"])
    monkeypatch.setattr(replicate_command, "replicate", lambda *_, **__: whole)
    assert main(["replicate"]) == 0
    assert "rows have no number" not in capsys.readouterr().err


def test_a_failed_study_is_told(reference: Speaker, result: Replication, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise SolveError("no step today")

    shorten(monkeypatch)
    monkeypatch.setattr(runs_module, "gravity", fail)
    broken = replicate(quick_scene(reference))
    text = " ".join(Page(replication_page(broken, [])).text)
    assert text.count("no step today") == 16
    assert "no step today" not in " ".join(Page(replication_page(result, [])).text)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--html", "page.txt"], "must end in .html or .htm"),
        (["--html", "no/folder/page.html"], "there is no folder"),
        (["--workers", "0"], "--workers"),
        (["--workers", "2", "--scheduler", "tcp://x:1"], "one of --workers and --scheduler"),
        (["--store", "."], "is a folder"),
        (["--speaker", "nobody"], "no such file"),
    ],
)
def test_wrong_input_is_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replicate", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replicate", "--help"]) == 0
    text = capsys.readouterr().out
    assert "Example" in text
    for option in ("--json", "--html", "--store", "--workers", "--speaker"):
        assert option in text
