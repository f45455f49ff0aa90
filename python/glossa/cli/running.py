"""Where the runs of a study are computed, how far they are, and which failed: workers, a bar on stderr, exit status."""

from __future__ import annotations

import contextlib
import importlib
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from glossa.cli import output
from glossa.cli.files import need
from glossa.errors import InputError
from glossa.studies.executors import worker_pool
from glossa.studies.run import Progress


@contextlib.contextmanager
def study_executor(workers: int, scheduler: str | None) -> Iterator[Executor | None]:
    """What --workers and --scheduler ask for; None: this process.

    Raises:
        InputError: both at once, or Dask is missing.
    """
    if scheduler is not None:
        if workers != 1:
            raise InputError("choose one of --workers and --scheduler")
        need("distributed", "--scheduler", "glossa[cluster]")
        distributed: Any = importlib.import_module("distributed")
        with distributed.Client(scheduler, timeout=10) as client:
            yield client.get_executor()
    elif workers == 1:
        yield None
    else:
        pool = worker_pool(workers)
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def study_bar() -> Iterator[Callable[[Progress], None] | None]:
    """A bar on a terminal's stderr with rate and time left."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Bar(*columns, console=console, transient=True) as bar:
        task: TaskID = bar.add_task("", total=None)

        def show(progress: Progress) -> None:
            bar.update(task, total=progress.total, completed=progress.done, description=pace(progress))

        yield show


def pace(progress: Progress) -> str:
    """Rate, time left, and failures in words."""
    if not math.isfinite(progress.rate):
        words = "first points" if progress.done < progress.total else ""
    else:
        left = round(progress.remaining)
        hours, minutes, seconds = left // 3600, left // 60 % 60, left % 60
        words = f"{progress.rate:.2g}/s, {hours}:{minutes:02}:{seconds:02} left"
    failed = f", {progress.failed} failed" if progress.failed else ""
    return f"{words}{failed}".removeprefix(", ")


def refuse_failed(reasons: Sequence[str], noun: str = "runs") -> None:
    """End with status 1 where there is a reason that is not empty.

    Raises:
        typer.Exit: then, after the number of failures and the first reason on stderr.
    """
    failed = [reason for reason in reasons if reason]
    if failed:
        raise output.failure(f"{len(failed)} {noun} failed, the first: {failed[0]}", 1)
