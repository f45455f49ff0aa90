"""CalculiX on the cantilever P1 and the compression P4 of shared/reference/solvers/README.md: `make bench` prints it.

CPU seconds of one thread each, errors against the limit of fine meshes. CalculiX's seconds are those of its process;
"solving" leaves out what start, reading and checking of the same deck take. glossa's are the making of the scene, with
its distance fields and symbolic factorisation, and the solve; the shortest of a few runs. No seconds are asserted.

``GLOSSA_LONG=1`` adds quadratic elements on finer meshes, which take minutes.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.benchmarks import calculix
from tests.benchmarks.calculix import P1_POINT, P4_DEPTH, P4_POINT, P4_SLOPE, Run
from tests.blocks import PASSIVE, SIZE, FloatArray, block, furnished, nearest, sheet

from glossa import Scene, Speaker

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(calculix.CCX is None, reason="CalculiX is not here (Debian: apt install calculix-ccx)"),
]

Cells = tuple[int, int, int]

COARSE, MIDDLE, FINE = (6, 4, 4), (9, 6, 6), (12, 8, 8)
GLOSSA_CELLS: tuple[Cells, ...] = ((3, 2, 2), COARSE, MIDDLE, FINE)
LONG = bool(os.environ.get("GLOSSA_LONG"))

P1_LIMIT = -24.23e-3
"""uz of the point of P1 on ever finer meshes, m; known to 0.04 mm."""

RUNS: list[tuple[str, str, Cells]] = [
    *(("P1", "C3D8I", cells) for cells in (COARSE, MIDDLE, FINE)),
    *(("P1", "C3D20R", cells) for cells in ((3, 2, 2), COARSE)),
    *(("P4", "C3D8I", cells) for cells in (COARSE, MIDDLE, FINE)),
    ("P4", "C3D20R", COARSE),
    *((problem, "C3D20R", cells) for problem in ("P1", "P4") for cells in (MIDDLE, FINE) if LONG),
]


@dataclass(frozen=True, kw_only=True)
class Ours:
    """glossa's solve of a problem: CPU seconds for making the scene and for solving, and the values compared."""

    making: float
    solving: float
    iterations: int
    displacement: FloatArray
    reaction: FloatArray

    @property
    def seconds(self) -> float:
        return self.making + self.solving


def speaker_of(problem: str, cells: Cells) -> Speaker:
    if problem == "P1":
        return block(cells)
    plane = sheet(lambda x, _: SIZE[2] + (SIZE[0] - x) * P4_SLOPE, (-0.02, -0.02), (0.08, 0.06), facing=-1)
    return furnished(block(cells), walls={"plane": plane})


@cache
def ours(problem: str, cells: Cells, element: str = "Q1P0") -> Ours:
    """The quickest of a few runs; accuracy "standard"."""
    repeats = 5 if np.prod(cells) <= np.prod(COARSE) else 2
    runs = [solved(problem, cells, element) for _ in range(repeats)]
    return min(runs, key=lambda run: run.seconds)


def solved(problem: str, cells: Cells, element: str) -> Ours:
    speaker = speaker_of(problem, cells)
    begin = time.process_time()
    if problem == "P1":
        face, point = "left", P1_POINT
        scene = Scene(speaker, fixed=[face], tissue=PASSIVE, element=element)
        made = time.process_time()
        posture = scene.equilibrate()
    else:
        face, point = "bottom", P4_POINT
        scene = Scene(speaker, fixed=[face], tissue=PASSIVE, element=element, gravity=None, friction=None)
        made = time.process_time()
        posture = scene.equilibrate(prescribed={"wall:plane": (0.0, 0.0, -P4_DEPTH)})
    end = time.process_time()
    assert posture.report is not None
    return Ours(
        making=made - begin,
        solving=end - made,
        iterations=posture.report.iterations,
        displacement=posture.displacements[nearest(speaker, point)],
        reaction=posture.reactions(face),
    )


@cache
def reaction_limit() -> float:
    """Reaction of P4 on ever finer meshes, N. It falls in proportion to the cells' size (seen from 6 to 18 cells), so
    halving them gives the limit, to 0.001 N."""
    coarse, fine = (float(np.linalg.norm(ours("P4", cells).reaction)) for cells in (COARSE, FINE))
    return 2.0 * fine - coarse


def error(problem: str, found: Run | Ours) -> float:
    """Relative error: of the deflection of P1, of the reaction of P4."""
    if problem == "P1":
        return abs(float(found.displacement[2]) / P1_LIMIT - 1.0)
    return abs(float(np.linalg.norm(found.reaction)) / reaction_limit() - 1.0)


def cheapest(problem: str, largest_error: float) -> tuple[Cells, Ours]:
    """The cheapest of our meshes with no larger error; there is one, or the peer is better than our finest mesh."""
    good = [cells for cells in GLOSSA_CELLS if error(problem, ours(problem, cells)) <= largest_error]
    assert good, f"{problem}: glossa's finest mesh errs by more than {largest_error:.2%}"
    best = min(good, key=lambda cells: ours(problem, cells).seconds)
    return best, ours(problem, best)


class Rows:
    """The table, printed at the end."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, *words: str) -> None:
        self.lines.append(f"{words[0]:24}" + "".join(f"{word:>14}" for word in words[1:]))


@pytest.fixture(scope="module")
def rows() -> Iterator[Rows]:
    result = Rows()
    yield result
    print(f"\nCPU seconds of one thread, {os.cpu_count()} cores whose load was {os.getloadavg()[0]:.1f}")
    head = Rows()
    head.add("", "error", "in all", "solving", "iterations", "x same mesh", "x same error", "(our mesh)")
    for problem in ("P1", "P4"):
        for cells in GLOSSA_CELLS:
            run = ours(problem, cells)
            numbers = (f"{run.seconds:.3f}", f"{run.solving:.3f}", f"{run.iterations}")
            head.add(label(problem, "glossa Q1P0", cells), f"{error(problem, run):.2%}", *numbers)
    print("\n".join(head.lines + result.lines))


def label(problem: str, element: str, cells: Cells) -> str:
    return f"{problem} {element} {'x'.join(map(str, cells))}"


SAFE_RATIO = {"P1": 20.0, "P4": 4.0}
"""How many times the CPU of glossa CalculiX takes at least, at an error that is no smaller.
64 to 404 and 9 to 146 seen, on a machine busy with other work."""


@pytest.mark.parametrize(("problem", "element", "cells"), RUNS)
def test_less_cpu_at_no_larger_error(rows: Rows, tmp_path: Path, problem: str, element: str, cells: Cells) -> None:
    peer = calculix.run(problem, cells, element, tmp_path)
    same, (mesh, best) = ours(problem, cells), cheapest(problem, error(problem, peer))
    numbers = (f"{error(problem, peer):.2%}", f"{peer.seconds:.2f}", f"{peer.solving:.2f}", f"{peer.iterations}")
    ratios = (f"{peer.solving / same.seconds:.0f}", f"{peer.solving / best.seconds:.0f}", "x".join(map(str, mesh)))
    rows.add(label(problem, element, cells), *numbers, *ratios)
    assert error(problem, same) <= error(problem, peer)
    assert peer.solving > SAFE_RATIO[problem] * best.seconds


@pytest.mark.parametrize("cells", [COARSE, FINE])
def test_the_same_material(tmp_path: Path, cells: Cells) -> None:
    """Fully integrated hexahedra are the same element in both codes: laws, loads and faces compared are the same."""
    peer, locked = calculix.run("P1", cells, "C3D8", tmp_path), ours("P1", cells, "Q1")
    assert locked.displacement[[0, 2]] == pytest.approx(peer.displacement[[0, 2]], rel=1e-4)


def test_peers_converge_to_the_same_limit(tmp_path: Path) -> None:
    """The error of CalculiX shrinks with the cells in both problems: the limits are not ours alone."""
    for problem in ("P1", "P4"):
        coarse, fine = (calculix.run(problem, cells, "C3D8I", tmp_path) for cells in (COARSE, MIDDLE))
        assert error(problem, fine) < 0.85 * error(problem, coarse)
