"""Patch test through contact: a flat plate pressed on a block leaves a homogeneous stress.

The reference is the material law at the stretch found, and the same block with its top prescribed. What is left of the
penalty is the same at every point, pressure / stiffness = 1.4 um here, far below the tolerance of 10 um: it does not
disturb the stress, it only makes the plate a little softer. Points weigh with the midpoint rule, exact on faces that
are parallelograms; on others pressures differ from point to point so that the nodal forces are still those of a
uniform pressure, nearly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import PASSIVE, SIZE, block, furnished, plate, wall_force
from tests.verification.test_patch import first_piola

from glossa import Posture, Scene, Speaker

ROLLERS: dict[str, Any] = {"bottom": (None, None, 0.0), "left": (0.0, None, None), "front": (None, 0.0, None)}
PRESS = 0.004
RIM = 0.01
"""m, by which the plate is larger than the block on every side: more than the block grows."""


def pressed(body: Speaker) -> Posture:
    low, high = (-RIM, -RIM), (SIZE[0] + RIM, SIZE[1] + RIM)
    speaker = furnished(body, walls={"plate": plate(SIZE[2], low, high, facing=-1)})
    scene = Scene(speaker, gravity=None, fixed=[], tissue=PASSIVE, friction=None)
    return scene.equilibrate(prescribed={**ROLLERS, "wall:plate": (0.0, 0.0, -PRESS)}, accuracy="reference")


def prescribed(body: Speaker) -> Posture:
    scene = Scene(body, gravity=None, fixed=[], tissue=PASSIVE)
    return scene.equilibrate(prescribed={**ROLLERS, "top": (None, None, -PRESS)}, accuracy="reference")


def principal_stretches(posture: Posture) -> tuple[list[float], float]:
    """Along x, y, z, and how much they differ between nodes."""
    nodes = posture.speaker.nodes
    stretch = 1.0 + posture.displacements / np.where(nodes > 0.0, nodes, np.nan)
    return np.nanmean(stretch, axis=0).tolist(), float(np.nanstd(stretch, axis=0).max())


@pytest.mark.parametrize(
    ("cells", "distortion"), [((2, 2, 2), 0.0), ((6, 4, 4), 0.0), ((6, 4, 4), 0.25), ((5, 3, 7), 0.2)]
)
def test_uniform_pressure(cells: tuple[int, int, int], distortion: float) -> None:
    body = block(cells, distortion=distortion)
    touched, reference = pressed(body), prescribed(body)
    contact = touched.contact
    assert contact is not None
    pressures = contact.pressures[contact.touching]
    assert np.ptp(pressures) < 1e-8 * pressures.mean()  # the tolerance of the residual; 2e-9 seen
    assert contact.areas[contact.touching].sum() == pytest.approx(SIZE[0] * SIZE[1], rel=1e-12)
    stretches, spread = principal_stretches(touched)
    assert spread < 1e-9
    assert stretches[2] == pytest.approx(1.0 - (PRESS - contact.penetration) / SIZE[2], abs=1e-9)
    P = first_piola(np.diag(stretches), PASSIVE)
    force = wall_force(touched, "plate")
    assert force == pytest.approx([0.0, 0.0, P[2, 2] * SIZE[0] * SIZE[1]], abs=1e-8 * abs(P[2, 2]) * SIZE[0] * SIZE[1])
    assert force[2] < -1.5
    assert np.abs(P[:2, :2]).max() < 1e-7 * abs(P[2, 2])
    # Against prescribed displacements: no more than the penetration.
    assert 0.0 < contact.penetration < 2e-6
    assert np.abs(touched.positions - reference.positions).max() < 1.01 * contact.penetration


@pytest.mark.parametrize("cells", [(5, 3, 4), (6, 4, 4), (12, 8, 6)])
def test_distorted_surface(cells: tuple[int, int, int]) -> None:
    """Faces that are no parallelograms: the midpoint rule is inexact; what it does to the body stays below 0.2 um."""
    straight = block(cells, distortion=0.15)
    nodes = straight.nodes.copy()
    rim = np.concatenate([straight.node_sets[name] for name in ("left", "right", "front", "back")])
    inner = np.setdiff1d(straight.node_sets["top"], rim)
    cell = np.array(SIZE[:2]) / cells[:2]
    nodes[inner, :2] += np.random.default_rng(3).uniform(-0.25, 0.25, (len(inner), 2)) * cell
    body = Speaker(nodes, straight.hexahedra, node_sets=dict(straight.node_sets))
    touched = pressed(body)
    contact = touched.contact
    assert contact is not None
    exact = pressed(block((2, 2, 2)))
    # 3e-8 seen: the force of the plate is that of the uniform state although pressures differ by some per cent.
    force = wall_force(touched, "plate")
    assert force == pytest.approx(wall_force(exact, "plate"), abs=1e-6)
    pressures = contact.pressures[contact.touching]
    assert 0.005 < np.ptp(pressures) / pressures.mean() < 0.15
    assert np.ptp(touched.displacements[body.node_sets["top"], 2]) < 0.3e-6
    assert np.ptp(touched.displacements[body.node_sets["right"], 0]) < 0.1e-6
