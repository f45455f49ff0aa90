"""Against independent finite element codes: problems P1, P3, P4 and P5 of shared/reference/solvers/README.md.

The numbers are those of that file.
"""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import PASSIVE, FloatArray, block, cook_membrane, furnished, nearest, sheet, wall_force, yeoh

from glossa import Damping, Posture, Scene, Speaker

P1_POINT = (0.06, 0.02, 0.02)
P1_MM = {(6, 4, 4): (-2.7838787264, -23.0295587506), (12, 8, 8): (-2.9905574667, -23.6790753030)}
P1_LOCKED_MM = {(6, 4, 4): -11.8, (12, 8, 8): -14.5}
COOK_M = {2: 4.51246456, 4: 6.01985377, 8: 6.61859122}
COOK_LIMIT_M = 6.932
TIMES = np.arange(1, 11) * 0.020
P5_TRAPEZOIDAL_MM = np.array(
    [
        *(-1.519286, -5.085428, -10.067262, -14.697603, -18.073302),
        *(-20.260574, -21.782489, -22.748907, -23.236128, -23.374357),
    ]
)
P5_DAMPED_MM = np.array(
    [-1.6037, -4.9934, -8.6184, -11.8407, -14.4858, -16.5694, -18.1734, -19.3919, -20.3103, -20.9993]
)


def cantilever(cells: tuple[int, int, int], element: str = "Q1P0") -> FloatArray:
    """(3,) displacement in mm of the point of P1."""
    speaker = block(cells)
    scene = Scene(speaker, fixed=["left"], tissue=PASSIVE, element=element)
    posture = scene.equilibrate(accuracy="reference")
    return np.asarray(1e3 * posture.displacements[nearest(speaker, P1_POINT)])


@pytest.mark.parametrize("cells", P1_MM)
def test_p1_cantilever(cells: tuple[int, int, int]) -> None:
    ux, uy, uz = cantilever(cells)
    # Two codes agree to 8 digits and more; 2e-11 seen, which is the rounding of the published digits.
    assert (ux, uz) == pytest.approx(P1_MM[cells], rel=1e-9)
    assert abs(uy) < 1e-10  # symmetric about y = 0.02; 1e-14 seen


@pytest.mark.parametrize("cells", P1_MM)
def test_p1_locks_with_full_integration(cells: tuple[int, int, int]) -> None:
    uz = cantilever(cells, "Q1")[2]
    # -11.93 and -14.81 here. The other code's fully integrated element is its own, published to three digits.
    assert uz == pytest.approx(P1_LOCKED_MM[cells], rel=0.03)
    assert uz / P1_MM[cells][1] < 0.65


def cook(n: int, scale: float = 1e-3, element: str = "Q1P0") -> float:
    """uy in m at the upper corner, at full size. The body is computed at ``scale``: at equal stress every displacement
    scales with the lengths, and steps of the solver are made for bodies of the size of a tongue."""
    whole = cook_membrane(n)
    speaker = Speaker(scale * whole.nodes, whole.hexahedra, node_sets=dict(whole.node_sets))
    tissue = yeoh(80.1938 / 2.0, 0.0, 400942.0)
    scene = Scene(speaker, gravity=None, fixed=["left"], tissue=tissue, element=element)
    load = 100.0 * scale**2  # N on a thickness of `scale` metres
    posture = scene.equilibrate(
        prescribed={"all": (None, None, 0.0)}, loads={"right": (0.0, load, 0.0)}, accuracy="reference"
    )
    assert not posture.displacements[:, 2].any()
    return float(posture.displacements[nearest(speaker, (48 * scale, 60 * scale, 0.0))][1] / scale)


@pytest.mark.parametrize("n", COOK_M)
def test_p3_cook(n: int) -> None:
    # 1.3e-9 seen: the rounding of the published digits.
    assert cook(n) == pytest.approx(COOK_M[n], rel=1e-8)


def test_p3_limit() -> None:
    coarse, middle, fine = cook(16), cook(32), cook(64)
    # Aitken extrapolation; the corner singularity makes the order 1.36. The limit is known to 0.004.
    limit = fine + (fine - middle) ** 2 / ((middle - coarse) - (fine - middle))
    assert limit == pytest.approx(COOK_LIMIT_M, abs=0.004)
    assert coarse < middle < fine < limit


def test_p3_cook_at_full_size() -> None:
    assert cook(2, scale=1.0) == pytest.approx(COOK_M[2], rel=1e-8)


def test_p3_locks_with_full_integration() -> None:
    assert cook(8, element="Q1") == pytest.approx(2.2, abs=0.05)  # published with two digits; 2.219 here


P4_REACTION_N = (0.312588, 0.0, 1.772774)
P4_MM = {(0.06, 0.02, 0.04): (3.1081, -8.5480), (0.03, 0.02, 0.04): (0.8790, -2.8652)}


@pytest.mark.parametrize("accuracy", ["draft", "standard", "reference"])
def test_p4_inclined_plane(accuracy: str) -> None:
    slope = np.tan(np.radians(10.0))
    plane = sheet(lambda x, _: 0.04 + (0.06 - x) * slope, (-0.02, -0.02), (0.08, 0.06), facing=-1)
    speaker = furnished(block(), walls={"plane": plane})
    scene = Scene(speaker, gravity=None, fixed=["bottom"], tissue=PASSIVE, friction=None)
    posture = scene.equilibrate(prescribed={"wall:plane": (0.0, 0.0, -0.008)}, accuracy=accuracy)
    # The limit of hard contact is published to 0.5 %; the plane is entered by 5 um of its 8 mm: 0.13 % at most seen.
    scale = float(np.linalg.norm(P4_REACTION_N))
    assert posture.reactions("bottom") == pytest.approx(P4_REACTION_N, rel=0.003, abs=1e-6 * scale)
    for point, wanted in P4_MM.items():
        ux, uy, uz = 1e3 * posture.displacements[nearest(speaker, point)]
        assert (ux, uz) == pytest.approx(wanted, rel=0.003)
        assert abs(uy) < 1e-3
    force = wall_force(posture, "plane")
    assert force == pytest.approx(-posture.reactions("bottom"), abs=1e-4 * scale)
    assert force[0] == pytest.approx(slope * force[2], rel=1e-6)  # frictionless: along the plane's normal


def release(damping: Damping, *, dt: float, integrator: str) -> FloatArray:
    """(10,) uz in mm of the point of P1 at TIMES."""
    speaker = block()
    scene = Scene(speaker, fixed=["left"], tissue=PASSIVE, damping=damping)
    movement = scene.simulate(None, 0.2, dt=dt, integrator=integrator, accuracy="reference")
    node = nearest(speaker, P1_POINT)
    frames: list[Posture] = [movement.at(float(t)) for t in TIMES]
    assert np.isclose(movement.times[:, None], TIMES, rtol=0, atol=1e-12).any(axis=0).all()  # none is interpolated
    return np.array([1e3 * frame.displacements[node, 2] for frame in frames])


def test_p5_trapezoidal() -> None:
    ours = release(Damping(alpha=40.0, beta=0.0), dt=0.005, integrator="trapezoidal")
    # 9e-8 seen at 20 ms, where the last of 7 published digits is 7e-7.
    assert ours == pytest.approx(P5_TRAPEZOIDAL_MM, rel=1e-6)


def test_p5_current_tangent_damping() -> None:
    damping = Damping(alpha=40.0, beta=0.03, law="tangent")
    ours = release(damping, dt=0.000625, integrator="SDIRK2")
    assert ours[2:] == pytest.approx(P5_DAMPED_MM[2:], rel=1e-4)  # one code; 3e-5 seen
    # In the steep beginning the published values carry a time error of their own, 4e-4 and 1e-4: ours are those of the
    # SDIRK3 run at 0.5 ms of the feasibility study, to its digits and the remaining second-order error.
    assert ours[:2] == pytest.approx(P5_DAMPED_MM[:2], rel=5e-4)
    assert ours[:2] == pytest.approx([-1.6044, -4.9940], rel=1e-4)
    other = release(damping, dt=0.000625, integrator="BDF2")
    assert ours == pytest.approx(other, rel=8e-4)  # 4e-4 seen at 20 ms, the error of BDF2
    assert not np.array_equal(ours, other)
