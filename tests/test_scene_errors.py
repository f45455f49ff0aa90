"""What scenes refuse and how failed solves end, through the public names."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block

from glossa import (
    Damping,
    InputError,
    MotorCommands,
    Movement,
    Posture,
    Ramp,
    Reflex,
    Scene,
    Schedule,
    SolveError,
    Speaker,
    Stiffening,
    Yeoh,
)


@pytest.fixture(scope="module")
def body() -> Speaker:
    return block((4, 2, 2), muscles={"upper": 2.0, "lower": 2.0})


@pytest.fixture(scope="module")
def scene(body: Speaker) -> Scene:
    return Scene(body, fixed=["left"])


# Options of a scene

OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"gravity": "sideways"}, "gravity must be 'upright', 'supine', None or three numbers in m/s2, got 'sideways'"),
    ({"gravity": (0.0, 1.0)}, "gravity must be three finite numbers"),
    ({"gravity": (0.0, math.nan, 0.0)}, "gravity must be three finite numbers"),
    ({"gravity": [[1], [2, 3]]}, "gravity must be"),
    ({"gravity": 9.81}, "gravity must be three finite numbers"),
    ({"contact": True}, "contact=True: this speaker has no walls"),
    ({"contact": "yes"}, "contact must be True or False, got 'yes'"),
    ({"friction": -0.1}, "friction must lie between 0 and 10, got -0.1"),
    ({"friction": math.nan}, "friction must be finite, got nan"),
    ({"friction": "low"}, "friction must be a number, got 'low'"),
    ({"hyoid": "mobile"}, "hyoid='mobile': this speaker has no hyoid"),
    ({"hyoid": "fixed"}, "hyoid='fixed': this speaker has no node set 'hyoid'"),
    ({"hyoid": "loose"}, "hyoid must be one of 'mobile', 'fixed', got 'loose'"),
    ({"hyoid": True}, "hyoid must be one of"),
    ({"stiffening": 10.0}, "stiffening must be True, False or Stiffening, got 10.0"),
    ({"stiffening": Stiffening(gains={"GGp": 5.0})}, "stiffening: unknown muscle 'GGp'; this speaker has upper, lower"),
    ({"reflex": 0.017}, "reflex must be a Reflex or None, got 0.017"),
    ({"reflex": True}, "reflex must be a Reflex or None, got True"),
    ({"force_velocity": 1}, "force_velocity must be True or False, got 1"),
    ({"force_velocity": None}, "force_velocity must be True or False, got None"),
    ({"damping": (40.0, 0.03)}, "damping must be a Damping or None"),
    ({"tissue": None}, "tissue must be a Yeoh, got None"),
    ({"tissue": 1037.0}, "tissue must be a Yeoh, got 1037.0"),
    ({"element": "Q3"}, "element must be one of 'Q1P0', 'Q1', 'Q2P1', got 'Q3'"),
    ({"element": None}, "element must be one of"),
    ({"mirror": "yes"}, "mirror must be True or False, got 'yes'"),
    ({"mirror": True}, "mirror image about y = 0"),
    ({"fixed": "left"}, "fixed must be a sequence of node set names, got the string 'left'"),
    ({"fixed": ["left", "elsewhere"]}, "fixed: no node set 'elsewhere'; this speaker has left, right"),
    ({"firing_gradient": 0.0}, "firing gradient must be positive, got 0.0"),
    ({"firing_gradient": math.inf}, "firing gradient must be finite, got inf"),
    ({"threads": 0}, "threads must be a whole number from 1 to 256, got 0"),
    ({"threads": 2.0}, "threads must be a whole number from 1 to 256, got 2.0"),
    ({"threads": True}, "threads must be a whole number from 1 to 256, got True"),
    ({"threads": 1000}, "threads must be a whole number from 1 to 256, got 1000"),
]


@pytest.mark.parametrize(("options", "message"), OPTIONS, ids=[str(options) for options, _ in OPTIONS])
def test_options(body: Speaker, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Scene(body, **{"fixed": ["left"], **options})
    assert message in str(caught.value)


PARAMETERS: list[tuple[Callable[[], Any], str]] = [
    (lambda: Yeoh(0.0), "tissue c10 must be positive, got 0.0"),
    (lambda: Yeoh(-1.0), "tissue c10 must be positive"),
    (lambda: Yeoh(math.nan), "tissue c10 must be finite"),
    (lambda: Yeoh(1037.0, -1.0), "tissue c20 must not be negative"),
    (lambda: Yeoh(poissons_ratio=0.5), "Poisson's ratio must be at least 0 and below 0.5, got 0.5"),
    (lambda: Yeoh(poissons_ratio=-0.1), "Poisson's ratio must be"),
    (lambda: Yeoh(poissons_ratio=math.nan), "Poisson's ratio must be finite"),
    (lambda: Yeoh(density=0.0), "tissue density must be positive"),
    (lambda: Yeoh("soft"), "tissue c10 must be a number"),  # type: ignore[arg-type]
    (lambda: Reflex(delay=-0.001), "reflex delay must not be negative"),
    (lambda: Reflex(delay=math.nan), "reflex delay must be finite"),
    (lambda: Reflex(velocity_gain=-1.0), "reflex velocity gain must not be negative"),
    (lambda: Damping(alpha=-1.0), "damping alpha must not be negative"),
    (lambda: Damping(beta=math.inf), "damping beta must be finite"),
    (lambda: Stiffening(peak_multiplier=0.5), "peak multiplier must be at least 1, got 0.5"),
    (lambda: Stiffening(gains={"GGp": -1.0}), "stiffening gain of 'GGp' must not be negative"),
]


@pytest.mark.parametrize(("make", "message"), PARAMETERS, ids=[message for _, message in PARAMETERS])
def test_parameters(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert message in str(caught.value)


def test_not_a_speaker() -> None:
    with pytest.raises(InputError, match="speaker must be a Speaker, got str"):
        Scene("reference")  # type: ignore[arg-type]


def test_notes_say_what_a_speaker_lacks(body: Speaker, reference: Speaker, pb: Speaker) -> None:
    for speaker in (reference, pb):
        everything = Scene(speaker)
        assert everything.notes == ()
        assert {"contact", "friction", "hyoid"} < set(everything.effects)
        assert everything.fixed == ("jaw",)
        bare = Scene(speaker, contact=False, hyoid="fixed")
        assert bare.notes == ()
        assert not {"contact", "friction", "hyoid"} & set(bare.effects)
        assert bare.fixed == ("jaw", "hyoid")
        smooth = Scene(speaker, friction=None)
        assert "contact" in smooth.effects
        assert "friction" not in smooth.effects
    assert Scene(body, fixed=["left"]).notes == ("no wall contact: the speaker has no walls",)
    boneless = Speaker(
        pb.nodes,
        pb.hexahedra,
        muscles=dict(pb.muscles),
        node_sets=dict(pb.node_sets),
        walls=dict(pb.walls),
        contact_faces=dict(pb.contact_faces),
    )
    scene = Scene(boneless)
    assert [note.split(":")[0] for note in scene.notes] == ["the hyoid is fixed"]
    assert scene.fixed == ("jaw", "hyoid")
    with pytest.raises(InputError, match=r"hyoid='mobile': this speaker has no hyoid bone; use hyoid='fixed'"):
        Scene(boneless, hyoid="mobile")


def test_a_mobile_hyoid_cannot_be_held(pb: Speaker) -> None:
    with pytest.raises(InputError, match=r"node \d+ belongs to the hyoid and to the fixed set 'hyoid'"):
        Scene(pb, hyoid="mobile", fixed=["jaw", "hyoid"])
    with pytest.raises(InputError, match="a node of the mobile hyoid cannot be prescribed; use hyoid='fixed'"):
        Scene(pb, mirror=True).equilibrate(prescribed={"hyoid": (0.0, 0.0, 0.001)})


def test_walls_that_move(reference: Speaker) -> None:
    up = {"wall:hard_palate": (0.0, 0.0, 0.001)}
    with pytest.raises(InputError, match="wall 'hard_palate' moves, but this scene has no contact"):
        Scene(reference, contact=False).equilibrate(prescribed=up)
    scene = Scene(reference, mirror=True)
    with pytest.raises(InputError, match="wall 'hard_palate' cannot move sideways"):
        scene.equilibrate(prescribed={"wall:hard_palate": (0.0, 0.001, 0.0)})
    with pytest.raises(InputError, match="no wall 'nose'"):
        scene.equilibrate(prescribed={"wall:nose": (0.0, 0.0, 0.001)})
    contact = scene.equilibrate().contact
    assert contact is not None
    with pytest.raises(InputError, match="no wall 'nose'"):
        contact.at_wall("nose")


# Commands

COMMANDS: list[tuple[Any, str]] = [
    ({"upper": math.nan}, "command of muscle 'upper' must be finite, got nan"),
    ({"upper": math.inf}, "command of muscle 'upper' must be finite"),
    ({"upper": 0.0}, "command of muscle 'upper' must be positive, got 0.0"),
    ({"upper": -0.5}, "command of muscle 'upper' must be positive"),
    ({"upper": "0.9"}, "command of muscle 'upper' must be a number, got '0.9'"),
    ({"upper": True}, "command of muscle 'upper' must be a number, got True"),
    ({"upper": np.array([0.9, 0.8])}, "command of muscle 'upper' must be a number"),
    ({"upper": None}, "command of muscle 'upper' must be a number, got None"),
    ({"GGp": 0.9}, "unknown muscle 'GGp' in the commands; this speaker has upper, lower"),
    ({1: 0.9}, "muscle names must be non-empty strings, got 1"),
    (np.array([0.9, 0.8]), "motor commands must map muscle names to fractions, got ndarray"),
    ([0.9, 0.8], "motor commands must map muscle names to fractions, got list"),
    ("i", "motor commands must map muscle names to fractions, got str"),
]


@pytest.mark.parametrize(("commands", "message"), COMMANDS, ids=[message for _, message in COMMANDS])
def test_commands(scene: Scene, commands: Any, message: str) -> None:
    for solve in (scene.equilibrate, lambda c: scene.simulate(c, 0.01), scene.start):
        with pytest.raises(InputError) as caught:
            solve(commands)
        assert message in str(caught.value)


def test_schedules(scene: Scene) -> None:
    with pytest.raises(InputError, match="unknown muscle 'GGp' in the commands; this speaker has upper, lower"):
        scene.simulate(Ramp(MotorCommands({"GGp": 0.5})), 0.1)
    late = Schedule([0.0, 0.1], [MotorCommands({"upper": 0.9}), MotorCommands({"upper": 1.0})])
    assert scene.simulate(late, 0.002, dt=0.002).times[-1] == 0.002


# Arguments of solves

SOLVES: list[tuple[dict[str, Any], str]] = [
    ({"prescribed": {"nose": (0, 0, 0)}}, "prescribed: no node set 'nose'; this speaker has left, right"),
    ({"prescribed": {"right": (0, 0)}}, "prescribed displacement of 'right': expected shape (3,) or (9, 3), got (2,)"),
    ({"prescribed": {"right": np.zeros((4, 3))}}, "expected shape (3,) or (9, 3), got (4, 3)"),
    ({"prescribed": {"right": (math.nan, 0, 0)}}, "prescribed displacement of 'right': every component must be finite"),
    ({"prescribed": {"right": "up"}}, "prescribed displacement of 'right': expected numbers"),
    ({"prescribed": [1, 2, 3]}, "prescribed must map node sets to displacements, got list"),
    (
        {"prescribed": {"right": (0, 0, 0), "corners": (0, 0, 0.001)}},
        "prescribed displacement of 'corners': node 36 is already prescribed otherwise",
    ),
    ({"loads": {"nose": (0, 0, 0)}}, "loads: no node set 'nose'"),
    ({"loads": {"right": (0, 0)}}, "load on 'right': expected three finite numbers in N, got (0, 0)"),
    ({"loads": {"right": (0, 0, math.inf)}}, "load on 'right': expected three finite numbers in N"),
    ({"loads": {"right": None}}, "load on 'right': expected three finite numbers in N"),
    ({"loads": {"right": "heavy"}}, "load on 'right': expected three numbers in N, got 'heavy'"),
    ({"loads": (0, 0, 1)}, "loads must map node sets to forces, got tuple"),
    ({"start": np.zeros((3, 3))}, "start: positions need shape (45, 3), got (3, 3)"),
    ({"start": np.full((45, 3), math.nan)}, "start: positions must be finite"),
    ({"start": "rest"}, "start must be a Posture or an array of node positions"),
    ({"accuracy": "perfect"}, "accuracy must be one of 'draft', 'standard', 'reference', got 'perfect'"),
    ({"accuracy": 1e-6}, "accuracy must be one of"),
    ({"max_iterations": 0}, "max_iterations must be a whole number from 1 to 100000, got 0"),
    ({"max_iterations": 2.5}, "max_iterations must be a whole number from 1 to 100000, got 2.5"),
    ({"max_iterations": True}, "max_iterations must be a whole number from 1 to 100000, got True"),
]


@pytest.mark.parametrize(("arguments", "message"), SOLVES, ids=[message for _, message in SOLVES])
def test_equilibrate(scene: Scene, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        scene.equilibrate(**arguments)
    assert message in str(caught.value)


MOVEMENTS: list[tuple[dict[str, Any], str]] = [
    ({"until": 0.0}, "the end must lie after the present time"),
    ({"until": -0.1}, "the end must lie after the present time"),
    ({"until": math.nan}, "until must be finite, got nan"),
    ({"until": math.inf}, "until must be finite, got inf"),
    ({"until": "soon"}, "until must be a number, got 'soon'"),
    ({"dt": 0.0}, "dt must be positive, got 0.0 s"),
    ({"dt": -0.001}, "dt must be positive, got -0.001 s"),
    ({"dt": math.nan}, "dt must be finite, got nan"),
    ({"dt": "1 ms"}, "dt must be a number, got '1 ms'"),
    ({"accuracy": "perfect"}, "accuracy must be 'draft', 'standard', 'reference' or a local error in m, got 'perfect'"),
    ({"accuracy": 0.0}, "accuracy must be a positive local error in m, got 0.0"),
    ({"accuracy": math.nan}, "accuracy must be finite, got nan"),
    ({"accuracy": None}, "accuracy must be a number, got None"),
    ({"integrator": "RK4"}, "integrator must be one of 'SDIRK2', 'BDF2', 'backward_euler', 'trapezoidal', got 'RK4'"),
    ({"initial": np.zeros((2, 3))}, "positions need shape (45, 3), got (2, 3)"),
]


@pytest.mark.parametrize(("arguments", "message"), MOVEMENTS, ids=[str(arguments) for arguments, _ in MOVEMENTS])
def test_simulate(scene: Scene, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        scene.simulate({"upper": 0.9}, **{"until": 0.01, **arguments})
    assert message in str(caught.value)


@pytest.mark.parametrize("dt", [0.0, -0.001, math.nan, math.inf, "long", None])
def test_step(scene: Scene, dt: Any) -> None:
    simulation = scene.start({"upper": 0.9})
    with pytest.raises(InputError, match=r"must be (a number|finite|positive)"):
        simulation.step(dt)
    assert simulation.time == 0.0


def test_state(scene: Scene, body: Speaker) -> None:
    simulation = scene.start({"upper": 0.9})
    with pytest.raises(InputError, match="state must come from a simulation, got dict"):
        simulation.state = {"time": 0.0}
    other = Scene(block((3, 2, 2)), fixed=["left"]).start()
    with pytest.raises(InputError, match="state: it belongs to another scene or other muscles"):
        simulation.state = other.state
    with pytest.raises(InputError, match="state: it belongs to another scene or other muscles"):
        simulation.state = scene.start({"upper": 0.9, "lower": 0.9}).state
    assert body is scene.speaker


def test_speakers_do_not_mix(scene: Scene, body: Speaker) -> None:
    foreign = Scene(block((4, 2, 2)), fixed=["left"]).equilibrate()
    with pytest.raises(InputError, match="start: this posture belongs to another speaker"):
        scene.equilibrate(start=foreign)
    with pytest.raises(InputError, match="this posture belongs to another speaker"):
        scene.simulate(None, 0.01, initial=foreign)
    twin: Speaker = pickle.loads(pickle.dumps(body))
    assert twin is not body
    scene.equilibrate(start=Scene(twin, fixed=["left"]).equilibrate())


def test_bodies_that_nothing_holds(body: Speaker) -> None:
    loose = Scene(body)
    assert loose.fixed == ()
    assert any("no node is held" in note for note in loose.notes)
    with pytest.raises(InputError, match=r"free to move rigidly \(6 of 6 rigid motions\).*hold at least three nodes"):
        loose.equilibrate()


def test_cost_before_a_solve(body: Speaker) -> None:
    scene = Scene(body, fixed=["left"])
    with pytest.raises(InputError, match="nothing has been solved in this scene yet"):
        scene.cost()
    scene.equilibrate()
    assert scene.cost()["total"] > 0.0


# Failed solves


def test_iteration_limit(scene: Scene) -> None:
    commands = {"upper": 0.6, "lower": 0.9}
    with pytest.raises(SolveError, match=r"no equilibrium: iteration_limit after .* last good state") as caught:
        scene.equilibrate(commands, max_iterations=1)
    error = caught.value
    assert error.status == "iteration_limit"
    assert error.report.status == "iteration_limit"
    assert not error.report.converged
    assert error.report.residual > 1e-8 * error.report.force_scale
    assert np.isfinite(error.posture.positions).all()
    assert error.report.least_jacobian > 0.0
    finished = scene.equilibrate(commands, start=error.posture)
    assert finished.positions == pytest.approx(scene.equilibrate(commands).positions, abs=1e-8)


def test_inverted_by_force(scene: Scene, body: Speaker) -> None:
    """The whole boundary turned inside out: its volume is negative, whatever is inside."""
    boundary = body.node_sets["boundary"]
    turned = np.outer(body.nodes[boundary, 0], (-2.0, 0.0, 0.0))
    with pytest.raises(SolveError, match="no equilibrium") as caught:
        Scene(body, fixed=[]).equilibrate(prescribed={"boundary": turned})
    error = caught.value
    assert error.status in ("inverted", "indefinite", "stalled", "iteration_limit")
    assert error.report.status == error.status
    assert np.isfinite(error.posture.positions).all()
    assert error.posture.report.least_jacobian > 0.0
    assert scene.equilibrate().positions == pytest.approx(Scene(body, fixed=["left"]).equilibrate().positions, abs=1e-9)


def test_inverted_start(scene: Scene, body: Speaker) -> None:
    mirrored = body.nodes * [1.0, -1.0, 1.0]
    with pytest.raises(SolveError, match="inverted") as caught:
        scene.equilibrate(start=mirrored)
    assert caught.value.status == "inverted"
    with pytest.raises(InputError, match=r"start: hexahedron \d+ is inverted"):
        scene.simulate(None, 0.01, initial=mirrored)  # type: ignore[arg-type]


def test_failed_movement_keeps_what_it_has(body: Speaker) -> None:
    """Tissue without bulk resistance under a hundred times its weight ends in elements without volume."""
    tissue = Yeoh(1.0, 0.0, poissons_ratio=0.0)
    scene = Scene(body, fixed=["left"], tissue=tissue, gravity=(-4000.0, 0.0, 0.0), damping=None)
    simulation = scene.start(None, dt=0.01)
    with pytest.raises(SolveError, match=r"no time step from .* s on could be solved") as caught:
        simulation.run(2.0)
    error = caught.value
    assert error.status == "stalled"
    assert isinstance(error.movement, Movement)
    assert len(error.movement.times) > 1
    assert error.movement.times[-1] == simulation.time == error.posture.time
    assert np.array_equal(error.movement.positions[-1], simulation.positions)
    assert np.isfinite(error.movement.positions).all()
    before = simulation.positions
    with pytest.raises(SolveError):
        simulation.step(0.5)
    assert np.isfinite(simulation.positions).all()
    assert before.shape == simulation.positions.shape


# Foreign files


def test_foreign_files(scene: Scene, body: Speaker, tmp_path: Path) -> None:
    posture, movement = scene.equilibrate({"upper": 0.9}), scene.simulate({"upper": 0.9}, 0.01)
    posture.save(tmp_path / "posture.nc")
    movement.save(tmp_path / "movement.nc")
    with pytest.raises(InputError, match=r"movement.nc holds no posture of glossa"):
        Posture.load(tmp_path / "movement.nc", body)
    with pytest.raises(InputError, match=r"posture.nc holds no movement of glossa"):
        Movement.load(tmp_path / "posture.nc", body)
    other = block((3, 2, 2))
    for kind, name in ((Posture, "posture.nc"), (Movement, "movement.nc")):
        with pytest.raises(InputError, match=rf"{name} belongs to another speaker \('block'\)"):
            kind.load(tmp_path / name, other)
        with pytest.raises(FileNotFoundError, match="no file at"):
            kind.load(tmp_path / "absent.nc", body)
        (tmp_path / "text.nc").write_text("not a data file")
        with pytest.raises(InputError, match=r"text.nc cannot be read as a NetCDF file"):
            kind.load(tmp_path / "text.nc", body)
        xr.Dataset({"x": ("t", [1.0, 2.0])}).to_netcdf(tmp_path / "foreign.nc", engine="h5netcdf")
        with pytest.raises(InputError, match=r"foreign.nc holds no"):
            kind.load(tmp_path / "foreign.nc", body)
        content = (tmp_path / name).read_bytes()
        (tmp_path / "cut.nc").write_bytes(content[: len(content) // 2])
        with pytest.raises(InputError, match=r"cut.nc cannot be read as a NetCDF file"):
            kind.load(tmp_path / "cut.nc", body)
