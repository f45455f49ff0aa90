"""Input decks of the cantilever P1 and the compression P4 for CalculiX (ccx), runs of it, and what they print.

The problems are those of shared/reference/solvers/README.md; lengths in m, forces in N. Decks are written from the
same blocks that glossa computes, with the element that is asked for.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.blocks import SIZE, FloatArray, block
from tests.blocks import IntArray as Hexahedra

CCX = shutil.which("ccx")

P1_POINT = (0.06, 0.02, 0.02)
P4_POINT = (0.06, 0.02, 0.04)
P4_DEPTH = 0.008
P4_SLOPE = float(np.tan(np.radians(10.0)))
P4_STIFFNESS = 1e8
"""Of CalculiX's penalty contact, Pa/m: the plane is entered by 0.007 mm on average (in glossa by 0.005 mm at most)."""

FIRST_INCREMENTS = (0.1, 0.2)
"""Shares of the load in the first increment; CalculiX chooses the others. Both are run and the quicker counts; in most
cases 0.05, 0.5 and 1 take it longer. Its iterative solver takes more than a hundred times as long as its direct one
(P1, C3D8I, 6x4x4)."""

_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""Edges of a hexahedron in the order of the middle nodes of C3D20."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run of CalculiX.

    Attributes:
        seconds: CPU time (user and system) of the whole process.
        overhead: that of the same deck when nothing is solved: start, reading and checking.
        increments, iterations: as ccx counts them.
        displacement: (3,) of the point of the problem, m.
        reaction: (3,) of the clamped face, N.
    """

    seconds: float
    overhead: float
    increments: int
    iterations: int
    displacement: FloatArray
    reaction: FloatArray

    @property
    def solving(self) -> float:
        """CPU seconds without start, reading and checking."""
        return self.seconds - self.overhead


def quadratic(nodes: FloatArray, hexahedra: Hexahedra) -> tuple[FloatArray, Hexahedra]:
    """Nodes and (m, 20) hexahedra with a node in the middle of every edge, in CalculiX's order."""
    pairs = np.sort(hexahedra[:, np.array(_EDGES)].reshape(-1, 2), axis=1)
    edges, number = np.unique(pairs, axis=0, return_inverse=True)
    middle = len(nodes) + number.reshape(-1, len(_EDGES))
    return np.vstack([nodes, nodes[edges].mean(axis=1)]), np.hstack([hexahedra, middle]).astype(np.int32)


def _mesh(cells: Sequence[int], element: str) -> tuple[FloatArray, Hexahedra]:
    body = block(cells)
    if element.startswith("C3D20"):
        return quadratic(body.nodes, body.hexahedra)
    return body.nodes, body.hexahedra


def _node_lines(nodes: FloatArray, first: int = 1) -> list[str]:
    return [f"{i},{x:.15g},{y:.15g},{z:.15g}" for i, (x, y, z) in enumerate(nodes.tolist(), first)]


def _element_lines(hexahedra: Hexahedra) -> list[str]:
    lines = []
    for number, corners in enumerate((hexahedra + 1).tolist(), 1):
        words = [str(word) for word in (number, *corners)]
        lines.append(",".join(words[:11]) + ("," if len(words) > 11 else ""))
        lines += [",".join(words[11:])] if len(words) > 11 else []
    return lines


def _set_lines(name: str, members: Iterable[int]) -> list[str]:
    return [f"*NSET, NSET={name}", *(f"{int(node) + 1}," for node in members)]


def _nearest(nodes: FloatArray, point: Sequence[float]) -> int:
    return int(np.linalg.norm(nodes - np.asarray(point), axis=1).argmin())


# The Yeoh law with U = (J - 1)^2 / D1; without (J - 1)^4 and (J - 1)^6, so D2 and D3 are as good as infinite (ccx takes
# zeros for defaults of its own).
_TISSUE = ["*MATERIAL, NAME=TISSUE", "*HYPERELASTIC, YEOH", f"1037.,486.,0.,{2.0 / 1.037e6:.15g},1.e20,1.e20"]
_SECTION = ["*SOLID SECTION, ELSET=BODY, MATERIAL=TISSUE"]
_PRINT = ["*NODE PRINT, NSET=POINT", "U", "*NODE PRINT, NSET=CLAMP, TOTALS=ONLY", "RF", "*END STEP", ""]


def _body_lines(nodes: FloatArray, hexahedra: Hexahedra, element: str, clamped: int, point: int) -> list[str]:
    """Nodes, elements and sets of the block; ``clamped``: axis whose face at 0 is held."""
    return [
        *("*NODE, NSET=ALL", *_node_lines(nodes)),
        *(f"*ELEMENT, TYPE={element}, ELSET=BODY", *_element_lines(hexahedra)),
        *_set_lines("CLAMP", np.flatnonzero(nodes[:, clamped] < 1e-9)),
        *_set_lines("POINT", [point]),
    ]


def _step(first: float | None) -> list[str]:
    return ["*STEP, NLGEOM, INC=1000", *(["*NO ANALYSIS"] if first is None else ["*STATIC", f"{first},1."])]


def cantilever_deck(cells: Sequence[int], element: str, first: float | None) -> str:
    """P1: the block clamped at x = 0 under its weight; ``first``: see FIRST_INCREMENTS, None: nothing is solved."""
    nodes, hexahedra = _mesh(cells, element)
    lines = [
        *_body_lines(nodes, hexahedra, element, 0, _nearest(nodes, P1_POINT)),
        *(*_TISSUE, "*DENSITY", "1040.", *_SECTION),
        *("*BOUNDARY", "CLAMP,1,3"),
        *_step(first),
        *("*DLOAD", "BODY,GRAV,9.81,0.,0.,-1.", *_PRINT),
    ]
    return "\n".join(lines)


def compression_deck(cells: Sequence[int], element: str, first: float | None) -> str:
    """P4: the block clamped at z = 0 under a rigid inclined plane, which is a hexahedron with prescribed nodes.

    Linear elements touch it with their nodes, quadratic ones with their faces, as ccx's manual recommends.
    """
    nodes, hexahedra = _mesh(cells, element)
    count, cell_count = len(nodes), len(hexahedra)
    ground = [(-0.02, -0.02), (0.08, -0.02), (0.08, 0.06), (-0.02, 0.06)]
    plane = np.array([(x, y, SIZE[2] + (SIZE[0] - x) * P4_SLOPE + h) for h in (0.0, 0.01) for x, y in ground])
    top = np.flatnonzero(nodes[:, 2] > SIZE[2] - 1e-9)
    if element.startswith("C3D20"):
        upper = np.flatnonzero(np.isin(hexahedra[:, 4:8], top).all(axis=1))
        kind, law = "SURFACE TO SURFACE", f"{P4_STIFFNESS:g}"
        touching = ["*SURFACE, NAME=TOP, TYPE=ELEMENT", *(f"{cell + 1},S2" for cell in upper)]
    else:
        kind, law = "NODE TO SURFACE", f"{P4_STIFFNESS:g},1.,0.001"
        touching = [*_set_lines("UPPER", top), "*SURFACE, NAME=TOP, TYPE=NODE", "UPPER"]
    lines = [
        *_body_lines(nodes, hexahedra, element, 2, _nearest(nodes, P4_POINT)),
        *("*NODE, NSET=RIGID", *_node_lines(plane, count + 1)),
        *("*ELEMENT, TYPE=C3D8, ELSET=PLATE", ",".join(map(str, (cell_count + 1, *range(count + 1, count + 9))))),
        *(*_TISSUE, *_SECTION),
        *("*MATERIAL, NAME=STIFF", "*ELASTIC", "1.e6,0.3", "*SOLID SECTION, ELSET=PLATE, MATERIAL=STIFF"),
        *touching,
        *("*SURFACE, NAME=PLANE, TYPE=ELEMENT", f"{cell_count + 1},S1"),
        *(f"*CONTACT PAIR, INTERACTION=HARD, TYPE={kind}", "TOP,PLANE"),
        *("*SURFACE INTERACTION, NAME=HARD", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", law),
        *("*BOUNDARY", "CLAMP,1,3", "RIGID,1,2"),
        *_step(first),
        *("*BOUNDARY", f"RIGID,3,3,{-P4_DEPTH}", *_PRINT),
    ]
    return "\n".join(lines)


DECKS = {"P1": cantilever_deck, "P4": compression_deck}


def _process(folder: Path, deck: str) -> tuple[float, str]:
    """CPU seconds of ccx on a deck, and what it wrote to its standard output."""
    assert CCX is not None
    for old in folder.iterdir():
        old.unlink()
    (folder / "job.inp").write_text(deck)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "CCX_NPROC_RESULTS": "1"}
    done = subprocess.run(
        [CCX, "job"],
        cwd=folder,
        env={**os.environ, **one_thread},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=3600,
        check=False,  # it leaves with other codes after *NO ANALYSIS
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def run(problem: str, cells: Sequence[int], element: str, folder: Path) -> Run:
    """Solve P1 or P4 with CalculiX in a folder of its own; the quicker of the runs with FIRST_INCREMENTS.

    Raises:
        RuntimeError: it did not reach the whole load; the message ends with what it said.
    """
    overhead, _ = _process(folder, DECKS[problem](cells, element, None))
    runs = [_run(DECKS[problem](cells, element, first), overhead, folder) for first in FIRST_INCREMENTS]
    return min(runs, key=lambda run: run.seconds)


def _run(deck: str, overhead: float, folder: Path) -> Run:
    seconds, said = _process(folder, deck)
    rows = [row.split() for row in (folder / "job.sta").read_text().splitlines()]
    done = [row for row in rows if len(row) == 7 and row[0].isdigit()]
    if not done or abs(float(done[-1][4]) - 1.0) > 1e-9:
        raise RuntimeError(f"ccx did not reach the whole load: {said[-500:]}")
    displacement, reaction = _last_values(folder / "job.dat")
    return Run(
        seconds=seconds,
        overhead=overhead,
        increments=len(done),
        iterations=said.count("\n iteration "),
        displacement=displacement,
        reaction=reaction,
    )


def _last_values(path: Path) -> tuple[FloatArray, FloatArray]:
    """Displacement (m) and reaction (N) of the last increment of a .dat file."""
    last: dict[str, FloatArray] = {}
    title = ""
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] in ("displacements", "total"):
            title = words[0]
        elif words:
            last[title] = np.array([float(word) for word in words[-3:]])
    return last["displacements"], last["total"]
