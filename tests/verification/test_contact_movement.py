"""Contact in movements: bounces gain no energy and do not chatter; what comes to rest does so in equilibrium."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, block, furnished, plate, wall_force
from tests.verification.test_invariance import rotation

from glossa import Damping, Movement, Scene, Simulation, Speaker, Yeoh

HEIGHT = 0.005
EDGE = 0.02
WEIGHT = 1040.0 * 9.81 * EDGE**3


def dropped(*, height: float = HEIGHT, tilt: float = 0.0, friction: float = 0.0, beta: float = 1e-3) -> Scene:
    """A free cube with its lowest point above a floor."""
    cube = block((3, 3, 3), (EDGE, EDGE, EDGE))
    nodes = cube.nodes @ rotation((0.3, 1.0, 0.0), tilt).T
    nodes[:, 2] += height - nodes[:, 2].min()
    floor = plate(0.0, (-0.04, -0.04), (0.06, 0.06), facing=1)
    speaker = Speaker(nodes, cube.hexahedra, walls={"floor": floor})
    tissue = Yeoh(3000.0, 0.0, poissons_ratio=0.49)
    return Scene(speaker, fixed=[], tissue=tissue, friction=friction, damping=Damping(alpha=0.0, beta=beta))


def fall(simulation: Simulation, dt: float, steps: int) -> tuple[FloatArray, FloatArray]:
    """(steps + 1,) energy in J; (steps + 1, 3) force of the walls in N."""
    energy, force = np.zeros(steps + 1), np.zeros((steps + 1, 3))
    for k in range(steps + 1):
        if k:
            simulation.step(dt)
        energy[k] = simulation.kinetic_energy + simulation.potential_energy
        force[k] = wall_force(simulation.posture)
    return energy, force


@pytest.mark.parametrize("integrator", ["SDIRK2", "BDF2", "backward_euler"])
@pytest.mark.parametrize(("tilt", "friction"), [(0.0, 0.0), (0.3, 0.0), (0.3, 0.3)])
def test_a_bounce_gains_nothing(tilt: float, friction: float, integrator: str) -> None:
    """The cube falls flat or on an edge, bounces and tumbles: never more energy than at first."""
    simulation = dropped(tilt=tilt, friction=friction).start(None, dt=0.002, integrator=integrator)
    energy, force = fall(simulation, 0.002, 100)
    drop = WEIGHT * HEIGHT
    assert energy.max() - energy[0] < 1e-6 * drop  # 5e-9 seen: stages are solved to 1e-5 of the force scale
    assert energy[0] - energy[-1] > 0.9 * drop
    if integrator == "SDIRK2" and tilt == 0.0:
        assert np.diff(energy).max() < 1e-6 * drop
    assert force[:, 2].min() > -1e-15
    assert force[:, 2].max() > 3.0 * WEIGHT
    # No chatter: a bounce touches once and leaves once. 9 changes at most seen in 0.2 s.
    assert np.count_nonzero(np.diff(force[:, 2] > 0.0)) <= 12
    assert simulation.report.penetration < 45e-6
    if friction == 0.0:
        assert np.abs(force[:, :2]).max() < 1e-9 * force[:, 2].max()


def test_it_comes_to_rest() -> None:
    simulation = dropped(beta=0.01).start(None, dt=0.002)
    energy, force = fall(simulation, 0.002, 150)
    assert force[-1] == pytest.approx([0.0, 0.0, WEIGHT], abs=2e-3 * WEIGHT)
    assert np.abs(simulation.velocities).max() < 1e-4
    assert np.ptp(energy[-20:]) < 1e-5 * (energy[0] - energy[-1])


def test_a_long_fall() -> None:
    """A wall is there further away than anything of the tongue moves."""
    simulation = dropped(height=0.03).start(None, dt=0.002)
    _, force = fall(simulation, 0.002, 50)
    assert not force[:38].any()  # it takes 78 ms
    assert force[38:, 2].max() > 10.0 * WEIGHT
    assert simulation.positions[:, 2].min() > -1e-4


def cantilever(friction: float) -> Scene:
    """The block of P1 whose free end falls 5 mm before it meets a floor."""
    floor = plate(-0.005, (-0.01, -0.02), (0.09, 0.06), facing=1)
    return Scene(furnished(block(), walls={"floor": floor}), fixed=["left"], tissue=PASSIVE, friction=friction)


def test_a_movement_ends_in_the_equilibrium() -> None:
    scene = cantilever(0.0)
    wanted = scene.equilibrate(accuracy="reference")
    simulation = scene.start(None, dt=0.005, integrator="BDF2")
    energy, force = fall(simulation, 0.005, 100)
    assert force[-1] == pytest.approx(wall_force(wanted), abs=1e-4)
    assert force[-1, 2] > 0.3
    assert np.abs(simulation.positions - wanted.positions).max() < 1e-6
    assert np.count_nonzero(np.diff(force[:, 2] > 0.0)) == 1
    assert np.diff(energy).max() < 1e-9 * (energy[0] - energy[-1])


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_equilibrium_stays(friction: float) -> None:
    """Started in an equilibrium with contact and friction nothing moves, and forces stay."""
    scene = cantilever(friction)
    posture = scene.equilibrate(accuracy="reference")
    movement = scene.simulate(None, 0.04, dt=0.004, initial=posture, accuracy="reference")
    # Pressures start as multipliers, so that what penetrated moves out: 4 um seen, the tolerance is 10.
    assert np.abs(movement.positions - posture.positions).max() < 10e-6
    wanted = wall_force(posture)
    assert wall_force(movement.at(0.04)) == pytest.approx(wanted, abs=0.01 * wanted[2])
    assert (abs(wanted[0]) > 0.02) == (friction > 0.0)


def test_walls_stay_where_they_were_moved(tmp_path: Path) -> None:
    """A movement goes on with the walls of the posture that it starts from."""
    size = (0.04, 0.04, 0.03)
    roof = plate(size[2], (-0.015, -0.015), (0.055, 0.055), facing=-1)
    body = furnished(block((4, 4, 3), size), walls={"roof": roof})
    scene = Scene(body, gravity=None, fixed=["bottom"], tissue=PASSIVE)
    posture = scene.equilibrate(prescribed={"wall:roof": (0.0, 0.0, -0.002)}, accuracy="reference")
    movement = scene.simulate(None, 0.02, dt=0.004, initial=posture)
    end = movement.at(0.02)
    assert wall_force(posture)[2] < -0.5
    assert wall_force(end) == pytest.approx(wall_force(posture), abs=0.01 * abs(wall_force(posture)[2]))
    assert np.abs(movement.positions - posture.positions).max() < 10e-6
    assert end.contact is not None
    assert end.contact.penetration < 45e-6
    assert end.contact.gaps[end.contact.touching].max() < 45e-6
    movement.save(tmp_path / "movement.nc")
    back = Movement.load(tmp_path / "movement.nc", body).at(0.02)
    assert back.contact is not None
    assert np.array_equal(back.contact.gaps, end.contact.gaps)
    for moment in (end, back):
        assert moment.wall_displacements["roof"].tolist() == [0.0, 0.0, -0.002]
