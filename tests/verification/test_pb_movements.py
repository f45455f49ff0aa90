"""Movements of the paper's speaker with walls, friction, mobile hyoid and gravity."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from tests.blocks import FloatArray
from tests.speaker_contact import REFLEX_ONLY, largest, scene_of

from glossa import VOWELS, Movement, Posture, Ramp, Speaker

TIMES = np.linspace(0.008, 0.2, 25)


@cache
def rest_of(speaker: Speaker, friction: float) -> Posture:
    """In equilibrium with gravity, commands equal to the lengths at rest."""
    return scene_of(speaker, friction).equilibrate(REFLEX_ONLY)


@cache
def movement_of(speaker: Speaker, vowel: str, dt: float, integrator: str = "BDF2", friction: float = 0.1) -> Movement:
    start = rest_of(speaker, friction)
    scene = scene_of(speaker, friction)
    return scene.simulate(Ramp(VOWELS[vowel]), 0.2, dt=dt, initial=start, integrator=integrator)


def differences(movements: list[Movement]) -> list[FloatArray]:
    """(t, n) m between one movement and the next."""
    courses = [np.array([movement.at(float(time)).positions for time in TIMES]) for movement in movements]
    return [np.linalg.norm(b - a, axis=2) for a, b in pairwise(courses)]


@pytest.mark.parametrize("vowel", ["i", "u"])
def test_shorter_steps_change_less(pb: Speaker, vowel: str) -> None:
    """BDF2 of 4, 2 and 1 ms. Largest of /i/: 0.125 and 0.046 mm, of /u/ 0.037 and 0.042 mm; by r.m.s. /i/ 11 and 5 um,
    /u/ 4.6 and 3.4 um."""
    coarse, fine = differences([movement_of(pb, vowel, dt) for dt in (0.004, 0.002, 0.001)])
    assert coarse.max() < 2e-4
    assert 1e-6 < fine.max() < 1e-4
    assert np.sqrt((fine**2).mean()) < 0.8 * np.sqrt((coarse**2).mean()) < 1.5e-5


@pytest.mark.slow
@pytest.mark.parametrize(("integrator", "steps"), [("BDF2", (0.002, 0.001, 0.0005)), ("SDIRK2", (0.008, 0.004, 0.002))])
@pytest.mark.parametrize("vowel", ["i", "u"])
def test_still_shorter_steps(pb: Speaker, vowel: str, integrator: str, steps: tuple[float, ...]) -> None:
    """BDF2: by r.m.s. 5 and 2 um of /i/, 3 and 2 um of /u/. SDIRK2: at most 0.10 mm from 4 to 2 ms; its steps below
    2 ms follow vibrations that grow (cpp/solver/integrator.hpp): 0.5 ms differs from 1 ms by 0.33 mm."""
    coarse, fine = differences([movement_of(pb, vowel, dt, integrator) for dt in steps])
    assert fine.max() < (1e-4 if integrator == "BDF2" else 2e-4)
    assert np.sqrt((fine**2).mean()) < 0.8 * np.sqrt((coarse**2).mean())


@pytest.mark.parametrize("vowel", ["i", "u"])
def test_no_point_enters_a_wall(pb: Speaker, vowel: str) -> None:
    movement = movement_of(pb, vowel, 0.002)
    assert movement.report.rescued == 0
    assert movement.report.penetration < 5e-5
    assert movement.contact is not None
    touching = 0
    for k in range(0, len(movement.times), 5):
        contact = movement.at(float(movement.times[k])).contact
        assert contact is not None
        assert contact.penetration < 5e-5
        touching = max(touching, int(contact.touching.sum()))
    assert touching > 40
    # Chattering would be a point that goes on and off: those that ever touch change 2.0 (/i/) and 1.4 (/u/) times each.
    on = movement.contact.pressures > 0.0
    ever = on.any(axis=0)
    assert np.abs(np.diff(on[:, ever].astype(int), axis=0)).sum(axis=0).mean() < 4.0


@pytest.mark.parametrize("vowel", ["i", "u"])
def test_course_of_the_hyoid(pb: Speaker, vowel: str) -> None:
    """Continuous, with continuous velocity, from the pose of the start to near that of the vowel."""
    movement = movement_of(pb, vowel, 0.001)
    assert movement.hyoid is not None
    course = movement.hyoid.displacements
    start = rest_of(pb, 0.1).hyoid
    end = scene_of(pb, 0.1).equilibrate(VOWELS[vowel]).hyoid
    assert start is not None
    assert end is not None
    assert course[0] == pytest.approx(start.displacement, abs=1e-9)
    assert largest(course[-1] - end.displacement) < 3e-4
    assert largest(np.diff(course, axis=0)) < 1e-4  # m per ms; 0.065 mm of /i/
    assert largest(np.diff(course, 2, axis=0)) < 2.5e-5  # 15 um of /i/
    tied = pb.node_sets["hyoid"]
    for time in (0.03, 0.1):
        posture = movement.at(time)
        assert posture.hyoid is not None
        assert posture.hyoid.moved(pb.nodes[tied]) == pytest.approx(posture.positions[tied], abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("commands", [None, REFLEX_ONLY], ids=["silent", "reflex"])
def test_an_equilibrium_stays(pb: Speaker, commands: dict[str, float] | None, friction: float) -> None:
    """Held by gravity and walls. With friction, slips since rest become slips since the start: a micrometre."""
    scene = scene_of(pb, friction)
    held = scene.equilibrate(commands)
    movement = scene.simulate(commands, 0.03, dt=0.001, initial=held)
    assert largest(movement.positions - held.positions) < (2e-6 if friction else 1e-10)
    assert np.abs(movement.velocities).max() < (2e-3 if friction else 1e-8)  # m/s; vowels move at 0.2


@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2"])
def test_going_back_repeats_every_bit(pb: Speaker, integrator: str) -> None:
    scene, start = scene_of(pb, 0.1), rest_of(pb, 0.1)
    simulation = scene.start(Ramp(VOWELS["i"]), dt=0.002, initial=start, integrator=integrator)
    simulation.run(0.06)
    state = simulation.state
    first = simulation.run(0.09)
    assert first.contact is not None
    assert np.abs(first.contact.drags).max() > 0.0
    simulation.run(0.12)
    simulation.state = state
    assert simulation.time == first.times[0]
    again = simulation.run(0.09)
    assert again.contact is not None
    assert np.array_equal(first.times, again.times)
    for name in ("positions", "velocities", "activations", "fibre_forces"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()
    assert first.contact.pressures.tobytes() == again.contact.pressures.tobytes()
    assert first.contact.drags.tobytes() == again.contact.drags.tobytes()
    assert first.hyoid is not None
    assert again.hyoid is not None
    assert first.hyoid.displacements.tobytes() == again.hyoid.displacements.tobytes()
