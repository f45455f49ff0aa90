"""What accuracy costs in time: errors and times of every numerical choice, and of leaving effects out.

Work and precision: each row of the study sets one thing otherwise than the standard, and has the errors in mm at the
tongue's midsagittal surface, N of the muscles and Hz of the formants beside the seconds it took. Errors are distances
from references that the study computes itself, see :data:`glossa.studies.accuracy_choices.AGAINST`; how far these lie
from second ones of their own, is told, too. :func:`presets`, :func:`savings`, :func:`pareto` and :func:`cheapest` read
the answers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import xarray as xr

from glossa.anatomy.speaker import Speaker
from glossa.checks import instance
from glossa.data_files import data_path
from glossa.errors import InputError, SolveInterrupted
from glossa.scene import Scene
from glossa.studies.accuracy_choices import MESH, WHOLE, Choice, Run, choices, references
from glossa.studies.accuracy_mesh import Limit
from glossa.studies.accuracy_runs import Distance, Outcome, Solves
from glossa.studies.accuracy_settings import FULL, QUICK, AccuracySettings
from glossa.studies.accuracy_summary import cheapest, pareto, presets, savings, worst
from glossa.studies.accuracy_table import AccuracyTable
from glossa.studies.run import Progress

__all__ = [
    "FULL",
    "QUICK",
    "AccuracySettings",
    "accuracy_study",
    "cheapest",
    "committed_study",
    "pareto",
    "presets",
    "savings",
    "worst",
]

COMMITTED = "results/accuracy.nc"
"""Data file with the study of the built-in speaker."""


def accuracy_study(
    scene: Scene,
    settings: AccuracySettings = FULL,
    *,
    landmarks: Any = None,
    progress: Callable[[Progress], object] | None = None,
) -> xr.Dataset:
    """Errors and times of numerical choices.

    Args:
        scene: what all choices share; mirrored where that can be. Of a speaker with the muscles of Table III.
        settings: how much is computed.
        landmarks: of the scene's speaker, where it is the built-in one with others than its own.
        progress: called in this thread at the beginning and after every solve.

    Returns:
        Over ``choice`` (with the coordinates ``kind``, "posture" or "movement", ``family``, ``label``, ``setting``,
        ``setting_units``, ``against``) and ``vowel``: ``node_error (…, node)`` of the six midsagittal nodes and
        ``largest_error`` of all nodes, m, of a movement at the worst time (every 1 ms); ``force_error (…, muscle)`` N,
        of a movement at the worst end of a step; ``formant_error (…, formant)`` Hz, of a movement at its end;
        ``stated_error`` m, what a movement says of its own error in time; ``cpu_seconds`` and ``wall_seconds`` of the
        solve without making the scene; ``iterations``, ``factorisations``, ``residuals``, ``steps``; ``asked``: the
        vowel belongs to this choice; ``reason``: why it failed, or empty. Over ``reference`` ("solve", "steps") and
        ``vowel``, how far a reference lies from a second, coarser one: ``reference_nodes``, ``reference_largest`` m,
        ``reference_force`` N, ``reference_formant`` Hz. NaN where a solve failed, or nothing is known. Attributes:
        settings, machine, provenance.

    Raises:
        InputError: impossible settings, or a speaker that lacks a muscle.
        SolveInterrupted: Ctrl-C; ``study`` holds what has finished.
    """
    instance(scene, Scene, "scene")
    instance(settings, AccuracySettings, "settings")
    resolutions = _resolutions(scene.speaker, settings, landmarks)
    table = AccuracyTable(scene, settings, choices(scene, settings, resolutions), resolutions)
    work = _Work(scene, settings, table, landmarks, progress)
    try:
        work.do()
    except KeyboardInterrupt as stop:
        words = f"study interrupted: {work.done} of {work.total} solves are finished; .study holds their choices"
        raise SolveInterrupted(words, study=table.dataset()) from stop
    return table.dataset()


def committed_study() -> xr.Dataset:
    """The study of the built-in speaker that comes with the package.

    Raises:
        InputError: its file is not there.
    """
    with xr.open_dataset(data_path(COMMITTED), engine="h5netcdf") as opened:
        return opened.load()


def _resolutions(speaker: Speaker, settings: AccuracySettings, landmarks: Any) -> Sequence[int]:
    built_in = speaker.fingerprint == Speaker.reference(1, landmarks).fingerprint
    if settings.resolutions is None:
        return (1, 2) if built_in else (1,)
    if len(settings.resolutions) > 1 and not built_in:
        raise InputError(
            "resolutions: only the built-in speaker can be divided, and the scene has another one "
            f"({speaker.name!r}) or one with other landmarks; use resolutions=(1,)"
        )
    return settings.resolutions


class _Work:
    """Fills the table, solve by solve."""

    def __init__(
        self,
        scene: Scene,
        settings: AccuracySettings,
        table: AccuracyTable,
        landmarks: Any,
        progress: Callable[[Progress], object] | None,
    ) -> None:
        self._table, self._step, self._progress = table, settings.reference_step, progress
        self._solves = Solves(scene, settings.until, landmarks, settings.repetitions, self._tell)
        self._pairs = [
            (number, choice, vowel) for number, choice in enumerate(table.choices) for vowel in table.vowels_of(choice)
        ]
        self.done, self._failed, self.total = 0, 0, len(self._planned())
        self._begin = time.monotonic()

    def do(self) -> None:
        """All of it.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        self._report()
        limits = self._limits()
        for number, choice, vowel in self._pairs:
            if choice.against == MESH:
                limit = limits[vowel]
                outcome = self._solves.outcome(choice.run(vowel))
                known = limit is not None and not outcome.reason
                own = choice.family == "mesh"
                away = limit.error(outcome, choice.resolution, of_limit=own) if known and limit is not None else None
            else:
                outcome, away = self._compared(choice, vowel)
            self._table.rows[number, vowel] = outcome, away

    def _compared(self, choice: Choice, vowel: str) -> tuple[Outcome, Distance | None]:
        reference, check = references(choice, vowel, self._step)
        outcome = self._solves.outcome(choice.run(vowel))
        exact = self._solves.outcome(reference, timed=choice.against == WHOLE)
        if check is not None:
            second = self._solves.distance(self._solves.outcome(check, timed=False), exact)
            if second is not None:
                self._table.checks[choice.against, vowel] = second
        return outcome, self._solves.distance(outcome, exact)

    def _limits(self) -> dict[str, Limit | None]:
        """By vowel; None where a resolution failed."""
        levels = [(choice, choice.resolution) for choice in self._table.choices if choice.family == "mesh"]
        found: dict[str, Limit | None] = {}
        for vowel in self._table.settings.vowels if levels else ():
            outcomes = {r: self._solves.outcome(choice.run(vowel)) for choice, r in levels}
            good = not any(outcome.reason for outcome in outcomes.values())
            found[vowel] = Limit(outcomes, self._solves.nodes) if good else None
        return found

    def _planned(self) -> set[Run]:
        planned: set[Run] = set()
        for _, choice, vowel in self._pairs:
            planned.add(choice.run(vowel))
            if choice.against != MESH:
                planned.update(run for run in references(choice, vowel, self._step) if run is not None)
        return planned

    def _tell(self, _: Run, outcome: Outcome) -> None:
        self.done += 1
        self._failed += bool(outcome.reason)
        self._report()

    def _report(self) -> None:
        if self._progress is not None:
            seconds = time.monotonic() - self._begin
            self._progress(Progress(done=self.done, total=self.total, failed=self._failed, resumed=0, seconds=seconds))
