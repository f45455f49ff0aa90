"""What postures and movements say of the error of their mesh, beside the true one on bodies with known limits.

The estimate counts on an error that falls with the size of cells; where it falls with the square it is 1.5 times too
large.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.blocks import FloatArray, block, furnished, hyoid_block, nearest, sheet

from glossa import VOWELS, InputError, MotorCommands, Movement, Posture, Ramp, Scene, Speaker
from glossa.anatomy.division import Division
from glossa.anatomy.hexahedra import gauss_determinants, gauss_gradients
from glossa.data_files import data_path
from glossa.spatial_error import LEAST_JACOBIAN, SpatialError, carried_posture
from glossa.studies import error_bars, observed_order

LIMIT = 24.23
"""Sag of the cantilever P1 at its end on fine meshes, mm, +- 0.04 (shared/reference/solvers)."""

BOX: dict[str, Any] = {
    **dict.fromkeys(("left", "right"), (0.0, None, None)),
    **dict.fromkeys(("front", "back"), (None, 0.0, None)),
    "bottom": (None, None, 0.0),
}


def refined(speaker: Speaker, times: int) -> Speaker:
    return speaker if times == 0 else refined(speaker.refined(), times - 1)


def estimate(scene: Scene, commands: Any = None, **options: Any) -> SpatialError:
    return scene.spatial_error(scene.equilibrate(commands, **options), **options)


def rms(field: FloatArray) -> float:
    return float(np.sqrt((field**2).sum(axis=1).mean()))


def cantilever(speaker: Speaker) -> Scene:
    return Scene(speaker, fixed=["left"])


@pytest.mark.parametrize("cells", [(3, 2, 2), (6, 4, 4), pytest.param((12, 8, 8), marks=pytest.mark.slow)])
def test_sag_of_the_cantilever(cells: tuple[int, int, int]) -> None:
    body = block(cells)
    node = nearest(body, (0.06, 0.02, 0.02))
    error = estimate(cantilever(body))
    true = LIMIT + 1e3 * error.posture.displacements[node, 2]
    assert true > 0.1
    assert 0.5 < -1e3 * error.displacements[node, 2] / true < 2.0  # 1.02, 1.08, 1.06 seen


@pytest.fixture(scope="module")
def sloshing() -> list[SpatialError]:
    """A block in a box, gravity sideways: no edge makes the solution singular. At two sizes of cells, the second half
    the first."""
    bodies = [block((n, n, n)) for n in (2, 4)]
    return [estimate(Scene(body, fixed=[], gravity=(6.0, 0.0, -6.0)), prescribed=BOX) for body in bodies]


def test_smooth_solution(sloshing: list[SpatialError]) -> None:
    fine = Scene(block((16, 16, 16)), fixed=[], gravity=(6.0, 0.0, -6.0)).equilibrate(prescribed=BOX)
    for error in sloshing:
        mine = error.posture
        shared = [nearest(fine.speaker, node) for node in mine.speaker.nodes]
        true = fine.displacements[shared] - mine.displacements
        assert 1.2 < error.root_mean_square / rms(true) < 2.0  # 1.5 by theory; 1.56 and 1.61 seen
        assert rms(error.displacements - true) < 0.75 * rms(true)  # the field, not only its size
        assert error.largest == pytest.approx(np.linalg.norm(error.displacements, axis=1).max())


def test_falls_with_the_square_where_the_solution_is_smooth(sloshing: list[SpatialError]) -> None:
    coarse, fine = (error.root_mean_square for error in sloshing)
    assert 1.7 < math.log2(coarse / fine) < 2.4  # 2.14 seen


def test_falls_with_the_size_at_a_clamped_edge() -> None:
    coarse, fine = (estimate(cantilever(block(cells))).root_mean_square for cells in ((3, 2, 2), (6, 4, 4)))
    assert 0.8 < math.log2(coarse / fine) < 1.5  # 0.98 seen


def test_forces_of_a_muscle() -> None:
    body = block((3, 2, 2), muscles={"axial": 8.0})
    scene, fine = (Scene(one, fixed=["left"], gravity=None) for one in (body, refined(body, 2)))
    error, limit = estimate(scene, {"axial": 0.8}), fine.equilibrate({"axial": 0.8})
    true = limit.forces["axial"] - error.posture.forces["axial"]
    assert true > 0.05  # N
    assert 0.5 < error.forces["axial"] / true < 2.0  # 1.52 seen


@pytest.fixture(scope="module")
def lying() -> SpatialError:
    """A cantilever whose end lies on a floor."""
    return estimate(cantilever(floored()))


def floored() -> Speaker:
    floor = sheet(lambda x, _: np.full_like(x, -0.006), (-0.03, -0.03), (0.1, 0.07))
    return furnished(block((3, 2, 2)), walls={"floor": floor})


def test_contact(lying: SpatialError) -> None:
    fine = cantilever(refined(floored(), 2)).equilibrate()
    true = fine.displacements[: len(lying.posture.positions)] - lying.posture.displacements
    assert 0.5 < lying.root_mean_square / rms(true) < 2.0  # 1.85 seen: the fine mesh has an error of its own
    assert fine.contact is not None
    assert lying.posture.contact is not None
    assert lying.touched_areas["floor"] > 0.0
    assert fine.contact.touched_areas["floor"] > lying.posture.contact.touched_areas["floor"]


@pytest.mark.parametrize("cells", [(3, 2, 2), pytest.param((6, 4, 4), marks=pytest.mark.slow)])
def test_where_the_mesh_is_too_coarse(cells: tuple[int, int, int]) -> None:
    """Recovered gradients against those of a mesh four times as fine: size, order of the hexahedra, and place."""
    body = block(cells)
    finer = body.refined()
    mine, finest = (cantilever(one).equilibrate() for one in (body, finer.refined()))
    first, second = Division(body, finer), Division(finer, finest.speaker)
    carried = second.carried(first.carried(mine.displacements))
    gradients = gauss_gradients(finest.speaker.nodes, finest.displacements - carried, finest.speaker.hexahedra)
    squared = np.einsum(
        "mpab,mpab,mp->m",
        gradients,
        gradients,
        gauss_determinants(finest.speaker.nodes, finest.speaker.hexahedra),
    )
    true = squared[second.children].sum(axis=1)[first.children].sum(axis=1)
    found = mine.strain_errors**2 * body.element_volumes
    assert 0.5 < math.sqrt(found.sum() / true.sum()) < 2.0  # 0.85 and 0.90 seen
    ranks = [np.argsort(np.argsort(values)) for values in (found, true)]
    assert float(np.corrcoef(ranks[0], ranks[1]).min()) > 0.8
    x = body.nodes[body.hexahedra].mean(axis=1)[:, 0]
    assert (x[np.argsort(mine.strain_errors)[-len(x) // 6 :]] < 0.02).all()  # at the clamped end


# Same in a half, from a file, with what else was prescribed


def test_half_and_whole_say_the_same() -> None:
    body = block((4, 4, 2), (0.04, 0.02, 0.02), centred=True, muscles={"axial": 4.0})
    whole, half = (estimate(Scene(body, fixed=["left"], mirror=mirror), {"axial": 0.8}) for mirror in (False, True))
    assert np.allclose(half.displacements, whole.displacements, rtol=0.0, atol=1e-4 * whole.largest)
    assert half.forces["axial"] == pytest.approx(whole.forces["axial"], rel=1e-4)


def test_posture_from_a_file(lying: SpatialError, tmp_path: Path) -> None:
    lying.posture.save(tmp_path / "a.nc")
    scene = cantilever(floored())
    again = scene.spatial_error(Posture.load(tmp_path / "a.nc", scene.speaker))
    assert np.allclose(again.displacements, lying.displacements, rtol=0.0, atol=1e-3 * lying.largest)


def test_prescribed_nodes_are_carried_over() -> None:
    body = block((4, 2, 2))
    scene = Scene(body, fixed=["left"], gravity=None)
    x, y, _ = body.nodes[body.node_sets["right"]].T
    lift = np.array([[None, None, 0.002 + 0.1 * (side - 0.02)] for side in y.tolist()], dtype=object)
    error = estimate(scene, prescribed={"right": lift})
    finer = error.finer
    ends = finer.speaker.node_sets["right"]
    expected = 0.002 + 0.1 * (finer.speaker.nodes[ends, 1] - 0.02)
    assert finer.displacements[ends, 2] == pytest.approx(expected, abs=1e-12)
    assert np.abs(finer.displacements[ends, 0]).max() > 1e-6  # free
    assert np.abs(error.displacements[body.node_sets["right"], 2]).max() < 1e-12
    assert x.min() == pytest.approx(0.06)


def test_loads_are_carried_over() -> None:
    load = {"right": (0.0, 0.0, -0.05)}
    error = estimate(Scene(block((4, 2, 2)), fixed=["left"], gravity=None), loads=load)
    assert error.finer.reactions("left") == pytest.approx([0.0, 0.0, 0.05], abs=1e-6)


# Movements

BENT, SILENT = MotorCommands({"upper": 0.85}), MotorCommands({"upper": 1.2})


@pytest.fixture(scope="module")
def bending() -> Scene:
    return Scene(block((3, 2, 2), muscles={"upper": 2.0}), fixed=["left"], gravity=None)


@pytest.fixture(scope="module")
def movement(bending: Scene) -> Movement:
    return bending.simulate(Ramp(BENT), 0.5)


def test_movement_settles_to_the_error_of_the_posture(bending: Scene, movement: Movement) -> None:
    error = bending.spatial_error_of_movement(movement)
    assert error.largest[0] == 0.0
    assert len(error.largest) == len(movement.times)
    end, static = error.at(0.5), estimate(bending, BENT)
    assert rms(end.displacements - static.displacements) < 0.05 * static.root_mean_square
    assert end.forces["upper"] == pytest.approx(static.forces["upper"], rel=0.05)


def test_movement_on_a_hyoid() -> None:
    """Half a body that hangs on a bone between walls."""
    scene = Scene(hyoid_block(between_walls=True, muscles={"axial": 2.0}), mirror=True, fixed=[])
    moved = scene.simulate(Ramp(MotorCommands({"axial": 0.9})), 0.02)
    error = scene.spatial_error_of_movement(moved)
    assert error.largest[0] < 1e-9
    assert error.largest[-1] > 1e-6
    assert error.at(0.02).finer.hyoid is not None


def test_movement_from_an_equilibrium(bending: Scene) -> None:
    first = bending.equilibrate(BENT)
    moved = bending.simulate(Ramp(SILENT, start=BENT), 0.05, initial=first)
    error = bending.spatial_error_of_movement(moved)
    static = bending.spatial_error(first)
    assert np.allclose(error.at(0.0).displacements, static.displacements, rtol=0.0, atol=1e-3 * static.largest)
    assert 0.0 < error.largest[-1] < error.largest[0]


def test_a_scene_keeps_its_finer_body(bending: Scene) -> None:
    assert bending.divided() is bending.divided()
    own = bending.speaker.refined()
    other = bending.divided(own)
    assert other.scene.speaker is own
    assert bending.divided(own) is other
    assert bending.divided() is not other


def test_starts_without_folded_hexahedra() -> None:
    """A corner pressed in until the child there would be folded, though no Gauss point of the hexahedron is."""
    body = block((1, 1, 1), (0.01, 0.01, 0.01))
    scene = Scene(body, fixed=["left"], gravity=None)
    rest = scene.equilibrate()
    corner = nearest(body, (0.01, 0.01, 0.01))
    pressed = np.array(body.nodes)
    pressed[corner] -= 0.0048
    assert (gauss_determinants(pressed, body.hexahedra) > 0.0).all()
    divided = scene.divided()
    finer = divided.scene.speaker
    folded = finer.nodes + divided.division.carried(pressed - body.nodes)
    assert (gauss_determinants(folded, finer.hexahedra) < 0.0).any()
    start = carried_posture(replace(rest, positions=pressed), divided)
    ratios = gauss_determinants(start.positions, finer.hexahedra) / gauss_determinants(finer.nodes, finer.hexahedra)
    assert ratios.min() >= LEAST_JACOBIAN
    share = start.displacements[divided.division.nodes[corner]] / (pressed - body.nodes)[corner]
    assert 0.5 < share[0] < 1.0
    whole = carried_posture(rest, divided)
    assert np.array_equal(whole.displacements[divided.division.nodes], rest.displacements)


# What goes wrong


def test_refusals(bending: Scene, movement: Movement, tmp_path: Path) -> None:
    posture = bending.equilibrate(BENT)
    with pytest.raises(InputError, match="moment of a movement is no equilibrium"):
        bending.spatial_error(movement.at(0.5))
    with pytest.raises(InputError, match="posture must be a Posture"):
        bending.spatial_error(movement)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="movement must be a Movement"):
        bending.spatial_error_of_movement(posture)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="finer must be a Speaker"):
        bending.spatial_error(posture, finer=2)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="in eight has 96 hexahedra"):
        bending.spatial_error(posture, finer=bending.speaker)
    loaded = bending.equilibrate(BENT, loads={"right": (0.0, 0.0, 0.1)})
    with pytest.raises(InputError, match=r"pass prescribed and loads as they were \(solved again it moves by"):
        bending.spatial_error(loaded)
    other = Scene(block((4, 2, 2), muscles={"upper": 2.0}), fixed=["left"])
    for call in (lambda: other.spatial_error(posture), lambda: other.spatial_error_of_movement(movement)):
        with pytest.raises(InputError, match="belongs to another speaker"):
            call()
    movement.save(tmp_path / "m.nc")
    with pytest.raises(InputError, match="does not know its commands"):
        bending.spatial_error_of_movement(Movement.load(tmp_path / "m.nc", bending.speaker))
    on = bending.start(Ramp(BENT))
    on.run(0.01)
    with pytest.raises(InputError, match="must begin at time 0"):
        bending.spatial_error_of_movement(on.run(0.02))
    pushed = bending.simulate(Ramp(BENT), 0.01, initial=posture)
    with pytest.raises(InputError, match="does not begin in an equilibrium"):
        bending.spatial_error_of_movement(pushed)


# The tongue


@pytest.mark.slow
def test_pb(pb: Speaker) -> None:
    """Divided on the same planes; bent hexahedra beside the molars would be folded by that."""
    error = estimate(Scene(pb, mirror=True), VOWELS["i"])
    assert 0.3e-3 < error.root_mean_square < 4e-3
    assert abs(error.forces["GGp"]) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("vowel", ["i", "ə", "u", "a"])
def test_vowels(reference: Speaker, vowel: str) -> None:
    """Against the limits that resolutions 1, 2 and 3 of the committed study tend to."""
    with xr.open_dataset(data_path("results/resolution.nc"), engine="h5netcdf") as opened:
        study = opened.load()
    error = estimate(Scene(reference, mirror=True), VOWELS[vowel])
    assert error.finer.speaker.fingerprint == Speaker.reference(2).fingerprint
    first, second = (float(change) for change in study.change_rms.sel(vowel=vowel)[1:])
    true = first / (1.0 - 2.0 ** -observed_order((1, 2, 3), first, second))
    assert 0.5 < 1e3 * error.root_mean_square / true < 2.0  # 1.26, 0.87, 1.00, 0.55 seen
    bars = error_bars(study, "forces").sel(vowel=vowel)
    large = np.flatnonzero((bars.limit > 1.0) & np.isfinite(bars.order))
    for muscle in bars.muscle.values[large].tolist():
        true = float(bars.limit.sel(muscle=muscle)) - float(study.forces.sel(vowel=vowel, muscle=muscle)[0])
        if abs(true) > 0.05 * float(bars.limit.sel(muscle=muscle)):
            assert 0.5 < error.forces[muscle] / true < 2.0, muscle
