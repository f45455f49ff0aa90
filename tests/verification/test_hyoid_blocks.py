"""A mobile hyoid on a block: springs, weight, rigid motion, the limit of stiff springs, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from tests.blocks import PASSIVE, FloatArray, hyoid_block

from glossa import Hyoid, InputError, MotorCommands, Movement, Posture, Ramp, Scene, Speaker, Spring, Yeoh

FEATHER = Yeoh(1e-3, 0.0, poissons_ratio=0.3)
"""Tissue so soft (1e-4 N/m) that only the springs resist."""


def spring_energy(pose: FloatArray, hyoid: Hyoid) -> float:
    """Of a displacement of the centre (3 entries, m) and a rotation vector about it (3, rad), J."""
    turn = Rotation.from_rotvec(pose[3:]).as_matrix()
    ends = [hyoid.centre + pose[:3] + turn @ (spring.on_hyoid - hyoid.centre) for spring in hyoid.springs]
    stretch = [np.linalg.norm(end - s.fixed) - s.rest_length for end, s in zip(ends, hyoid.springs, strict=True)]
    return float(sum(0.5 * s.stiffness * e**2 for s, e in zip(hyoid.springs, stretch, strict=True)))


def spring_stiffness(hyoid: Hyoid) -> FloatArray:
    """(6, 6) sum of k g g', g = (n, r x n): n direction of a spring, r its end from the centre."""
    result = np.zeros((6, 6))
    for spring in hyoid.springs:
        n = spring.fixed - spring.on_hyoid
        n = n / np.linalg.norm(n)
        g = np.concatenate([n, np.cross(spring.on_hyoid - hyoid.centre, n)])
        result += spring.stiffness * np.outer(g, g)
    return result


def spring_force(posture: Posture) -> FloatArray:
    """(3,) N, of all springs on the bone, from its pose."""
    assert posture.hyoid is not None
    hyoid = posture.speaker.hyoid
    assert hyoid is not None
    total = np.zeros(3)
    for spring in hyoid.springs:
        along = spring.fixed - posture.hyoid.moved(spring.on_hyoid)
        length = np.linalg.norm(along)
        total += spring.stiffness * (length - spring.rest_length) * along / length
    return total


def pose_of(posture: Posture) -> FloatArray:
    assert posture.hyoid is not None
    return np.concatenate([posture.hyoid.displacement, posture.hyoid.rotation])


def hung(force: FloatArray) -> tuple[Posture, FloatArray]:
    """Equilibrium under a force in N at the middle of the attached face; that force and its moment about the centre."""
    speaker = hyoid_block()
    scene = Scene(speaker, gravity=None, fixed=["right"], tissue=FEATHER)
    posture = scene.equilibrate(loads={"hyoid": force.tolist()}, accuracy="reference")
    assert speaker.hyoid is not None
    arm = speaker.nodes[speaker.node_sets["hyoid"]].mean(axis=0) - speaker.hyoid.centre
    return posture, np.concatenate([force, np.cross(arm, force)])


def test_small_load_against_the_stiffness_matrix() -> None:
    posture, wrench = hung(np.array([1e-4, 2e-4, -1e-4]))
    hyoid = posture.speaker.hyoid
    assert hyoid is not None
    wanted = np.linalg.solve(spring_stiffness(hyoid), wrench)
    # 5e-5 of the largest angle seen: its square.
    assert pose_of(posture)[:3] == pytest.approx(wanted[:3], abs=1e-4 * np.abs(wanted[:3]).max())
    assert pose_of(posture)[3:] == pytest.approx(wanted[3:], abs=1e-4 * np.abs(wanted[3:]).max())


def test_large_load_against_the_least_energy() -> None:
    """The bone turns by 5 degrees: geometry of springs and rotation count."""
    force = np.array([0.1, 0.2, -0.3])
    posture, wrench = hung(force)
    speaker = posture.speaker
    hyoid = speaker.hyoid
    assert hyoid is not None
    arms = speaker.nodes[speaker.node_sets["hyoid"]].mean(axis=0) - hyoid.centre

    def potential(pose: FloatArray) -> float:
        return spring_energy(pose, hyoid) - float(force @ (pose[:3] + Rotation.from_rotvec(pose[3:]).apply(arms)))

    wanted = minimize(potential, np.linalg.solve(spring_stiffness(hyoid), wrench), options={"gtol": 1e-10}).x
    assert np.linalg.norm(wanted[3:]) > 0.08
    assert pose_of(posture)[:3] == pytest.approx(wanted[:3], abs=1e-6)
    assert pose_of(posture)[3:] == pytest.approx(wanted[3:], abs=1e-4)
    linear = np.linalg.solve(spring_stiffness(hyoid), wrench)
    assert np.abs(wanted - linear).max() > 0.005  # it is not the linear problem


@pytest.mark.parametrize("gravity", ["upright", "supine"])
def test_weight(gravity: str) -> None:
    """The bone's weight hangs on the springs; the tissue's on springs and support."""
    scene = Scene(hyoid_block(), gravity=gravity, fixed=["right"], tissue=PASSIVE)
    posture = scene.equilibrate(accuracy="reference")
    hyoid = posture.speaker.hyoid
    assert hyoid is not None
    field = np.array({"upright": (0.0, 0.0, -9.81), "supine": (9.81, 0.0, 0.0)}[gravity])
    tissue_weight = posture.speaker.volume * PASSIVE.density * field
    # Reactions over "hyoid" are the force of the bone on the tissue.
    assert posture.reactions("hyoid") + posture.reactions("right") == pytest.approx(-tissue_weight, abs=1e-10)
    assert spring_force(posture) == pytest.approx(posture.reactions("hyoid") - hyoid.mass * field, abs=1e-9)
    assert np.linalg.norm(spring_force(posture)) > 0.05


def test_tied_nodes_move_rigidly() -> None:
    speaker = hyoid_block(muscles={"upper": 3.0})
    scene = Scene(speaker, fixed=["right"], tissue=PASSIVE)
    posture = scene.equilibrate({"upper": 0.85}, accuracy="reference")
    movement = scene.simulate(Ramp(MotorCommands({"upper": 0.85})), 0.04, dt=0.004)
    rest = speaker.nodes[speaker.node_sets["hyoid"]]
    apart = np.linalg.norm(rest[:, None] - rest[None], axis=2)
    for moment in (posture, movement.at(float(movement.times[-1]))):
        assert moment.hyoid is not None
        places = moment.node_set("hyoid")
        assert np.linalg.norm(moment.hyoid.rotation) > 0.01
        assert np.abs(np.linalg.norm(places[:, None] - places[None], axis=2) - apart).max() < 1e-12
        assert np.abs(moment.hyoid.moved(rest) - places).max() < 1e-12


def test_stiff_springs_hold_it() -> None:
    """The difference from a fixed hyoid is the compliance of the springs: it falls as 1 / k."""
    fixed = Scene(hyoid_block(), hyoid="fixed", fixed=["right"], tissue=PASSIVE).equilibrate(accuracy="reference")
    away = []
    for stiffness in (2e4, 2e5, 2e6):
        scene = Scene(hyoid_block(stiffness), fixed=["right"], tissue=PASSIVE)
        away.append(np.abs(scene.equilibrate(accuracy="reference").positions - fixed.positions).max())
    assert np.array(away[:-1]) / away[1:] == pytest.approx([10.0, 10.0], rel=0.05)
    assert 1e-8 < away[-1] < 1e-6


def test_start_does_not_matter() -> None:
    scene = Scene(hyoid_block(muscles={"upper": 3.0}), fixed=["right"], tissue=PASSIVE)
    cold = scene.equilibrate({"upper": 0.85}, accuracy="reference")
    other = scene.equilibrate({"upper": 0.95}, loads={"top": (0.0, 0.1, 0.2)})
    assert np.abs(other.positions - cold.positions).max() > 1e-4
    for start in (cold, other, other.positions):
        warm = scene.equilibrate({"upper": 0.85}, accuracy="reference", start=start)
        assert warm.positions == pytest.approx(cold.positions, abs=1e-9)
        assert pose_of(warm) == pytest.approx(pose_of(cold), abs=1e-8)


def test_free_oscillation_of_the_bone() -> None:
    """Pulled aside and let go, a heavy bone on springs oscillates along y with its own frequency."""
    base = hyoid_block(mass=0.1)
    assert base.hyoid is not None
    springs = [
        Spring(base.hyoid.centre + np.array([0.0, 0.0, z]), base.hyoid.centre + np.array([x, y, z]), 200.0)
        for z in (-0.01, 0.01)
        for x, y in ((0.03, 0.0), (-0.03, 0.0), (0.0, 0.03), (0.0, -0.03))
    ]
    hyoid = Hyoid(None, 0.1, base.hyoid.centre, tuple(springs))
    speaker = Speaker(base.nodes, base.hexahedra, node_sets=dict(base.node_sets), hyoid=hyoid)
    tissue = Yeoh(1e-3, 0.0, poissons_ratio=0.3, density=1e-3)
    scene = Scene(speaker, gravity=None, fixed=["right"], tissue=tissue, damping=None)
    pulled = scene.equilibrate(loads={"hyoid": (0.0, 0.2, 0.0)}, accuracy="reference")
    assert pulled.hyoid is not None
    amplitude = pulled.hyoid.displacement[1]
    assert amplitude == pytest.approx(0.2 / 800.0, rel=1e-3)  # four of the springs lie along y
    period = 2.0 * np.pi * np.sqrt(0.1 / 800.0)
    movement = scene.simulate(None, period, dt=period / 200.0, initial=pulled, accuracy="reference")
    assert movement.hyoid is not None
    wanted = amplitude * np.cos(2.0 * np.pi * movement.times / period)
    assert movement.hyoid.displacements[:, 1] == pytest.approx(wanted, abs=5e-4 * amplitude)  # 2e-4 seen: second order


# Files


@pytest.fixture(scope="module")
def moved() -> tuple[Scene, Posture, Movement]:
    scene = Scene(hyoid_block(muscles={"upper": 3.0}, between_walls=True), fixed=["right"], tissue=PASSIVE)
    commands = MotorCommands({"upper": 0.85})
    posture = scene.equilibrate(commands, prescribed={"wall:roof": (0.0, 0.0, -0.001)})
    return scene, posture, scene.simulate(Ramp(commands), 0.04, dt=0.004)


def same(a: Posture, b: Posture) -> None:
    assert np.array_equal(a.positions, b.positions)
    assert a.contact is not None
    assert b.contact is not None
    assert a.contact.walls == b.contact.walls
    for name in ("wall", "points", "areas", "gaps", "pressures", "directions", "drags"):
        assert np.array_equal(getattr(a.contact, name), getattr(b.contact, name)), name
    assert a.contact.touching.any()
    assert a.contact.drags.any()
    assert a.contact.forces.equals(b.contact.forces)
    assert a.hyoid is not None
    assert b.hyoid is not None
    for name in ("displacement", "rotation", "centre"):
        assert np.array_equal(getattr(a.hyoid, name), getattr(b.hyoid, name)), name
    assert np.abs(a.hyoid.displacement).max() > 1e-5


def test_posture_file(moved: tuple[Scene, Posture, Movement], tmp_path: Path) -> None:
    scene, posture, _ = moved
    posture.save(tmp_path / "posture.nc")
    back = Posture.load(tmp_path / "posture.nc", scene.speaker)
    same(posture, back)
    assert back.wall_displacements.keys() == {"roof"}
    assert np.array_equal(back.wall_displacements["roof"], [0.0, 0.0, -0.001])
    again = scene.equilibrate(posture.commands, start=back, prescribed={"wall:roof": (0.0, 0.0, -0.001)})
    assert again.positions == pytest.approx(posture.positions, abs=50e-6)


def test_movement_file(moved: tuple[Scene, Posture, Movement], tmp_path: Path) -> None:
    scene, _, movement = moved
    movement.save(tmp_path / "movement.nc")
    back = Movement.load(tmp_path / "movement.nc", scene.speaker)
    for time in (0.04, 0.0387):
        same(movement.at(time), back.at(time))


def test_moments_between_frames(moved: tuple[Scene, Posture, Movement]) -> None:
    """Points, gaps and forces belong to the positions of the moment."""
    _, _, movement = moved
    assert movement.contact is not None
    for k in (len(movement.times) - 1, len(movement.times) - 3):
        contact = movement.at(float(movement.times[k])).contact
        assert contact is not None
        assert np.array_equal(contact.pressures, movement.contact.pressures[k])
        assert contact.points == pytest.approx(movement.contact.points.operator @ movement.positions[k], abs=1e-15)
    a, b = movement.times[-2:]
    middle = movement.at(float(0.5 * (a + b))).contact
    assert middle is not None
    assert middle.pressures == pytest.approx(movement.contact.pressures[-2:].mean(axis=0), rel=1e-9)


# Refusals

REFUSED: list[tuple[dict[str, Any], dict[str, Any], str]] = [
    ({}, {"prescribed": {"hyoid": (0.0, 0.0, 0.001)}}, "a node of the mobile hyoid cannot be prescribed"),
    ({}, {"prescribed": {"corners": (0.0, 0.0, 0.001)}}, "a node of the mobile hyoid cannot be prescribed"),
    ({"fixed": ["corners"]}, {}, "belongs to the hyoid and to the fixed set 'corners'"),
    ({"fixed": ["hyoid"]}, {}, "belongs to the hyoid and to the fixed set 'hyoid'"),
]


@pytest.mark.parametrize(("options", "arguments", "message"), REFUSED, ids=[message for *_, message in REFUSED])
def test_refusals(options: dict[str, Any], arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Scene(hyoid_block(), **{"fixed": ["right"], **options}).equilibrate(**arguments)
    assert message in str(caught.value)
