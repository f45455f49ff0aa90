"""Arguments of public functions, one or two of them hostile: a result, or a refusal in glossa's own words.

``GLOSSA_FUZZ=5000 pytest tests/hard -k fuzz`` tries more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.blocks import block, hyoid_block
from tests.hard.bodies import over_floor
from tests.hard.fuzzing import fuzz, hostile, only_own_errors

from glossa import (
    VOWELS,
    AreaFunction,
    Damping,
    Hyoid,
    Lips,
    MotorCommands,
    Muscle,
    Ramp,
    Reflex,
    Scene,
    Schedule,
    Speaker,
    Spring,
    Stiffening,
    Wall,
    Yeoh,
    studies,
    synthesize,
)
from glossa.tolerances import Tolerances

CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


@cache
def body() -> Speaker:
    return over_floor(block((2, 1, 1), muscles={"upper": 2.0}), 1e-3)


@cache
def scene() -> Scene:
    return Scene(body(), fixed=["left"])


@cache
def mobile() -> Scene:
    return Scene(hyoid_block(muscles={"upper": 2.0}), fixed=["right"])


def chosen(**options: Any) -> Scene:
    return Scene(body(), **{"fixed": ["left"], **options})


def mapped(call: Callable[[dict[Any, Any]], Any]) -> Callable[..., Any]:
    """A call that takes a mapping of one key and one value."""

    def with_mapping(key: Any, value: Any) -> Any:
        try:
            mapping = {key: value}
        except TypeError:  # not hashable: no mapping can hold it
            return None
        return call(mapping)

    return with_mapping


@dataclass(frozen=True)
class Target:
    """A public call and good arguments for it."""

    call: Callable[..., Any]
    good: Mapping[str, Any]


def monte_carlo_points(ranges: Any, n: Any, seed: Any) -> Any:
    """Not more points than a test can bear."""
    return studies.monte_carlo(ranges, n if not isinstance(n, int) or n < 1000 else 1000, seed)


TARGETS: dict[str, Target] = {
    "Yeoh": Target(Yeoh, {"c10": 1037.0, "c20": 486.0, "poissons_ratio": 0.499, "density": 1040.0}),
    "Reflex": Target(Reflex, {"delay": 0.017, "velocity_gain": 0.01}),
    "Damping": Target(Damping, {"alpha": 40.0, "beta": 0.03, "law": "material"}),
    "Stiffening": Target(Stiffening, {"peak_multiplier": 10.0, "gains": {"upper": 3.0}}),
    "Tolerances": Target(Tolerances, {"residual": 1e-8, "gap": 1e-5}),
    "Lips": Target(Lips, {"length": 0.01, "area": 1e-4}),
    "MotorCommands": Target(MotorCommands, {"fractions": {"upper": 0.9}}),
    "a command": Target(mapped(MotorCommands), {"key": "upper", "value": 0.9}),
    "commands changed": Target(VOWELS["i"].scaled, {"muscle": "GGp", "factor": 1.1}),
    "Ramp": Target(
        Ramp,
        {
            "target": MotorCommands({"upper": 0.9}),
            "duration": 0.03,
            "start": MotorCommands({"upper": 1.0}),
            "onset": 0.0,
        },
    ),
    "Schedule": Target(Schedule, {"times": [0.0, 0.1], "commands": [MotorCommands({"upper": x}) for x in (1.0, 0.9)]}),
    "Schedule.through": Target(
        lambda targets, transition, start: Schedule.through(targets, transition=transition, start=start),
        {"targets": [(0.0, MotorCommands({"upper": 0.9}))], "transition": 0.03, "start": None},
    ),
    "Schedule.at": Target(lambda time: Ramp(VOWELS["i"]).at(time), {"time": 0.01}),
    "Wall": Target(Wall, {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}),
    "Spring": Target(
        Spring, {"on_hyoid": [0, 0, 0], "fixed": [0, 0, 1], "stiffness": 220.0, "rest_length": 1.0, "name": "s"}
    ),
    "Hyoid": Target(
        Hyoid, {"surface": None, "mass": 0.002, "centre": [0, 0, 0], "springs": (Spring([0, 0, 0], [0, 0, 1], 220.0),)}
    ),
    "Muscle": Target(Muscle, {"elements": [0], "fibres": [[0, 1]], "force_capacity": 1.0, "fibres_per_element": 4}),
    "Speaker": Target(
        Speaker,
        {
            "nodes": CORNERS,
            "hexahedra": [[0, 1, 2, 3, 4, 5, 6, 7]],
            "muscles": {"m": Muscle([0], [[0, 1]], 1.0)},
            "node_sets": {"jaw": [0, 1, 2]},
            "walls": {"w": Wall([[0, 0, 2], [1, 0, 2], [0, 1, 2]], [[0, 2, 1]])},
            "hyoid": None,
            "contours": {"dorsum": [4, 5]},
            "name": "cube",
            "contact_faces": {},
        },
    ),
    "a node set": Target(
        mapped(lambda sets: Speaker(CORNERS, [range(8)], node_sets=sets)), {"key": "jaw", "value": [0, 1]}
    ),
    "Scene": Target(
        chosen,
        {
            "gravity": "upright",
            "contact": True,
            "friction": 0.1,
            "stiffening": True,
            "reflex": Reflex(),
            "force_velocity": True,
            "damping": Damping(),
            "tissue": Yeoh(),
            "element": "Q1P0",
            "mirror": False,
            "fixed": ["left"],
            "firing_gradient": 40.0,
            "threads": 1,
        },
    ),
    "Scene with a hyoid": Target(
        lambda hyoid, fixed: Scene(mobile().speaker, hyoid=hyoid, fixed=fixed), {"hyoid": "mobile", "fixed": ["right"]}
    ),
    "equilibrate": Target(
        lambda commands, **rest: scene().equilibrate(commands, **rest),
        {
            "commands": {"upper": 0.9},
            "start": None,
            "prescribed": {"right": (0.0, 0.0, 1e-4)},
            "loads": {"top": (0.0, 0.0, -1e-3)},
            "accuracy": "draft",
            "max_iterations": 20,
        },
    ),
    "a prescribed displacement": Target(
        mapped(lambda prescribed: scene().equilibrate(prescribed=prescribed, max_iterations=20)),
        {"key": "right", "value": (0.0, 0.0, 1e-4)},
    ),
    "a wall's displacement": Target(
        lambda value: scene().equilibrate(prescribed={"wall:floor": value}, max_iterations=20), {"value": (0, 0, 1e-4)}
    ),
    "a load": Target(
        mapped(lambda loads: scene().equilibrate(loads=loads, max_iterations=20)),
        {"key": "right", "value": (0.0, 0.0, 1e-3)},
    ),
    "simulate": Target(
        lambda schedule, **rest: scene().simulate(schedule, 0.002, **rest),
        {
            "schedule": MotorCommands({"upper": 0.9}),
            "dt": 1e-3,
            "accuracy": "draft",
            "initial": None,
            "integrator": "BDF2",
        },
    ),
    "step": Target(lambda dt: scene().start().step(dt if _short(dt) else 1e-3), {"dt": 1e-3}),
    "AreaFunction": Target(AreaFunction, {"lengths": [0.01, 0.01], "areas": [1e-4, 2e-4]}),
    "formants": Target(
        lambda n, constants, method: AreaFunction.uniform(0.17, 3e-4).formants(n, constants=constants, method=method),
        {"n": 3, "constants": "badin", "method": "poles"},
    ),
    "synthesize": Target(
        lambda area, f0, **rest: synthesize(area, 120.0 if callable(f0) else f0, **rest),
        {
            "area": AreaFunction.uniform(0.17, 3e-4),
            "f0": 120.0,
            "duration": 0.02,
            "constants": "badin",
            "sampling_rate": 16000,
            "source": "lf",
            "onset": 0.005,
            "offset": 0.005,
            "jitter": 0.0,
            "aspiration": 0.0,
            "seed": None,
        },
    ),
    "monte_carlo": Target(monte_carlo_points, {"ranges": {"command.upper": (0.8, 0.9)}, "n": 2, "seed": 1}),
    "a range": Target(
        mapped(lambda ranges: studies.latin_hypercube(ranges, 3, 1)), {"key": "command.upper", "value": (0.8, 0.9)}
    ),
    "grid": Target(mapped(studies.grid), {"key": "command.upper", "value": [0.8, 0.9]}),
    "Point": Target(
        studies.Point, {"commands": {"upper": 0.9}, "lips": "i", "scene": {}, "shape": {}, "labels": {"a": 1.0}}
    ),
    "an axis": Target(
        mapped(lambda axes: studies.sweep(scene(), studies.grid(axes), {"upper": 0.9})),
        {"key": "command.upper", "value": [0.9]},
    ),
    "run_points": Target(
        lambda points, **rest: studies.run_points(scene(), points, **rest),
        {
            "points": [studies.Point(commands={"upper": 0.9})],
            "store": None,
            "executor": None,
            "start": None,
            "positions": False,
            "retry_failed": False,
        },
    ),
    "options of a point": Target(
        mapped(lambda options: studies.run_points(scene(), [studies.Point(commands={"upper": 0.9}, scene=options)])),
        {"key": "friction", "value": 0.2},
    ),
    "worker_pool": Target(lambda workers: studies.worker_pool(workers).shutdown(), {"workers": 1}),
}
"""Public calls; the hostile argument takes the place of one of the good ones."""


def _short(dt: Any) -> bool:
    """Not hours of movement."""
    return not (isinstance(dt, int | float) and dt > 0.01)


def test_good_arguments_are_good() -> None:
    """So that what follows begins where things work."""
    for target in TARGETS.values():
        target.call(**target.good)


@fuzz
@given(data=st.data())
@pytest.mark.parametrize("name", list(TARGETS))
def test_fuzz_arguments(name: str, data: st.DataObject) -> None:
    target = TARGETS[name]
    names = list(target.good)
    changed = data.draw(st.lists(st.sampled_from(names), min_size=1, max_size=2, unique=True))
    arguments = {**target.good, **{argument: data.draw(hostile, label=argument) for argument in changed}}
    with np.errstate(all="ignore"):
        only_own_errors(lambda: target.call(**arguments))


def test_fuzz_leaves_the_scene_alone() -> None:
    """After all that, the scene that took it gives the same bits as one that did not."""
    fresh = Scene(body(), fixed=["left"])
    assert np.array_equal(scene().equilibrate({"upper": 0.8}).positions, fresh.equilibrate({"upper": 0.8}).positions)
