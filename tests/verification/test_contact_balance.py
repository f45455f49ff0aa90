"""Contact in equilibrium: balance, independence of order, threads, division of walls and start; rest overlaps; curved
walls; refusals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, block, furnished, masses, plate, sheet, wall_force

from glossa import InputError, Posture, Scene, Speaker, Wall

SIZE = (0.04, 0.04, 0.03)
RIM = 0.012
LOW, HIGH = (-RIM, -RIM), (SIZE[0] + RIM, SIZE[1] + RIM)
WEIGHT = 1040.0 * 9.81 * SIZE[0] * SIZE[1] * SIZE[2]
DOWN = (0.0, 0.0, -0.006)


def dome(x: FloatArray, y: FloatArray) -> FloatArray:
    """Tilted, bulging downwards with a radius of half a metre; 0 to 6 mm above the block at rest."""
    return np.asarray(0.033 + 0.1 * (0.02 - x) + 0.05 * (y - 0.02) + (x - 0.02) ** 2 + (y - 0.02) ** 2)


def under(walls: Mapping[str, Wall], friction: float = 0.0, *, threads: int = 1) -> Scene:
    speaker = furnished(block((5, 5, 4), SIZE), walls=walls)
    return Scene(speaker, fixed=["bottom"], tissue=PASSIVE, friction=friction, threads=threads)


def under_dome(friction: float = 0.0, *, threads: int = 1) -> Scene:
    return under({"roof": sheet(dome, LOW, HIGH, (40, 40), facing=-1)}, friction, threads=threads)


def pressed(scene: Scene, shift: tuple[float, float, float] = DOWN, **options: Any) -> Posture:
    walls: dict[str, Any] = {f"wall:{name}": shift for name in scene.speaker.walls}
    return scene.equilibrate(prescribed=walls, accuracy="reference", **options)


@pytest.mark.parametrize("friction", [0.0, 0.1, 1.0])
def test_action_is_reaction(friction: float) -> None:
    """Walls, supports and weight balance in force and moment, along and across the walls."""
    posture = pressed(under_dome(friction))
    contact = posture.contact
    assert contact is not None
    assert posture.support_forces is not None
    force = wall_force(posture)
    assert force[2] < -1.0
    assert np.abs(force[:2]).min() > 0.02
    assert force + posture.reactions("bottom") == pytest.approx([0.0, 0.0, WEIGHT], abs=1e-9)
    moments = np.cross(contact.points, contact.tractions * contact.areas[:, None]).sum(axis=0)
    moments += np.cross(posture.positions, posture.support_forces).sum(axis=0)
    weight = np.outer(masses(posture.speaker, 1040.0), [0.0, 0.0, -9.81])
    assert moments + np.cross(posture.positions, weight).sum(axis=0) == pytest.approx([0.0] * 3, abs=1e-10)
    assert np.linalg.norm(moments) > 1e-3
    assert contact.drags.any() == (friction > 0.0)
    # The hand of every point: outwards of the wall and against it.
    assert (contact.pressures >= 0.0).all()
    assert np.linalg.norm(contact.directions[contact.touching], axis=1) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_order_of_faces_and_hexahedra(friction: float) -> None:
    scene = under_dome(friction)
    wall, body = scene.speaker.walls["roof"], scene.speaker
    wanted = pressed(scene)
    random = np.random.default_rng(0)
    new_place = random.permutation(len(wall.vertices))
    shuffled = Wall(wall.vertices[np.argsort(new_place)], new_place[random.permutation(wall.faces)])
    assert np.array_equal(wanted.positions, pressed(under({"roof": shuffled}, friction)).positions)
    other = Speaker(
        body.nodes, random.permutation(body.hexahedra), node_sets=dict(body.node_sets), walls=dict(body.walls)
    )
    found = pressed(Scene(other, fixed=["bottom"], tissue=PASSIVE, friction=friction))
    assert not np.array_equal(wanted.positions, found.positions)
    assert found.positions == pytest.approx(wanted.positions, abs=1e-9)  # 1e-13 seen
    assert wall_force(found) == pytest.approx(wall_force(wanted), abs=1e-9)


@pytest.mark.parametrize(("inside", "friction"), [(False, 0.0), (False, 0.3), (True, 0.0)])
def test_a_wall_in_two_overlapping_pieces(friction: float, *, inside: bool) -> None:
    """Where both are, each takes half. With rims off the block no point moves by more than a few times the tolerance
    of 10 um. Within 1.5 mm of a rim a splined distance is short by up to 45 um: rims in the touched area are felt.
    There friction may not settle (coefficient 0.1), which the solver reports."""
    whole = pressed(under_dome(friction))
    left, right = (0.016, 0.024) if inside else (-0.004, 0.0445)
    pieces = {
        "one": sheet(dome, LOW, (right, HIGH[1]), (40, 40), facing=-1),
        "two": sheet(dome, (left, LOW[1]), HIGH, (40, 40), facing=-1),
    }
    parts = pressed(under(pieces, friction))
    assert wall_force(parts, "one")[2] < -0.15
    assert wall_force(parts, "two")[2] < -0.15
    scale = abs(wall_force(whole)[2])
    assert wall_force(parts) == pytest.approx(wall_force(whole), abs=(0.015 if inside else 0.003) * scale)
    moved = np.linalg.norm(parts.positions - whole.positions, axis=1)
    assert np.sqrt(np.mean(moved**2)) < (150e-6 if inside else 15e-6)
    assert moved.max() < (500e-6 if inside else 50e-6)
    assert moved.max() > 0.0


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_start_does_not_matter(friction: float) -> None:
    """Friction counts from rest, whatever the start; what differs is which points use the tolerance of 10 um."""
    scene = under_dome(friction)
    cold = pressed(scene)
    starts: list[Posture | FloatArray] = [cold, cold.positions, scene.equilibrate().positions]
    starts += [pressed(scene, (0.0, 0.0, height)) for height in (-0.003, -0.008)]
    for start in starts:
        warm = pressed(scene, start=start)
        assert np.abs(warm.positions - cold.positions).max() < 5e-5
        assert wall_force(warm) == pytest.approx(wall_force(cold), abs=0.005 * abs(wall_force(cold)[2]))
    assert np.abs(cold.displacements).max() > 1e-3


@pytest.mark.parametrize("accuracy", ["draft", "standard", "reference"])
def test_penetration(accuracy: str) -> None:
    limit = {"draft": 45e-6, "standard": 45e-6, "reference": 10e-6}[accuracy]
    for friction in (0.0, 0.3):
        posture = under_dome(friction).equilibrate(prescribed={"wall:roof": DOWN}, accuracy=accuracy)
        assert posture.contact is not None
        assert posture.report is not None
        assert 0.0 < posture.contact.penetration <= limit
        assert posture.report.penetration == pytest.approx(posture.contact.penetration, rel=1e-6)
        assert posture.report.contact_violation <= limit
        open_points = posture.contact.gaps[posture.contact.touching]
        assert open_points.max() <= limit


# Overlap at rest


def overlapping(depth: float, **options: Any) -> Scene:
    """A floor that rises to ``depth`` above the lower face at one side and falls below it at the other."""
    floor = sheet(lambda x, _: depth * (1.0 - x / 0.02), LOW, HIGH, (20, 1), facing=1)
    speaker = furnished(block((5, 4, 3), SIZE), walls={"floor": floor})
    return Scene(speaker, gravity=None, fixed=["top"], tissue=PASSIVE, **options)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("depth", [0.2e-3, 0.75e-3])
def test_overlap_at_rest_is_no_force(depth: float, friction: float) -> None:
    scene = overlapping(depth, friction=friction)
    posture = scene.equilibrate(accuracy="reference")
    assert posture.contact is not None
    assert np.abs(posture.displacements).max() < 1e-12
    assert posture.contact.pressures.max() < 1e-6  # Pa: a rounding of 1e-15 m
    assert posture.contact.gaps.min() > -1e-12
    # The wall counts as dented by the overlap of each point, no more: all below it are just touched.
    floor = depth * (1.0 - posture.contact.points[:, 0] / 0.02) / np.hypot(1.0, depth / 0.02)
    inside = (posture.contact.points[:, 2] == 0.0) & (floor > 0.02e-3)
    assert inside.sum() > 50
    assert np.abs(posture.contact.gaps[inside]).max() < 1e-6
    movement = scene.simulate(None, 0.02, dt=0.004)
    assert np.abs(movement.positions - scene.speaker.nodes).max() < 1e-12
    assert movement.contact is not None
    assert movement.contact.pressures.max() < 1e-6  # Pa: a rounding of 1e-15 m


def test_overlapping_points_push_back_when_they_go_deeper() -> None:
    scene = overlapping(0.75e-3)
    posture = scene.equilibrate(loads={"bottom": (0.0, 0.0, -1.0)}, accuracy="reference")
    free = Scene(scene.speaker, contact=False, gravity=None, fixed=["top"], tissue=PASSIVE).equilibrate(
        loads={"bottom": (0.0, 0.0, -1.0)}
    )
    assert posture.contact is not None
    dented = scene.speaker.nodes[:, 0] < 0.01
    bottom = dented & (scene.speaker.nodes[:, 2] == 0.0)
    assert np.abs(posture.displacements[bottom, 2]).max() < 0.1 * np.abs(free.displacements[bottom, 2]).max()
    assert wall_force(posture)[2] > 0.3


def test_too_deep_at_rest() -> None:
    overlapping(1.5e-3)
    with pytest.raises(InputError, match=r"wall 'floor': the tongue at rest starts behind it .* at most 2 mm"):
        overlapping(2.5e-3)


# Curved walls


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("bend", [25.0, -25.0])
def test_trough_and_ridge(bend: float, friction: float) -> None:
    """A block lowered onto a cylinder of 20 mm radius, hollow or bulging, settles and leaves its mark."""
    floor = sheet(
        lambda x, _: np.minimum(0.0, -bend * 0.02**2) + bend * (x - 0.02) ** 2 - 1e-4, LOW, HIGH, (60, 1), facing=1
    )
    speaker = furnished(block((8, 4, 5), SIZE), walls={"floor": floor})
    scene = Scene(speaker, fixed=["top"], tissue=PASSIVE, friction=friction)
    raised = {"wall:floor": (0.0, 0.0, 0.004)}
    posture = scene.equilibrate(prescribed=raised, accuracy="reference")
    contact = posture.contact
    assert contact is not None
    assert contact.penetration <= 10e-6
    assert wall_force(posture)[2] > 0.3
    assert wall_force(posture)[:2] == pytest.approx([0.0, 0.0], abs=4e-3)  # symmetric, but for the lattice of the wall
    across = np.abs(contact.points[contact.touching, 0] - 0.02)
    assert (across.min() > 0.005) if bend > 0.0 else (across.min() < 0.003)
    assert wall_force(posture) + posture.reactions("top") == pytest.approx([0.0, 0.0, WEIGHT], abs=1e-9)


# Refusals

REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"wall:palate": DOWN}, "prescribed: no wall 'palate'; this speaker has roof"),
    ({"wall:": DOWN}, "prescribed: no wall ''"),
    ({"wall:roof": (0.0, 0.0)}, "prescribed displacement of wall 'roof': expected three numbers in m"),
    ({"wall:roof": (None, None, -0.001)}, "prescribed displacement of wall 'roof': expected three numbers in m"),
    ({"wall:roof": (0.0, 0.0, np.nan)}, "prescribed displacement of wall 'roof': every component must be finite"),
    ({"wall:roof": "down"}, "prescribed displacement of wall 'roof': expected numbers"),
    ({"roof": DOWN}, "prescribed: no node set 'roof'"),
]


@pytest.mark.parametrize(("prescribed", "message"), REFUSED, ids=[message for _, message in REFUSED])
def test_refused_displacements(prescribed: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        under_dome().equilibrate(prescribed=prescribed)
    assert message in str(caught.value)


def test_refused_without_contact() -> None:
    speaker = under_dome().speaker
    with pytest.raises(InputError, match="wall 'roof' moves, but this scene has no contact"):
        Scene(speaker, contact=False, fixed=["bottom"]).equilibrate(prescribed={"wall:roof": DOWN})


def test_refused_in_a_mirrored_scene() -> None:
    body = block((4, 4, 3), SIZE, centred=True)
    centred = furnished(body, walls={"roof": plate(0.03, (-RIM, -0.04), (HIGH[0], 0.04), facing=-1)})
    scene = Scene(centred, mirror=True, fixed=["bottom"])
    with pytest.raises(InputError, match="mirror=True: wall 'roof' cannot move sideways"):
        scene.equilibrate(prescribed={"wall:roof": (0.0, 0.001, -0.001)})
    lopsided = furnished(body, walls={"roof": plate(0.03, (-RIM, -0.03), (HIGH[0], 0.04), facing=-1)})
    with pytest.raises(InputError, match="mirror=True needs symmetric walls; wall 'roof'"):
        Scene(lopsided, mirror=True, fixed=["bottom"])


def test_unheld_body_between_walls() -> None:
    """Contact may open: it does not count as a support of a body that nothing else holds."""
    walls = {"floor": plate(0.0, LOW, HIGH, facing=1), "roof": plate(SIZE[2], LOW, HIGH, facing=-1)}
    scene = Scene(furnished(block((2, 2, 2), SIZE), walls=walls), fixed=[])
    with pytest.raises(InputError, match="free to move rigidly"):
        scene.equilibrate()
