"""Postures and movements: types, shapes and units of section 9 of the design, files, tables and interpolation."""

from __future__ import annotations

import json
import pickle
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from tests.blocks import block

from glossa import InputError, MotorCommands, Movement, Posture, Ramp, Scene, SolveReport, Speaker

COMMANDS = MotorCommands({"lower": 0.95, "upper": 0.85})


@pytest.fixture(scope="module")
def body() -> Speaker:
    plain = block((4, 2, 2), muscles={"upper": 2.0, "lower": 1.0})
    return Speaker(
        plain.nodes,
        plain.hexahedra,
        muscles=dict(plain.muscles),
        node_sets=dict(plain.node_sets),
        contours={"crest": [2, 11, 20]},
        name="two muscles",
    )


@pytest.fixture(scope="module")
def scene(body: Speaker) -> Scene:
    return Scene(body, fixed=["left"])


@pytest.fixture(scope="module")
def posture(scene: Scene) -> Posture:
    return scene.equilibrate(COMMANDS)


@pytest.fixture(scope="module")
def movement(scene: Scene) -> Movement:
    return scene.simulate(Ramp(COMMANDS), 0.04, dt=0.004)


FIELDS = ("positions", "activations", "fibre_forces", "pressure", "stiffening", "support_forces")


def assert_equal_postures(a: Posture, b: Posture) -> None:
    assert a.tissue == b.tissue
    for name in FIELDS:
        first, second = getattr(a, name), getattr(b, name)
        assert (first is None) == (second is None)
        if first is not None:
            assert first.dtype == second.dtype == np.float64
            assert np.array_equal(first, second)
    assert a.commands == b.commands
    assert a.report == b.report
    assert a.time == b.time


class TestPosture:
    def test_shapes(self, posture: Posture, body: Speaker) -> None:
        n, m, f = len(body.nodes), len(body.hexahedra), 6
        shapes = [(n, 3), (f,), (f,), (m,), (m,), (n, 3)]
        assert [getattr(posture, name).shape for name in FIELDS] == shapes
        assert all(getattr(posture, name).dtype == np.float64 for name in FIELDS)
        assert posture.speaker is body
        assert posture.commands == COMMANDS
        assert posture.time is None
        assert posture.contact is None
        assert np.array_equal(posture.displacements, posture.positions - body.nodes)

    def test_forces(self, posture: Posture) -> None:
        assert isinstance(posture.forces, pd.Series)
        assert posture.forces.index.tolist() == ["upper", "lower"]
        assert posture.forces.dtype == np.float64
        upper, lower = posture.fibre_slice("upper"), posture.fibre_slice("lower")
        assert (upper, lower) == (slice(0, 3), slice(3, 6))
        assert posture.forces["upper"] == pytest.approx(posture.fibre_forces[upper].sum(), rel=1e-15)
        assert posture.forces["lower"] == pytest.approx(posture.fibre_forces[lower].sum(), rel=1e-15)
        assert posture.forces.min() > 1e-3
        assert (posture.forces < [2.0, 1.0]).all()
        with pytest.raises(InputError, match="no muscle 'GGp'; this speaker has upper, lower"):
            posture.fibre_slice("GGp")

    def test_sizes_are_si(self, posture: Posture, body: Speaker) -> None:
        """Metres, newtons, pascals: sizes that a block of 6 cm of soft tissue must have."""
        assert 1e-3 < np.abs(posture.displacements).max() < 0.06
        assert 1e-4 < posture.activations.max() < 0.02
        assert np.asarray(posture.stiffening).min() >= 1.0
        # The pressure is that of the mean dilatation of each element.
        report = posture.report
        assert report is not None
        assert np.abs(np.asarray(posture.pressure)).max() < 2e4
        deformed = Speaker(posture.positions, body.hexahedra).element_volumes
        dilatation = deformed / body.element_volumes - 1.0
        kappa = 4.0 * 1037.0 * 1.499 / (3.0 * 0.002)
        assert posture.pressure == pytest.approx(kappa * dilatation, abs=1e-3 * kappa * np.abs(dilatation).max())

    def test_node_sets(self, posture: Posture, body: Speaker) -> None:
        assert posture.node_set("right").shape == (9, 3)
        assert np.array_equal(posture.node_set("left"), body.nodes[body.node_sets["left"]])
        assert np.array_equal(posture.node_set("crest"), posture.positions[[2, 11, 20]])
        for ask in (posture.node_set, posture.reactions):
            with pytest.raises(InputError, match=r"no node set 'jaw'; this speaker has left, right, .*, crest"):
                ask("jaw")

    def test_reactions(self, posture: Posture, body: Speaker) -> None:
        reaction = posture.reactions("left")
        assert reaction.shape == (3,)
        weight = 1040.0 * body.volume * 9.81
        assert reaction == pytest.approx([0.0, 0.0, weight], abs=1e-6)
        assert posture.reactions("right").tolist() == [0.0, 0.0, 0.0]

    def test_report(self, posture: Posture) -> None:
        report = posture.report
        assert isinstance(report, SolveReport)
        assert report.converged is True
        assert report.status == "converged"
        assert report.residual <= 1e-8 * report.force_scale
        assert 1 <= report.iterations <= 20
        assert report.factorisations >= report.iterations
        assert report.residuals > report.iterations
        assert 0.3 < report.least_jacobian < 1.5
        assert len(report.residuals_by_iteration) >= report.iterations
        assert {"elasticity", "muscles", "assembly", "factorisation", "solve", "total"} <= set(report.seconds)
        assert report.seconds["total"] >= max(v for k, v in report.seconds.items() if k != "total")
        assert json.loads(json.dumps(report.as_dict()))["status"] == "converged"

    def test_frozen(self, posture: Posture) -> None:
        with pytest.raises(FrozenInstanceError):
            posture.positions = np.zeros((3, 3))  # type: ignore[misc]

    def test_file(self, posture: Posture, body: Speaker, scene: Scene, tmp_path: Path) -> None:
        for name, one in (("full", posture), ("silent", scene.equilibrate()), ("bare", bare(body))):
            one.save(tmp_path / f"{name}.nc")
            assert_equal_postures(Posture.load(tmp_path / f"{name}.nc", one.speaker), one)
        data = xr.open_dataset(tmp_path / "full.nc", engine="h5netcdf")
        with data:
            assert data["positions"].attrs["units"] == "m"
            assert data["fibre_forces"].attrs["units"] == "N"
            assert data["pressure"].attrs["units"] == "Pa"

    def test_pickle(self, posture: Posture) -> None:
        copy = pickle.loads(pickle.dumps(posture))
        assert_equal_postures(copy, posture)
        assert copy.forces.equals(posture.forces)
        assert copy.speaker.fingerprint == posture.speaker.fingerprint

    def test_meshio(self, posture: Posture, body: Speaker, tmp_path: Path) -> None:
        meshio = pytest.importorskip("meshio")
        mesh = posture.to_meshio()
        assert np.array_equal(mesh.points, posture.positions)
        assert np.array_equal(mesh.cells_dict["hexahedron"], body.hexahedra)
        mesh.write(tmp_path / "posture.vtu")
        back = meshio.read(tmp_path / "posture.vtu")
        assert np.array_equal(back.point_data["displacement_m"], posture.displacements)
        assert np.array_equal(back.cell_data["pressure_Pa"][0], np.asarray(posture.pressure))
        assert np.array_equal(back.cell_data["stiffening"][0], np.asarray(posture.stiffening))

    def test_warm_start(self, scene: Scene, posture: Posture) -> None:
        again = scene.equilibrate(COMMANDS, start=posture)
        assert again.report is not None
        assert again.report.iterations <= 1
        assert again.positions == pytest.approx(posture.positions, abs=1e-7)
        from_array = scene.equilibrate(COMMANDS, start=posture.positions)
        assert from_array.positions == pytest.approx(posture.positions, abs=1e-7)


def bare(body: Speaker) -> Posture:
    """Of a body without muscles."""
    speaker = Speaker(body.nodes, body.hexahedra, node_sets=dict(body.node_sets))
    posture = Scene(speaker, fixed=["left"]).equilibrate()
    assert posture.activations.shape == posture.fibre_forces.shape == (0,)
    return posture


class TestMovement:
    def test_shapes(self, movement: Movement, body: Speaker) -> None:
        t, n = len(movement.times), len(body.nodes)
        assert movement.positions.shape == movement.velocities.shape == (t, n, 3)
        assert movement.activations.shape == movement.fibre_forces.shape == (t, 6)
        assert movement.times[0] == 0.0
        assert movement.times[-1] == pytest.approx(0.04, abs=1e-12)
        assert (np.diff(movement.times) > 0.0).all()
        assert np.array_equal(movement.positions[0], body.nodes)
        assert not movement.velocities[0].any()
        assert movement.report.steps == t - 1
        assert movement.report.converged

    @pytest.mark.parametrize("count", [1, 2, 3, 4])
    def test_any_number_of_fibres(self, count: int) -> None:
        plain = block((3, 2, 2), muscles={"axial": 1.0})
        muscle = plain.muscles["axial"]
        few = type(muscle)(muscle.elements, muscle.fibres[:count], 1.0)
        speaker = Speaker(plain.nodes, plain.hexahedra, muscles={"few": few}, node_sets=dict(plain.node_sets))
        found = Scene(speaker, fixed=["left"]).simulate({"few": 0.9}, 0.01, dt=0.005)
        assert found.activations.shape == (3, count)

    def test_forces(self, movement: Movement) -> None:
        forces = movement.forces
        assert isinstance(forces, pd.DataFrame)
        assert forces.columns.tolist() == ["upper", "lower"]
        assert forces.index.name == "time_s"
        assert np.array_equal(forces.index.to_numpy(), movement.times)
        assert np.allclose(forces["upper"], movement.fibre_forces[:, :3].sum(axis=1), rtol=1e-15)
        assert forces.iloc[0].max() < 1e-12  # lambda at rest length, but for rounding
        assert forces.iloc[-1].min() > 1e-3

    def test_velocities_are_rates_of_positions(self, scene: Scene) -> None:
        found = scene.simulate(Ramp(COMMANDS), 0.04, dt=0.0005)
        rates = np.diff(found.positions, axis=0) / np.diff(found.times)[:, None, None]
        mean = 0.5 * (found.velocities[1:] + found.velocities[:-1])
        assert np.abs(rates).max() > 0.02
        assert rates == pytest.approx(mean, abs=2e-2 * np.abs(rates).max())  # 0.8 % seen

    def test_at(self, movement: Movement) -> None:
        for k in (0, 3, len(movement.times) - 1):
            frame = movement.at(float(movement.times[k]))
            assert np.allclose(frame.positions, movement.positions[k], rtol=0, atol=1e-15)
            assert np.allclose(frame.fibre_forces, movement.fibre_forces[k], rtol=1e-12, atol=0)
        assert isinstance(frame, Posture)
        assert frame.time == movement.times[-1]
        assert frame.pressure is None
        assert frame.forces["upper"] == pytest.approx(movement.forces["upper"].iloc[-1])
        with pytest.raises(InputError, match="a moment of a movement; support forces exist for equilibria only"):
            frame.reactions("left")

    @pytest.mark.parametrize("time", [-0.001, 0.0401, float("nan")])
    def test_at_another_time(self, movement: Movement, time: float) -> None:
        with pytest.raises(InputError, match=r"time must lie between 0 s and 0.04 s"):
            movement.at(time)

    def test_interpolation(self, movement: Movement, body: Speaker) -> None:
        """Positions are cubic between steps, forces linear: such movements are reproduced."""
        t = np.array([0.0, 0.002, 0.005, 0.011])
        way = np.random.default_rng(0).normal(size=(4, len(body.nodes), 3))
        powers = np.stack([t**k for k in range(4)])
        rates = np.stack([k * t ** max(k - 1, 0) for k in range(4)])
        made = Movement(
            speaker=body,
            times=t,
            positions=np.einsum("kt,kni->tni", powers, way),
            velocities=np.einsum("kt,kni->tni", rates, way),
            activations=np.outer(t, np.arange(6.0)),
            fibre_forces=np.outer(t, np.ones(6)),
            report=movement.report,
        )
        for time in (0.0, 0.0007, 0.002, 0.0041, 0.0109, 0.011):
            between = made.at(time)
            assert between.positions == pytest.approx(np.einsum("k,kni->ni", time ** np.arange(4.0), way), abs=1e-15)
            assert between.fibre_forces == pytest.approx(np.full(6, time))
            assert between.activations == pytest.approx(time * np.arange(6.0))

    def test_xarray(self, movement: Movement) -> None:
        data = movement.to_xarray()
        assert dict(data.sizes) == {"time": len(movement.times), "node": 45, "axis": 3, "muscle": 2, "fibre": 6}
        units = {name: data[name].attrs["units"] for name in data.data_vars}
        assert units == {"positions": "m", "velocities": "m/s", "forces": "N", "activations": "m", "fibre_forces": "N"}
        assert data["time"].attrs["units"] == "s"
        assert data["axis"].values.tolist() == ["x", "y", "z"]
        assert np.allclose(data["forces"].sel(muscle="lower"), movement.forces["lower"])
        heights = data["positions"].sel(axis="z").isel(node=44)
        assert np.array_equal(heights, movement.positions[:, 44, 2])

    def test_file(self, movement: Movement, body: Speaker, tmp_path: Path) -> None:
        movement.save(tmp_path / "movement.nc")
        assert_equal_movements(Movement.load(tmp_path / "movement.nc", body), movement)

    def test_pickle(self, movement: Movement) -> None:
        copy: Any = pickle.loads(pickle.dumps(movement))
        assert_equal_movements(copy, movement)
        assert copy.forces.equals(movement.forces)


def assert_equal_movements(a: Movement, b: Movement) -> None:
    assert a.tissue == b.tissue
    for name in ("times", "positions", "velocities", "activations", "fibre_forces"):
        assert np.array_equal(getattr(a, name), getattr(b, name))
    assert a.report == b.report


def test_simulation_shows_the_present(scene: Scene) -> None:
    simulation = scene.start(Ramp(COMMANDS), dt=0.002)
    assert simulation.step(0.02) == pytest.approx(0.02)
    present = simulation.posture
    assert present.time == simulation.time
    assert np.array_equal(present.positions, simulation.positions)
    assert present.commands == Ramp(COMMANDS).at(simulation.time)
    assert present.forces.max() > 0.0
    assert simulation.velocities.shape == simulation.positions.shape
    assert simulation.kinetic_energy > 0.0
    assert simulation.potential_energy != 0.0
    assert simulation.report.steps == 11  # 0 .. 17 .. 20 ms


def test_effects_and_cost(scene: Scene) -> None:
    everything = ("elasticity", "muscles", "stiffening", "reflex", "force_velocity", "gravity", "damping")
    assert scene.effects == everything
    assert "elasticity, muscles" in repr(scene)
    scene.equilibrate()
    cost = scene.cost()
    assert isinstance(cost, pd.Series)
    assert cost["total"] > 0.0
    parts = cost.drop("total")
    assert (parts >= 0.0).all()
    assert 0.0 < parts.sum() <= 1.05 * cost["total"]
