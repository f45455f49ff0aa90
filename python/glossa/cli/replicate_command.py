"""``glossa replicate``: the whole paper beside one speaker."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from glossa.checks import whole_number
from glossa.cli import output
from glossa.cli.options import (
    ContactOption,
    FrictionOption,
    JsonOption,
    LandmarksOption,
    MirrorOption,
    ResolutionOption,
    SchedulerOption,
    SpeakerOption,
    check_output,
    make_scene,
    make_speaker,
)
from glossa.cli.replicate_output import print_replication, replication_json
from glossa.cli.running import pace, study_executor
from glossa.studies.replication import replicate
from glossa.studies.replication_rules import FAILED
from glossa.studies.run import Progress


@output.guarded
def replicate_command(
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write a page (.html) with tables and figures.")
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(
            "--store", metavar="FILE", help="Keeps finished runs of Table VI; the same command goes on from there."
        ),
    ] = None,
    workers: Annotated[
        int, typer.Option("--workers", "-w", metavar="N", help="Processes on this machine for Table VI.")
    ] = 1,
    scheduler: SchedulerOption = None,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    mirror: MirrorOption = None,
    as_json: JsonOption = False,
) -> None:
    """Every number of the paper's tables and results beside one speaker's, with deviation and verdict.

    Tables II, IV and VI, sections III to V. Numbers that differ are results; only solves that fail count as failure.
    """
    check_output(html, (".html", ".htm"))
    whole_number(workers, "--workers", 1, 1000)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), "upright", mirror, contact, friction)
    with study_executor(workers, scheduler) as executor, _told() as tell:
        result = replicate(scene, store=store, executor=executor, progress=tell)
    if as_json:
        output.print_json(replication_json(result))
    else:
        print_replication(result)
    if html is not None:
        from glossa.cli.replicate_page import replication_page
        from glossa.figures.replication import replication

        html.write_text(replication_page(result, replication(result)), encoding="utf-8")
        output.wrote(html)
    failed = result.rows[result.rows["verdict"] == FAILED]
    if len(failed):
        words = f"{len(failed)} of {len(result.rows)} rows have no number of ours, the first: {failed['note'].iloc[0]}"
        raise output.failure(words, 1)


@contextlib.contextmanager
def _told() -> Iterator[Callable[[str, Progress | None], None]]:
    """What is being computed, on stderr: a line that changes on a terminal, else a line for each run."""
    console = Console(stderr=True)
    if not console.is_terminal:
        last = ""

        def say(words: str, points: Progress | None) -> None:  # noqa: ARG001 - once for each run, not for each point
            nonlocal last
            if words != last:
                last = words
                output.say(words)

        yield say
        return
    with console.status("") as status:

        def show(words: str, points: Progress | None) -> None:
            more = "" if points is None else f", {points.done} of {points.total} {pace(points)}".rstrip()
            status.update(f"{words}{more}")

        yield show
