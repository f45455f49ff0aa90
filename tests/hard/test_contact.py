"""Contact from bad starts, on edges, in slots, with friction from none to 1, and with walls that move."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.blocks import block, masses, wall_force
from tests.hard.bodies import in_slot, over_floor, over_tooth
from tests.hard.checks import DEEPEST, farthest, sound

from glossa import VOWELS, MotorCommands, Posture, Scene, Schedule, Speaker
from glossa.effects import STANDARD_GRAVITY

DENSITY = 1040.0
CLEARANCE = 0.0005
EDGE = 0.04


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((6, 4, 4), muscles={"upper": 6.0, "lower": 6.0})


@pytest.fixture(scope="module")
def floor(body: Speaker) -> Scene:
    return Scene(over_floor(body, CLEARANCE), fixed=["left"])


def balanced(posture: Posture, load: np.ndarray) -> None:
    """Walls and support carry weight and load: to the tolerance of the residual."""
    weight = masses(posture.speaker, DENSITY).sum() * STANDARD_GRAVITY
    total = wall_force(posture) + posture.reactions("left") + load - [0.0, 0.0, weight]
    assert np.abs(total).max() < 1e-6


# Bad starts


@pytest.mark.parametrize("depth", [0.0005, 0.002, 0.005])
@pytest.mark.parametrize("bent", [True, False])
def test_start_inside_a_wall(floor: Scene, depth: float, bent: bool) -> None:
    """Hard: all the underside starts up to 5 mm behind the floor, bent there or moved as a whole, so that the first
    elements are sheared flat. Right: the posture that is found from rest."""
    nodes = floor.speaker.nodes
    share = np.minimum(1.0, nodes[:, 0] / 0.03) if bent else np.where(nodes[:, 0] > 0.0, 1.0, 0.0)
    start = nodes - share[:, None] * [0.0, 0.0, CLEARANCE + depth]
    found = floor.equilibrate(start=start)
    sound(found)
    assert farthest(found.positions, floor.equilibrate().positions) < 1e-7
    balanced(found, np.zeros(3))


@pytest.mark.slow
def test_tongue_that_starts_inside_its_palate(reference: Speaker) -> None:
    """Hard: the dorsum starts 2 mm behind the palate, the tip behind the incisors. Right: /ə/ as from rest."""
    scene = Scene(reference, mirror=True)
    commands = {"GGa": 1.0, "GGp": 0.98, "MH": 0.96}
    rest = scene.equilibrate(commands)
    contact = scene.equilibrate(commands).contact
    assert contact is not None
    height = reference.nodes[:, 2]
    lifted = (height - height.min()) / np.ptp(height)
    held = np.isin(np.arange(len(height)), np.concatenate([reference.node_sets["jaw"], reference.node_sets["hyoid"]]))
    start = np.array(reference.nodes)
    start[:, 2] += np.where(held, 0.0, 0.012 * lifted**4)
    found = scene.equilibrate(commands, start=start)
    sound(found)
    assert farthest(found.positions, rest.positions) < 5e-5


# Edges and slots


@pytest.mark.parametrize(
    ("angle", "friction"),
    [
        *((angle, friction) for angle in (120.0, 90.0, 60.0) for friction in (0.0, 0.3, 1.0)),
        *((angle, friction) for angle in (30.0, 15.0, 5.0) for friction in (0.0, 0.1)),
        *((angle, friction) for angle in (30.0, 15.0, 5.0) for friction in (0.5, 0.7, 0.9, 1.0)),
    ],
)
def test_sharp_edges(body: Speaker, angle: float, friction: float) -> None:
    """Hard: the body lies and is pressed on an edge down to 5 degrees sharp, whose nearest face jumps from one side to
    the other. Right: converged, balanced; without friction the edge pushes across itself only."""
    scene = Scene(over_tooth(body, angle, x=EDGE, clearance=CLEARANCE), fixed=["left"], friction=friction)
    load = np.array([0.0, 0.0, -0.3])
    posture = scene.equilibrate(loads={"right": load})
    sound(posture)
    balanced(posture, load)
    push = wall_force(posture)
    assert push[2] > 0.05
    assert abs(push[1]) < 1e-6 + 1e-3 * friction


@pytest.mark.parametrize(("angle", "deepest"), [(150.0, 5e-4), (120.0, 9e-4)])
def test_edges_enter_between_contact_points(body: Speaker, angle: float, deepest: float) -> None:
    """Hard: contact acts at points 2.5 mm apart, and an edge slips in between: 0.3 mm at 150 degrees, 0.6 mm at 120,
    the more the sharper, while the report tells of 0.02 mm at the points. Right: no more than that; edges of speakers
    are those of bony arches, see ``test_penetration_between_the_points`` of their contact."""
    scene = Scene(over_tooth(body, angle, x=EDGE, clearance=CLEARANCE), fixed=["left"], friction=0.0)
    posture = scene.equilibrate(loads={"right": (0.0, 0.0, -0.3)})
    sound(posture)
    assert posture.contact is not None
    points = posture.contact.points
    under = points[(np.abs(points[:, 1] - 0.02) < 0.005) & (points[:, 2] < 0.01)]
    under = under[np.argsort(under[:, 0])]
    surface = float(np.interp(EDGE, under[:, 0], under[:, 2]))
    assert 1e-5 < -CLEARANCE - surface < deepest


@pytest.mark.parametrize("gap", [2e-4, 5e-5, 5e-6])
def test_thin_gaps_on_both_sides_of_the_tip(body: Speaker, gap: float) -> None:
    """Hard: the tip fits between roof and floor with a gap down to a tenth of the depth that contact may leave, and a
    muscle that thickens it closes both. Right: it is held between them, each wall pushes its way."""
    scene = Scene(in_slot(body, gap, beyond=0.045), fixed=["left"], gravity=None)
    posture = scene.equilibrate({"upper": 0.8, "lower": 0.8})
    sound(posture)
    assert wall_force(posture, "floor")[2] > 0.01
    assert wall_force(posture, "roof")[2] < -0.01
    tip = posture.node_set("right")
    assert tip[:, 2].max() < 0.04 + gap + 2 * DEEPEST
    assert tip[:, 2].min() > -gap - 2 * DEEPEST
    bent = scene.equilibrate({"upper": 0.7})
    sound(bent)
    assert bent.node_set("right")[:, 2].max() < 0.04 + gap + 2 * DEEPEST


# Friction

FRICTIONS = (0.0, 0.1, 0.3, 0.6, 1.0)


def test_friction_from_none_to_one(body: Speaker) -> None:
    """Hard: sticking and sliding points in one contact; at high friction the law is far from a potential. Right: every
    point inside its cone, and the more friction, the less the pressed tip slides."""
    slid = []
    for friction in FRICTIONS:
        scene = Scene(over_floor(body, CLEARANCE), fixed=["left"], friction=friction)
        load = np.array([0.0, 0.02, -0.3])
        posture = scene.equilibrate({"upper": 0.7, "lower": 0.6}, loads={"right": load})
        sound(posture)
        balanced(posture, load)
        assert posture.contact is not None
        drag = np.linalg.norm(posture.contact.drags, axis=1)
        assert (drag <= friction * posture.contact.pressures * 1.02 + 1e-9).all()  # bounds are solved to 1 %
        slid.append(float(np.linalg.norm(posture.displacements[:, :2], axis=1).max()))
    assert all(more > less for more, less in pairwise(slid))


# Moving walls


@pytest.mark.parametrize("rise", [0.002, 0.005, 0.01, 0.02])
def test_wall_that_moves_into_the_body(floor: Scene, rise: float) -> None:
    """Hard: the floor rises by up to half of the block's height in one call, and sweeps over a body that is held at
    its end. Right: taken in steps that points find back from; the body lies on top of it."""
    up = {"wall:floor": (0.0, 0.0, rise)}
    posture = floor.equilibrate(prescribed=up)
    report = sound(posture)
    balanced(posture, np.zeros(3))
    assert report.iterations > 5
    tip = posture.node_set("right")[:, 2].min()
    assert tip > rise - CLEARANCE - 2e-3  # nodes lie up to 2 mm within the smooth surface's rounded edge
    back = floor.equilibrate(start=posture)
    sound(back)
    assert farthest(back.positions, floor.equilibrate().positions) < 5e-5


@pytest.mark.slow
def test_palate_that_moves_into_the_tongue(reference: Speaker) -> None:
    """Hard: the hard palate comes down by 8 mm on /i/, which touches it. Right: converged; back up, /i/ again without
    friction."""
    scene = Scene(reference, mirror=True, friction=0.0)
    vowel = scene.equilibrate(VOWELS["i"])
    down = scene.equilibrate(VOWELS["i"], start=vowel, prescribed={"wall:hard_palate": (0.0, 0.0, -0.008)})
    sound(down)
    assert vowel.contact is not None
    assert down.contact is not None
    assert wall_force(down, "hard_palate")[2] < 2.0 * wall_force(vowel, "hard_palate")[2] < 0.0
    back = scene.equilibrate(VOWELS["i"], start=down)
    sound(back)
    assert farthest(back.positions, vowel.positions) < 2e-4


def test_movement_between_two_walls(body: Speaker) -> None:
    """Hard: the tip is thrown from the roof to the floor and back by muscles that jump. Right: no step fails, no point
    enters deeper than a tenth of a millimetre."""
    scene = Scene(in_slot(body, 5e-4, beyond=0.045), fixed=["left"])
    up, down = ({"upper": a, "lower": b} for a, b in ((0.8, 1.2), (1.2, 0.8)))
    throws = [(0.04 * k, MotorCommands(up if k % 2 else down)) for k in range(4)]
    movement = scene.simulate(Schedule.through(throws, transition=0.0), 0.16, accuracy="draft")
    assert movement.report.converged
    assert movement.report.penetration < 2e-4
    tip = movement.positions[:, body.node_sets["right"], 2]
    assert tip.max() < 0.04 + 5e-4 + 3e-4
    assert tip.min() > -5e-4 - 3e-4
