"""The whole paper beside one speaker: every number of its tables and results, with deviation and verdict."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from glossa.anatomy.speaker import Speaker
from glossa.scene import Scene
from glossa.studies.provenance import solve_provenance
from glossa.studies.replication_gravity import gravity_remarks, rest_rows, supine_rows
from glossa.studies.replication_row import Row, count_verdicts, table_of_rows
from glossa.studies.replication_runs import Runs, run_studies
from glossa.studies.replication_variation import dispersion_rows, saturation_rows, table_6, variation_remarks
from glossa.studies.replication_vowels import single_muscle_rows, table_2, table_4, transversalis_rows
from glossa.studies.run import Progress

PLACES: tuple[Callable[[Runs], list[Row]], ...] = (
    table_2,
    table_4,
    single_muscle_rows,
    transversalis_rows,
    table_6,
    dispersion_rows,
    saturation_rows,
    rest_rows,
    supine_rows,
)
"""Rows of each place in the paper, from the runs."""


@dataclass(frozen=True, kw_only=True)
class Replication:
    """Numbers of the paper beside ours.

    Attributes:
        speaker: whose they are.
        rows: a row for each number or statement: ``place`` in the paper, ``item``, ``measure``, ``unit``, ``printed``
            (as the paper has it), ``paper``, ``ours``, ``deviation`` (ours minus the paper's), ``deviation_percent``,
            ``rule`` (of :data:`glossa.studies.replication_rules.RULE_WORDS`), ``verdict`` and ``note``. In Table VI,
            ``paper`` is the change against Table IV.
        remarks: what no single row says, by place.
        provenance: version, kernel, speaker, scene and tolerances, as text.
        runs: the results the rows are made from, to draw.
    """

    speaker: Speaker
    rows: pd.DataFrame
    remarks: dict[str, str]
    provenance: dict[str, str]
    runs: Runs

    @property
    def totals(self) -> pd.DataFrame:
        """How many rows each place has, in all and of each verdict; the last row, "all", is their sum."""
        return count_verdicts(self.rows)


def replicate(
    scene: Scene,
    *,
    store: str | Path | None = None,
    executor: Executor | None = None,
    progress: Callable[[str, Progress | None], object] | None = None,
) -> Replication:
    """Tables II, IV and VI, and the numbers of sections III.A.1, III.B, IV.B, IV.C, V.A and V.B, beside ours.

    A solve that fails is told in the rows that need it (verdict "failed", with the reason); the rest goes on. Figures 8
    and 9 of the paper show measurements; they have no counterpart.

    Args:
        scene: upright, of a speaker with walls, mobile hyoid, contour "dorsum" and the muscles of Table III; the
            paper's has every effect.
        store: file that keeps finished runs of Table VI, as for :func:`glossa.studies.run_points`: after an
            interruption they are not computed again.
        executor: of these runs, as for :func:`glossa.studies.run_points`.
        progress: called with a line of text before each study and run, and during Table VI also with how far it is.

    Raises:
        InputError: another scene or speaker, or a store or executor that is refused.
        SolveInterrupted: Ctrl-C.
    """
    runs = run_studies(scene, store=store, executor=executor, progress=progress)
    return Replication(
        speaker=scene.speaker,
        rows=table_of_rows([row for rows in PLACES for row in rows(runs)]),
        remarks={**variation_remarks(runs), **gravity_remarks(runs)},
        provenance=_provenance(scene),
        runs=runs,
    )


def _provenance(scene: Scene) -> dict[str, str]:
    own = solve_provenance(scene) | {"effects": ", ".join(scene.effects)}
    return {name: value if isinstance(value, str) else f"{value:g}" for name, value in own.items()}
