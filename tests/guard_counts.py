"""Work that a fixed set of solves takes, as counts that no clock disturbs; the table that tests/test_guard.py holds.

``python -m tests.guard_counts`` in the folder above this one counts anew, writes guard_counts.csv and prints what
changed. Do that after a change that saves work, and after one that costs some for a good reason.
"""

from __future__ import annotations

import csv
import datetime as dt
import logging
from collections.abc import Mapping
from pathlib import Path

from glossa import VOWELS, Posture, Ramp, Scene, SolveReport, Speaker, _core

TABLE = Path(__file__).with_suffix(".csv")
COUNTS = ("iterations", "factorisations", "residuals", "steps")
"""Of :class:`glossa.SolveReport`: Newton iterations or stages, numeric factorisations, residuals, time steps."""

NEIGHBOURS = (("i", "GGp", 0.95), ("i", "MH", 1.05), ("ə", "GGp", 1.05), ("u", "Sty", 0.95), ("a", "HG", 1.05))
"""Vowel to start from, command to change, factor."""

Counts = dict[str, dict[str, int]]


def measured() -> Counts:
    """Counts by case, for the built-in speaker with every effect; mirrored where nothing is said. It takes seconds."""
    speaker = Speaker.reference()
    scene = Scene(speaker, mirror=True)
    postures = {vowel: scene.equilibrate(commands) for vowel, commands in VOWELS.items()}
    found: dict[str, SolveReport | None] = {f"/{v}/ from rest": posture.report for v, posture in postures.items()}
    found["/ə/ from rest, whole tongue"] = Scene(speaker).equilibrate(VOWELS["ə"]).report
    found["/i/ from itself"] = scene.equilibrate(VOWELS["i"], start=postures["i"]).report
    for vowel, muscle, factor in NEIGHBOURS:
        name = f"/{vowel}/ with {muscle} times {factor} from /{vowel}/"
        found[name] = neighbour(scene, postures[vowel], vowel, muscle, factor)
    for accuracy in ("draft", "standard"):
        name = f"100 ms of /i/, {accuracy}"
        found[name] = scene.simulate(Ramp(VOWELS["i"]), 0.1, accuracy=accuracy).report
    return {name: counts(report) for name, report in found.items()}


def neighbour(scene: Scene, start: Posture, vowel: str, muscle: str, factor: float) -> SolveReport | None:
    return scene.equilibrate(VOWELS[vowel].scaled(muscle, factor), start=start).report


def counts(report: SolveReport | None) -> dict[str, int]:
    assert report is not None
    return {name: int(getattr(report, name)) for name in COUNTS}


def stored() -> Counts:
    """The table."""
    with TABLE.open(encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {row["case"]: {name: int(row[name]) for name in COUNTS} for row in rows}


def write(table: Mapping[str, Mapping[str, int]]) -> None:
    """Replace the table."""
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        file.write(
            "# Counts of work, written by `python -m tests.guard_counts`; tests/test_guard.py allows 1.3 times.\n"
        )
        file.write(f"# {dt.datetime.now(dt.UTC).date()}, kernels {_core.kernel_name()}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", *COUNTS])
        writer.writerows([case, *(row[name] for name in COUNTS)] for case, row in table.items())


def renew() -> None:
    """Count, write the table, and say what changed."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    before, now = stored() if TABLE.exists() else {}, measured()
    write(now)
    for case, row in now.items():
        old = before.get(case, {})
        words = [f"{name} {old.get(name, '-')} -> {value}" for name, value in row.items() if old.get(name) != value]
        logging.info("%s: %s", case, ", ".join(words) or "as before")


if __name__ == "__main__":
    renew()
