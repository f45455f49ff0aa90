"""What the core costs: `make bench` prints the table. Times are CPU seconds of one thread, the median of several runs.

The right column is what a throw-away study reached on one thread of a machine of this class, for the PB speaker without
contact (0.1 mm: error at any node and time against a step of 0.5 ms). No time is asserted; the error is.
"""

from __future__ import annotations

import platform
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.benchmarks.timing import cpu_seconds
from tests.blocks import block

import glossa
from glossa import _core
from glossa.cli.output import print_costs
from glossa.studies import effect_costs
from glossa.studies.costs import FAR

pytestmark = pytest.mark.slow
PB = Path(__file__).parents[3] / "shared" / "reference" / "pb"


class Table:
    """Rows of the cost table, printed at the end of the session."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, float, float | None]] = []

    def add(self, what: str, seconds: float, study: float | None = None) -> None:
        self.rows.append((what, seconds, study))

    def text(self) -> str:
        machine = f"{platform.machine()}, {processor()}, 1 thread, kernels {_core.kernel_name()}"
        lines = ["", f"Costs in ms of CPU time ({machine})", f"{'':58}{'here':>9}{'study':>9}{'ratio':>7}"]
        for what, seconds, study in self.rows:
            compared = f"{study * 1e3:9.1f}{study / seconds:7.1f}" if study is not None else ""
            lines.append(f"{what:58}{seconds * 1e3:9.2f}{compared}")
        return "\n".join(lines)


def processor() -> str:
    """Model name of the processor, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown processor")


@pytest.fixture(scope="module")
def table() -> Iterator[Table]:
    result = Table()
    yield result
    print(result.text())


@pytest.fixture(scope="module", params=["PB", "reference"])
def speaker(request: pytest.FixtureRequest) -> glossa.Speaker:
    if request.param == "reference":
        return glossa.Speaker.reference()
    if not PB.is_dir():
        pytest.skip("the PB data are not here")
    return glossa.Speaker.load(PB)


STUDY = {
    ("assembly", False): 3.1e-3,
    ("residual", False): 0.5e-3,
    ("factorisation", False): 18e-3,
    ("factorisation", True): 10.5e-3,
    ("equilibrium", False): 0.35,
    ("equilibrium", True): 0.12,
    ("u", True): 0.5,
    ("i", True): 1.0,
}


def study(speaker: glossa.Speaker, job: str, mirror: bool) -> float | None:
    return STUDY.get((job, mirror)) if speaker.name == "PB" else None


@pytest.mark.parametrize("mirror", [False, True], ids=["full", "mirrored"])
def test_kernels(table: Table, speaker: glossa.Speaker, mirror: bool) -> None:
    """Residual, assembly with tangent, factorisation and solve at the posture of /i/."""
    scene = glossa.Scene(speaker, gravity=None, mirror=mirror, contact=False, hyoid="fixed")
    posture = scene.equilibrate(glossa.VOWELS["i"])
    positions = scene._body.restrict_positions(posture.positions, "posture")
    pieces = _core.Pieces(scene._solver, scene._fractions(glossa.VOWELS["i"]))
    label = f"{speaker.name} {'mirrored' if mirror else 'full'}: "
    table.add(label + "residual", cpu_seconds(lambda: pieces.force(positions), 31), study(speaker, "residual", mirror))
    table.add(label + "assembly with tangent", cpu_seconds(pieces.assemble, 31), study(speaker, "assembly", mirror))
    factor = cpu_seconds(pieces.factorise, 15)
    table.add(label + "factorisation", factor, study(speaker, "factorisation", mirror))
    right = np.ones(len(pieces.unknowns))
    table.add(label + "solve", cpu_seconds(lambda: pieces.solve(right), 31))
    table.add(label + "solve in single precision", cpu_seconds(lambda: pieces.solve(right, roughly=True), 31))
    assert pieces.factorise()


@pytest.mark.parametrize("mirror", [False, True], ids=["full", "mirrored"])
def test_equilibrium(table: Table, speaker: glossa.Speaker, mirror: bool) -> None:
    """/i/ from rest, and from a neighbouring posture."""
    scene = glossa.Scene(speaker, gravity=None, mirror=mirror, contact=False, hyoid="fixed")
    commands = glossa.VOWELS["i"]
    neighbour = scene.equilibrate(commands.scaled("GGp", 1.02))
    label = f"{speaker.name} {'mirrored' if mirror else 'full'}: /i/ equilibrium "
    seconds = cpu_seconds(lambda: scene.equilibrate(commands), 5)
    table.add(label + "from rest", seconds, study(speaker, "equilibrium", mirror))
    table.add(label + "from a neighbour", cpu_seconds(lambda: scene.equilibrate(commands, start=neighbour), 5))
    report = scene.equilibrate(commands).report
    assert report is not None
    assert report.converged


MOVEMENTS = [("u", "BDF2", 0.002), ("u", "SDIRK2", 0.0035), ("i", "BDF2", 0.001), ("i", "SDIRK2", 0.0018)]


@pytest.mark.parametrize(("vowel", "integrator", "dt"), MOVEMENTS)
def test_movement(table: Table, speaker: glossa.Speaker, vowel: str, integrator: str, dt: float) -> None:
    """200 ms of mirrored movement from the resting reflex posture, within 0.1 mm of a fine-step solution."""
    scene = glossa.Scene(speaker, mirror=True, contact=False, hyoid="fixed")
    rest = scene.equilibrate(dict.fromkeys(glossa.MUSCLES, 1.0))
    schedule = glossa.Ramp(glossa.VOWELS[vowel])

    def move() -> glossa.Movement:
        return scene.simulate(schedule, 0.2, dt=dt, initial=rest, integrator=integrator)

    seconds = cpu_seconds(move, 3)
    fine = scene.simulate(schedule, 0.2, dt=0.0005, accuracy="reference", initial=rest)
    moved = move()
    times = np.arange(1, 21) * 0.01
    error = max(np.linalg.norm(moved.at(t).positions - fine.at(t).positions, axis=1).max() for t in times)
    label = f"{speaker.name} mirrored: 200 ms of /{vowel}/, {integrator} {dt * 1e3:g} ms, {error * 1e3:.3f} mm"
    table.add(label, seconds, study(speaker, vowel, True))
    if speaker.name == "PB":
        assert error < 1e-4


def test_effects(speaker: glossa.Speaker) -> None:
    """200 ms of /i/ with effects added one by one, as `glossa costs` prints it; walls out of reach change nothing."""
    costs = effect_costs(speaker, repetitions=5)
    print()
    print_costs(costs)
    bare, far = costs.sel(scene="tissue and muscles"), costs.sel(scene=FAR)
    for name in ("factorisations", "residuals", "stages"):
        assert int(far[name]) == int(bare[name])
    assert bool((costs["tip_change_largest"] > 0.0).all())


def test_full_movement(table: Table, speaker: glossa.Speaker) -> None:
    """The same movement of the full model, once."""
    scene = glossa.Scene(speaker, contact=False, hyoid="fixed")
    rest = scene.equilibrate(dict.fromkeys(glossa.MUSCLES, 1.0))
    schedule = glossa.Ramp(glossa.VOWELS["u"])
    seconds = cpu_seconds(lambda: scene.simulate(schedule, 0.2, dt=0.002, initial=rest, integrator="BDF2"), 1)
    table.add(f"{speaker.name} full: 200 ms of /u/, BDF2 2 ms", seconds)


def test_cantilever(table: Table) -> None:
    """P1 of the independent solvers, 768 hexahedra: CPU per Newton iteration (the best peer: 48 ms)."""
    body = block((12, 8, 8))
    scene = glossa.Scene(body, fixed=("left",))
    report = scene.equilibrate().report
    assert report is not None
    assert report.converged
    seconds = cpu_seconds(scene.equilibrate, 5)
    table.add("cantilever of 768 hexahedra: solve", seconds, 2.0)
    table.add("cantilever of 768 hexahedra: each Newton iteration", seconds / report.iterations, 48e-3)
