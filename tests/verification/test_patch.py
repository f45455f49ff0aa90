"""Patch test: homogeneous deformations are exact on a distorted mesh, with the tractions of the material law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import SIZE, FloatArray, block

from glossa import Scene, Yeoh

TISSUE = Yeoh(1037.0, 486.0, poissons_ratio=0.499)
DEFORMATIONS = {
    "shear": [[1.0, 0.0, 0.4], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    "stretch": [[1.3, 0.0, 0.0], [0.0, 1.3**-0.5, 0.0], [0.0, 0.0, 1.3**-0.5]],
    "general": [[1.1, 0.15, -0.05], [-0.2, 0.95, 0.1], [0.05, 0.12, 0.97]],
}


def first_piola(F: FloatArray, tissue: Yeoh) -> FloatArray:
    """P = 2 W1 J^(-2/3) (F - I1/3 F^-T) + kappa (J - 1) J F^-T, W1 = c10 + 2 c20 (I - 3), I = J^(-2/3) I1."""
    J, I1 = np.linalg.det(F), np.trace(F.T @ F)
    inverse = np.linalg.inv(F).T
    W1 = tissue.c10 + 2.0 * tissue.c20 * (J ** (-2.0 / 3.0) * I1 - 3.0)
    isochoric = 2.0 * W1 * J ** (-2.0 / 3.0) * (F - I1 / 3.0 * inverse)
    return np.asarray(isochoric + tissue.bulk_modulus * (J - 1.0) * J * inverse)


@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
@pytest.mark.parametrize("name", DEFORMATIONS)
def test_homogeneous_deformation(name: str, element: str) -> None:
    speaker = block((4, 3, 3), distortion=0.25)
    inner = np.setdiff1d(speaker.node_sets["all"], speaker.node_sets["boundary"])
    assert len(inner) == 12
    assert speaker.scaled_jacobians.min() < 0.85  # the mesh is distorted
    F = np.array(DEFORMATIONS[name])
    exact = speaker.nodes @ (F - np.eye(3)).T
    scene = Scene(speaker, gravity=None, fixed=[], tissue=TISSUE, element=element)
    boundary = speaker.node_sets["boundary"]
    disturbed = speaker.nodes.copy()
    disturbed[inner] += np.random.default_rng(0).uniform(-1e-3, 1e-3, (len(inner), 3))
    straight = scene.equilibrate(prescribed={"boundary": exact[boundary]}, accuracy="reference")
    posture = scene.equilibrate(prescribed={"boundary": exact[boundary]}, accuracy="reference", start=disturbed)
    assert posture.report is not None
    assert posture.report.iterations > 0
    for found, tolerance in ((straight, 1e-10), (posture, 1e-9)):  # residual at 1e-11 of the force scale; 1.5e-11 seen
        error = np.abs(found.displacements - exact)[inner].max() / np.abs(exact[inner]).max()
        assert error < tolerance
    # The nodal support forces are those of the uniform stress: sum of X (x) force = V P^T.
    P = first_piola(F, TISSUE)
    virial = speaker.nodes.T @ np.asarray(straight.support_forces)
    assert virial.T / speaker.volume == pytest.approx(P, abs=1e-10 * np.abs(P).max())  # residual at 1e-11
    assert np.abs(P).max() > 300.0


@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
def test_uniaxial_extension_under_load(element: str) -> None:
    """Free lateral faces: the load is that of the one-dimensional law at the stretch found."""
    speaker = block((3, 2, 2))
    sets = {"left": (0.0, None, None), "front": (None, 0.0, None), "bottom": (None, None, 0.0)}
    scene = Scene(speaker, gravity=None, fixed=[], tissue=TISSUE, element=element)
    posture = scene.equilibrate(prescribed=sets, loads={"right": (1.5, 0.0, 0.0)}, accuracy="reference")
    stretch = 1.0 + posture.displacements / np.where(speaker.nodes > 0.0, speaker.nodes, np.nan)
    principal = np.nanmean(stretch, axis=0)
    assert np.nanstd(stretch, axis=0) == pytest.approx([0.0] * 3, abs=1e-9)
    assert 1.1 < principal[0] < 1.6
    P = first_piola(np.diag(principal), TISSUE)
    area = SIZE[1] * SIZE[2]
    assert P[0, 0] * area == pytest.approx(1.5, rel=1e-8)
    assert np.abs(P[1:, 1:]).max() * area < 1e-7


@pytest.mark.parametrize("element", ["Q1P0", "Q1"])
def test_confined_column_under_its_weight(element: str) -> None:
    """Sides and bottom on rollers: P33(stretch(z)) = -rho g (H - z), integrated upwards."""
    speaker = block((2, 2, 8))
    tissue = Yeoh(1037.0, 486.0, poissons_ratio=0.2)
    rollers: dict[str, Any] = {"bottom": (None, None, 0.0)}
    rollers |= dict.fromkeys(("left", "right"), (0.0, None, None)) | dict.fromkeys(("front", "back"), (None, 0.0, None))
    posture = Scene(speaker, fixed=[], tissue=tissue, element=element).equilibrate(
        prescribed=rollers, accuracy="reference"
    )
    height = SIZE[2]
    stretches = np.linspace(0.3, 1.0, 200001)
    I1 = stretches ** (-2 / 3) * (stretches**2 + 2)
    W1 = tissue.c10 + 2 * tissue.c20 * (I1 - 3)
    P33 = W1 * (4 / 3) * (stretches ** (1 / 3) - stretches ** (-5 / 3)) + tissue.bulk_modulus * (stretches - 1)
    z = np.linspace(0.0, height, 4001)
    strain = np.interp(-tissue.density * 9.81 * (height - z), P33, stretches) - 1.0
    exact = np.concatenate([[0.0], np.cumsum(0.5 * (strain[1:] + strain[:-1]) * np.diff(z))])
    top = posture.displacements[speaker.node_sets["top"], 2]
    assert exact[-1] < -1e-3
    assert np.ptp(top) < 1e-10
    # Eight linear elements over the height: strains vary by 8 % across an element; 1e-4 seen.
    assert top.mean() == pytest.approx(exact[-1], rel=2e-3)
