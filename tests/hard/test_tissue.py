"""Tissue that is nearly incompressible, and of very different stiffness from one element to the next."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.blocks import block, hyoid_block, yeoh
from tests.hard.bodies import layered_bar, over_floor
from tests.hard.checks import farthest, sound

from glossa import VOWELS, Posture, Scene, SolveError, Speaker, Stiffening, Yeoh
from glossa.anatomy.hexahedra import volumes

RATIOS = (0.45, 0.49, 0.499, 0.4999, 0.49999)


@pytest.fixture(scope="module")
def muscular() -> Speaker:
    return block((6, 4, 4), muscles={"upper": 6.0})


def contracted(speaker: Speaker, poissons_ratio: float, *, element: str = "Q1P0") -> Posture:
    scene = Scene(speaker, fixed=["left"], tissue=Yeoh(poissons_ratio=poissons_ratio), element=element)
    return scene.equilibrate({"upper": 0.5})


@pytest.mark.parametrize("ratio", RATIOS)
def test_nearly_incompressible_contraction(muscular: Speaker, ratio: float) -> None:
    """Hard: volumetric stiffness is up to 10^5 times the shear stiffness; pressures iterated late make it indefinite.
    Right: few iterations, and volumes that change by pressure over bulk modulus and by nothing else."""
    posture = contracted(muscular, ratio)
    assert sound(posture).iterations <= 15  # 5 seen
    relative = volumes(posture.positions, muscular.hexahedra) / muscular.element_volumes
    assert posture.pressure is not None
    modulus = Yeoh(poissons_ratio=ratio).bulk_modulus
    # Positions are known to the tolerance of the residual over the bulk modulus: 1e-9 seen.
    assert np.abs(relative - 1.0 - posture.pressure / modulus).max() < 1e-7
    assert np.abs(relative - 1.0).max() < 10.0 * 1037.0 / modulus


def test_contraction_has_an_incompressible_limit(muscular: Speaker) -> None:
    """Hard: elements without a pressure of their own lock there. Right: each decade nearer to 0.5 changes the posture
    ten times less, while locking elements go on stiffening."""
    shapes = [contracted(muscular, ratio).positions for ratio in (0.49, 0.499, 0.4999, 0.49999)]
    changes = [farthest(a, b) for a, b in pairwise(shapes)]
    assert 5.0 < changes[0] / changes[1] < 20.0
    assert 5.0 < changes[1] / changes[2] < 20.0
    locked = contracted(muscular, 0.49999, element="Q1").displacements
    assert np.abs(locked).max() < 0.5 * np.abs(shapes[-1] - muscular.nodes).max()


def test_nearly_incompressible_compression() -> None:
    """Hard: a block pressed to two thirds of its length between plates that hold its ends, at nu 0.49999. Right: it
    bulges and keeps its volume."""
    body = block((6, 4, 4))
    posture = Scene(body, fixed=["left"], tissue=Yeoh(poissons_ratio=0.49999)).equilibrate(
        prescribed={"right": (-0.02, 0.0, 0.0)}
    )
    sound(posture)
    volume = volumes(posture.positions, body.hexahedra).sum() / body.volume
    assert abs(volume - 1.0) < 1e-4  # mean pressure over bulk modulus: 2e-5 seen
    assert posture.displacements[:, 1].max() > 0.004


# Several stiffnesses side by side

CADAVER = Yeoh(192.0, 90.0)
ACTIVE = Stiffening(gains={"passive": 4.4 / 0.008, "active": 53.0 / 0.008})
"""Cadaver tissue stiffened to 5.5 (about passive living tissue) and to 54 times (fully activated)."""


def layers_under_pull(layers: list[str], tissue: Yeoh = CADAVER) -> Posture:
    bar = layered_bar(layers)
    gains = {name: gain for name, gain in ACTIVE.gains.items() if name in layers}
    scene = Scene(bar, fixed=["left"], tissue=tissue, stiffening=Stiffening(gains=gains), gravity=None)
    return scene.equilibrate(dict.fromkeys(gains, 0.5), prescribed={"right": (0.0004, 0.0, 0.0)})


def test_cadaver_passive_and_active_layers_side_by_side() -> None:
    """Hard: neighbouring elements differ by factors of 5 and 54. Right: the bar is stiffer than its layers in series
    and softer than the stiffest alone, both ends carry the same force, and turned around it does the same."""
    layers = ["", "passive", "active"] * 3 + [""]
    bar = layers_under_pull(layers)
    sound(bar)
    assert bar.stiffening is not None
    factors = np.unique(np.round(bar.stiffening))
    assert factors.min() == 1.0
    assert 50.0 < factors.max() < 60.0
    force = bar.reactions("right")[0]
    assert bar.reactions("left")[0] == pytest.approx(-force, rel=1e-6)
    soft = layers_under_pull([""] * 10).reactions("right")[0]
    in_series = len(layers) / (1.0 / bar.stiffening).reshape(len(layers), -1).mean(axis=1).sum()
    assert soft * in_series < force < soft * factors.max()
    turned = layers_under_pull(layers[::-1])
    image = turned.positions * [-1.0, 1.0, 1.0] + [0.0404, 0.0, 0.0]
    order = np.lexsort(np.round(image, 7).T), np.lexsort(np.round(bar.positions, 7).T)
    assert farthest(image[order[0]], bar.positions[order[1]]) < 1e-8


def half_stiff(gain: float) -> tuple[Posture, Posture]:
    """A bar under a load at its end whose first half is stiffened, and the same with that half held."""
    bar = layered_bar(["stiff"] * 4 + [""] * 4)
    load = {"right": (0.0, 0.0, -0.005)}
    bent = Scene(bar, fixed=["left"], stiffening=Stiffening(gains={"stiff": gain})).equilibrate(
        {"stiff": 0.5}, loads=load
    )
    return bent, Scene(bar, fixed=["left", "at stiff"]).equilibrate(loads=load)


@pytest.mark.parametrize("power", [3, 4, 5, 6])
def test_stiff_beside_passive_tissue_becomes_rigid(power: int) -> None:
    """Hard: stiffness ratios up to 4e6. Right: the stiff half tends to a rigid one, in inverse proportion."""
    bent, rigid = half_stiff(10.0 ** (power + 2))
    sound(bent)
    assert bent.stiffening is not None
    ratio = bent.stiffening.max()
    assert 10.0**power < ratio < 10.0 ** (power + 1)
    assert 0.1 < farthest(bent.positions, rigid.positions) * ratio < 0.4  # 0.17 to 0.25 m seen


def test_a_ratio_beyond_rounding_is_refused_with_its_reason() -> None:
    """Hard: at 5e8, rounding of the stiff half's forces exceeds the tolerance that the soft half sets. Right: a refusal
    that tells the residual left, with the posture of a rigid half all the same."""
    with pytest.raises(SolveError, match=r"no equilibrium: (stalled|iteration_limit) .* residual") as caught:
        half_stiff(1e10)
    _, rigid = half_stiff(1e5)
    assert caught.value.report.residual < 1e-6 * caught.value.report.force_scale
    assert farthest(caught.value.posture.positions, rigid.positions) < 1e-7


def test_tissue_of_hardly_any_stiffness() -> None:
    """Hard: the tissue beyond a stiff half has a ten-thousandth, then a millionth of its shear stiffness at the same
    bulk modulus: a fluid. Right: the shape of the stiff half has a limit."""
    bar = layered_bar(["stiff"] * 4 + [""] * 4)

    def shape(ratio: float) -> np.ndarray:
        scene = Scene(
            bar,
            fixed=["left"],
            gravity=None,
            tissue=yeoh(1037.0 / ratio, 486.0 / ratio, 1.037e6),
            stiffening=Stiffening(gains={"stiff": (ratio - 1.0) / 0.01}),
        )
        posture = scene.equilibrate({"stiff": 0.5}, loads={"at stiff": (0.0, 0.0, -0.005)})
        sound(posture)
        return posture.node_set("at stiff")

    shapes = [shape(ratio) for ratio in (1e2, 1e4, 1e6)]
    assert farthest(shapes[1], bar.nodes[bar.node_sets["at stiff"]]) > 5e-4
    assert farthest(shapes[1], shapes[2]) < 0.05 * farthest(shapes[0], shapes[1])


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_springs_of_the_hyoid_from_loose_to_rigid(factor: float) -> None:
    """Hard: springs a millionth or a million times as stiff as the paper's share a matrix with the tissue. Right: the
    rigid limit is a fixed hyoid, the loose one a free bone."""

    def shape(times: float, hyoid: str = "mobile") -> np.ndarray:
        body = hyoid_block(220.0 * times, muscles={"upper": 2.0})
        posture = Scene(body, fixed=["right"], hyoid=hyoid).equilibrate({"upper": 0.7})
        sound(posture)
        return posture.positions

    limit = shape(1.0, "fixed") if factor > 1.0 else shape(1e-9)
    share = 1.0 / factor if factor > 1.0 else factor
    assert farthest(shape(factor), limit) < 0.5 * share  # m: in proportion to what is left of the springs, or of give
    assert farthest(shape(1.0), limit) > 1e-3


# Starts from other tissue

BENT = {"right": (-0.012, 0.0, 0.003)}


@pytest.mark.parametrize("times", [1e-6, 1e-3, 4.0, 1e3, 1e6])
def test_start_from_a_posture_of_other_tissue(times: float) -> None:
    """Hard: pressures of up to 10^9 Pa that balance forces which the tissue here has not; brought along they made the
    first tangent indefinite beyond every shift. Right: the posture of the same tissue from rest."""
    body = block((6, 4, 4), muscles={"upper": 6.0, "lower": 6.0})
    scene = Scene(body, fixed=["left"])
    tissue = Yeoh(1037.0 * times, 486.0 * times)
    other = Scene(body, fixed=["left"], tissue=tissue, gravity=None).equilibrate(prescribed=BENT)
    assert other.pressure is not None
    assert np.abs(other.pressure).max() > 1e3 * times
    for prescribed in (BENT, {}):
        found = scene.equilibrate({"upper": 0.8}, start=other, prescribed=prescribed)
        sound(found)
        assert farthest(found.positions, scene.equilibrate({"upper": 0.8}, prescribed=prescribed).positions) < 1e-7
    movement = scene.simulate({"upper": 0.8}, 0.02, initial=other, accuracy="draft")
    assert movement.report.converged


def test_contact_of_other_tissue_is_left_behind() -> None:
    """Hard: tissue a million times as stiff, pressed onto a floor, leaves 10^6 times the pressure at its points."""
    body = over_floor(block((6, 4, 4)), 5e-4)
    scene = Scene(body, fixed=["left"])
    down = {"right": (0.0, 0.0, -0.001)}
    stiff = Scene(body, fixed=["left"], tissue=Yeoh(1.037e9, 4.86e8)).equilibrate(prescribed=down)
    assert stiff.contact is not None
    assert stiff.contact.pressures.max() > 1e6
    found = scene.equilibrate(start=stiff)
    sound(found)
    assert farthest(found.positions, scene.equilibrate().positions) < 5e-5


def test_start_from_tissue_of_nearly_the_same_stiffness_saves_work(reference: Speaker) -> None:
    """Where only a little differs, contact and pressures are brought along; positions alone need three times as many
    iterations."""
    scene = Scene(reference, mirror=True)
    other = Scene(reference, mirror=True, tissue=Yeoh(1.1 * 1037.0, 1.1 * 486.0)).equilibrate(VOWELS["i"])
    with_pressures = scene.equilibrate(VOWELS["i"], start=other).report
    alone = scene.equilibrate(VOWELS["i"], start=other.positions).report
    assert with_pressures is not None
    assert alone is not None
    assert 2 * with_pressures.iterations <= alone.iterations
