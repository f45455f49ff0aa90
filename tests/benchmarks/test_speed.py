"""What a movement and an equilibrium of the whole model take on this machine: `make bench` prints it.

CPU seconds of one thread, the shortest of a few runs where nothing else is said; aims are those of the project for two
cores of a machine of this class. No seconds are asserted. ``GLOSSA_RESOLUTIONS=2,3,4`` solves finer meshes, too.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest
from tests.benchmarks.converged import FINE_STEP, fine_movement, largest_error
from tests.benchmarks.timing import cpu_seconds

from glossa import MUSCLES, VOWELS, Movement, Posture, Ramp, Scene, SolveError, Speaker, _core
from glossa.studies import effect_costs, size_study
from glossa.studies.costs import BARE, EFFECTS
from glossa.studies.size import growth

pytestmark = pytest.mark.slow

UNTIL = 0.1
TOLERATED = 1e-4
"""Error at any node and time up to which a setting counts, m."""

RESOLUTIONS = [int(word) for word in os.environ.get("GLOSSA_RESOLUTIONS", "2").split(",")]
AIMS = {2: 3.0, 3: 30.0, 4: 120.0}
"""CPU seconds of an equilibrium from rest by resolution."""


@pytest.fixture(scope="module", autouse=True)
def machine() -> Iterator[None]:
    print(f"\n{os.cpu_count()} cores, kernels {_core.kernel_name()}, load {os.getloadavg()[0]:.1f} before", end="")
    yield
    print(f"\nload {os.getloadavg()[0]:.1f} after")


@pytest.fixture(scope="module", params=["reference", "pb"])
def speaker(request: pytest.FixtureRequest) -> Speaker:
    found: Speaker = request.getfixturevalue(request.param)
    return found


@pytest.fixture(scope="module")
def scene(speaker: Speaker) -> Scene:
    """Every effect, mirrored."""
    return Scene(speaker, mirror=True)


def shortest(job: Callable[[], object], repeats: int = 3) -> float:
    """CPU seconds of the quickest run."""
    return min(cpu_seconds(job, 1) for _ in range(repeats))


# Movement

SETTINGS: dict[str, dict[str, Any]] = {
    'accuracy="draft"': {"accuracy": "draft"},
    'accuracy="standard"': {"accuracy": "standard"},
    **{f"local error {error * 1e6:g} um": {"accuracy": error} for error in (5e-6, 1e-5, 5e-5, 1e-4)},
    **{
        f"{integrator} {dt * 1e3:g} ms": {"dt": dt, "integrator": integrator, "accuracy": "draft"}
        for integrator in ("BDF2", "SDIRK2")
        for dt in (0.001, 0.002, 0.0025, 0.0035, 0.005)
    },
}


def test_movement(speaker: Speaker, scene: Scene) -> None:
    """100 ms of /i/ with all effects: error against fine steps and CPU of presets, tolerances and fixed steps."""
    schedule = Ramp(VOWELS["i"])
    fine = fine_movement(scene, "i", UNTIL)
    own = largest_error(fine_movement(scene, "i", UNTIL, 2 * FINE_STEP), fine)
    print(f"\n{speaker.name}, 100 ms of /i/, mirrored; aim 0.1 to 0.3 s within 0.1 mm of SDIRK2 {FINE_STEP * 1e3:g} ms")
    print(f"  (steps twice as long change that by {own * 1e3:.4f} mm)")
    print(f"  {'':24}{'error mm':>10}{'CPU s':>8}{'steps':>7}{'factors':>9}{'residuals':>11}")
    good: dict[str, float] = {}
    for name, options in SETTINGS.items():
        move = partial(scene.simulate, schedule, UNTIL, **options)
        try:
            moved, seconds = timed(move)
        except SolveError as failure:
            print(f"  {name:24}{'none':>10}  {failure.status}")
            continue
        away, report = largest_error(moved, fine), moved.report
        if away <= TOLERATED or "accuracy=" in name:
            seconds = min(seconds, shortest(move, 2))
        if away <= TOLERATED:
            good[name] = seconds
        numbers = f"{report.steps:7}{report.factorisations:9}{report.residuals:11}"
        print(f"  {name:24}{away * 1e3:10.4f}{seconds:8.2f}{numbers}")
    best = min(good, key=lambda name: good[name])
    print(f"  cheapest within 0.1 mm: {best}, {good[best]:.2f} s, {good[best] / UNTIL:.1f} times real time")
    assert own < 0.1 * TOLERATED


def timed(job: Callable[[], Movement]) -> tuple[Movement, float]:
    begin = time.process_time()
    moved = job()
    return moved, time.process_time() - begin


# Equilibrium


def counts(posture: Posture) -> str:
    report = posture.report
    assert report is not None
    return f"{report.iterations:4} iterations {report.factorisations:4} factorisations {report.residuals:5} residuals"


def test_equilibrium(speaker: Speaker, scene: Scene) -> None:
    """The four vowels from rest, half and whole tongue."""
    whole = Scene(speaker)
    print(f"\n{speaker.name}, equilibrium from rest; aims 0.15 s mirrored, whole at most four times that")
    for vowel, commands in VOWELS.items():
        half = shortest(partial(scene.equilibrate, commands))
        full = shortest(partial(whole.equilibrate, commands), 2)
        found = counts(scene.equilibrate(commands))
        print(f"  /{vowel}/ mirrored {half:5.3f} s {found}; whole {full:5.3f} s, {full / half:.1f} times")


def test_neighbours(speaker: Speaker, scene: Scene) -> None:
    """Each of the eleven commands of a vowel 5 % up and down, started from the vowel."""
    print(f"\n{speaker.name}, mirrored, one command of eleven changed by 5 %, from the vowel; aim 0.05 s")
    for vowel, commands in VOWELS.items():
        start = scene.equilibrate(commands)
        seconds, iterations, failed = [], [], 0
        for muscle in MUSCLES:
            for factor in (0.95, 1.05):
                changed = commands.scaled(muscle, factor)
                begin = time.process_time()
                try:
                    report = scene.equilibrate(changed, start=start).report
                except SolveError as error:
                    report, failed = error.report, failed + 1
                seconds.append(time.process_time() - begin)
                assert report is not None
                iterations.append(report.iterations)
        work = f"median {np.median(iterations):.0f} iterations, largest {max(iterations)}"
        spent = f"median {np.median(seconds):5.3f} s, largest {max(seconds):5.3f} s"
        print(f"  /{vowel}/ {spent}; {work}; failed {failed} of {len(seconds)}")
        assert failed == 0
    again = scene.equilibrate(VOWELS["i"], start=scene.equilibrate(VOWELS["i"]))
    print(f"  /i/ from itself: {counts(again)}")


@pytest.mark.parametrize("resolution", RESOLUTIONS)
def test_resolution(resolution: int) -> None:
    """The four vowels of the built-in speaker on finer meshes, from rest, in a process of its own."""
    study = size_study([resolution]).isel(resolution=0)
    aim = f"; aim {AIMS[resolution]:g} s" if resolution in AIMS else ""
    hexahedra, memory = int(study["hexahedra"]), float(study["memory"]) / 1e9
    print(f"\nresolution {resolution}, {hexahedra} hexahedra, mirrored, every effect, from rest, run once{aim}")
    print(f"  speaker and scene {float(study['making_seconds']):.1f} s; memory of the process at most {memory:.2f} GB")
    for vowel in study["vowel"].values.tolist():
        own = study.sel(vowel=vowel)
        work = f"{float(own['iterations']):4.0f} iterations {float(own['factorisations']):4.0f} factorisations"
        print(f"  /{vowel}/ {float(own['cpu_seconds']):7.2f} s {work} {own['reason'].item()}")
    assert not any(study["reason"].values.tolist())


def test_growth() -> None:
    """How factor and work grow with the size of the mesh, half and whole tongue, and what muscles add."""
    print("\nsize of the Cholesky factor of the built-in speaker, every effect; power of the unknowns; fibres in it")
    print(f"  {'':22}{'unknowns':>10}{'entries':>12}{'flops':>11}{'power':>8}{'flops':>11}{'power':>8}")
    for mirror in (True, False):
        levels = sorted({1, 2, 3, *RESOLUTIONS}) if mirror else sorted({1, 2, *RESOLUTIONS})
        study = size_study([], counted=levels, mirror=mirror)
        powers = {name: growth(study, name) for name in ("factor_flops", "whole_flops")}
        for r in levels:
            own = study.sel(resolution=r)
            name = f"resolution {r} {'half' if mirror else 'whole'}"
            sizes = f"{float(own['unknowns']):10.0f}{float(own['factor_entries']):12.0f}"
            work = [f"{float(own[key]):11.2e}{float(power.sel(resolution=r)):8.2f}" for key, power in powers.items()]
            print(f"  {name:22}{sizes}{''.join(work)}")


def test_factorisation_rate() -> None:
    """Operations per second of a factorisation; those of finer meshes are nearer to what the processor can."""
    print("\none factorisation, /ə/ at rest, mirrored")
    for resolution in sorted({1, 2, *RESOLUTIONS}):
        tongue = Scene(Speaker.reference(resolution), mirror=True)
        pieces = _core.Pieces(tongue._solver, tongue._fractions(VOWELS["ə"]))
        pieces.force(tongue._body.nodes)
        pieces.assemble()
        seconds = shortest(pieces.factorise, 5 if resolution == 1 else 2)
        print(f"  resolution {resolution} {seconds:10.3f} s{float(pieces.factor_flops) / seconds / 1e9:8.1f} GF/s")


# Effects


def work(movement: Movement) -> str:
    report = movement.report
    return f"{report.factorisations} factorisations, {report.residuals} residuals, {report.rescued} steps rescued"


def test_effects_left_out(speaker: Speaker) -> None:
    """200 ms of /i/ without one effect: what that saves beside what the table of costs says it adds."""
    costs = effect_costs(speaker, repetitions=3)
    table = [float(value) for value in costs["seconds"]]
    scenes = [str(name) for name in costs["scene"].values]
    everything: dict[str, Any] = {}
    for option in EFFECTS.values():
        everything |= option
    whole = Scene(speaker, mirror=True, **everything)
    alone: dict[str, Scene] = {}
    for name, option in EFFECTS.items():
        alone[name] = Scene(speaker, mirror=True, **(everything | {key: BARE[key] for key in option}))
    for name, option in (("stiffening", {"stiffening": False}), ("reflex delay and rate", {"reflex": None})):
        alone[name] = Scene(speaker, mirror=True, **everything, **option)
    alone["force-velocity"] = Scene(speaker, mirror=True, **everything, force_velocity=False)

    def movement(of: Scene) -> Movement:
        return of.simulate(Ramp(VOWELS["i"]), 0.2, dt=0.002, integrator="BDF2")

    full = shortest(partial(movement, whole))
    print(
        f"\n{speaker.name}, 200 ms of /i/, mirrored, BDF2 2 ms: {full:.2f} s with every effect, {work(movement(whole))}"
    )
    added = dict(zip(scenes, np.diff(table, prepend=np.nan).tolist(), strict=True))
    added["+ contact"] = table[scenes.index("+ friction")] - table[0]  # without contact there is no friction either
    for name, without in alone.items():
        try:
            counted = work(movement(without))
            seconds = shortest(partial(movement, without), 2)
        except SolveError as error:
            print(f"  without {name:22} no movement: {error.status}")
            continue
        said = f"; the table of costs says {added[f'+ {name}']:+.2f} s" if name in EFFECTS else ""
        print(f"  without {name:22} {seconds:5.2f} s, {counted}: saves {full - seconds:+.2f} s{said}")
    assert costs.sizes["scene"] == len(EFFECTS) + 2
