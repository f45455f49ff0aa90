"""Axes of sweeps: what a study may vary, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from glossa.anatomy.shape import shape_parameters
from glossa.checks import finite_number, not_negative_number, positive_number
from glossa.effects import Reflex, Stiffening, Yeoh, gravity_vector
from glossa.errors import InputError
from glossa.scene import Scene
from glossa.studies.study_point import Point
from glossa.tract import Lips
from glossa.tract.lips import as_lips


@dataclass(frozen=True, kw_only=True)
class Axis:
    """Something that a study may vary.

    Attributes:
        name: "command.GGp", "gravity", ...
        units: of its values; empty for names.
        numeric: whether values are numbers, which ranges can be sampled for; else names or vectors.
        changed: a point with this axis at a value, from the point and the value.
    """

    name: str
    units: str
    numeric: bool
    changed: Callable[[Point, Any], Point]


def known_axes(scene: Scene, base: Mapping[str, float]) -> dict[str, Axis]:
    """What can be varied in a scene, by name.

    - ``command.<muscle>``: lambda as a fraction of rest length;
    - ``change.<muscle>``: % of the command that the muscle has in ``base``;
    - ``tissue.c10``, ``.c20`` (Pa), ``.poissons_ratio``, ``.density`` (kg/m3); ``firing_gradient`` (1/m);
      ``stiffening.peak_multiplier``; ``friction``, with contact;
    - ``reflex.delay``, ``reflex.velocity_gain`` (s): of movements only, equilibria do not change with them;
    - ``gravity``: "upright", "supine", "none" or a vector in m/s2;
    - ``lips``: name of a vowel or (length m, area m2); ``lips.length`` (m), ``lips.area`` (m2): of the lips that the
      base has;
    - ``shape.<parameter>``: of the built-in speaker, added to its own.

    Args:
        scene: the study's.
        base: motor commands that the axes change.
    """
    axes = [_command(muscle) for muscle in scene.speaker.muscles]
    axes += [_change(muscle, command) for muscle, command in base.items()]
    tissue = {"c10": "Pa", "c20": "Pa", "poissons_ratio": "1", "density": "kg/m3"}
    axes += [_part("tissue", part, units, scene.tissue) for part, units in tissue.items()]
    axes.append(_option("firing_gradient", "1/m", positive_number))
    if scene.stiffening is not None:
        axes.append(_part("stiffening", "peak_multiplier", "1", scene.stiffening))
    if scene.contact:
        axes.append(_option("friction", "1", not_negative_number))
    if scene.reflex is not None:
        axes += [_part("reflex", part, "s", scene.reflex) for part in ("delay", "velocity_gain")]
    axes.append(Axis(name="gravity", units="", numeric=False, changed=_with_gravity))
    axes.append(Axis(name="lips", units="", numeric=False, changed=lambda point, lips: replace(point, lips=lips)))
    axes += [_lip_size(part, units) for part, units in (("length", "m"), ("area", "m2"))]
    axes += [_shape(parameter.name, parameter.unit) for parameter in shape_parameters().values()]
    return {axis.name: axis for axis in axes}


def axis_label(value: Any) -> float | str:
    """A value as coordinate: numbers as they are, vectors and pairs as their numbers with commas."""
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    if isinstance(value, Lips):
        value = (value.length, value.area)
    try:
        return finite_number(value, "value")
    except InputError:
        pass
    try:
        return ",".join(repr(float(part)) for part in value)
    except (TypeError, ValueError):
        raise InputError(f"a value of an axis must be a number, a name or a vector, got {value!r}") from None


def _command(muscle: str) -> Axis:
    def changed(point: Point, value: Any) -> Point:
        return replace(point, commands={**point.commands, muscle: value})

    return Axis(name=f"command.{muscle}", units="1", numeric=True, changed=changed)


def _change(muscle: str, command: float) -> Axis:
    def changed(point: Point, value: Any) -> Point:
        percent = finite_number(value, f"change of {muscle}")
        return replace(point, commands={**point.commands, muscle: command * (1.0 + percent / 100.0)})

    return Axis(name=f"change.{muscle}", units="%", numeric=True, changed=changed)


def _option(name: str, units: str, check: Callable[[Any, str], float]) -> Axis:
    def changed(point: Point, value: Any) -> Point:
        return replace(point, scene={**point.scene, name: check(value, name)})

    return Axis(name=name, units=units, numeric=True, changed=changed)


def _part(option: str, part: str, units: str, own: Yeoh | Reflex | Stiffening) -> Axis:
    """One field of an option of the scene."""

    def changed(point: Point, value: Any) -> Point:
        now = point.scene.get(option, own)
        number = finite_number(value, f"{option}.{part}")
        return replace(point, scene={**point.scene, option: replace(now, **{part: number})})

    return Axis(name=f"{option}.{part}", units=units, numeric=True, changed=changed)


def _with_gravity(point: Point, value: Any) -> Point:
    wanted = None if isinstance(value, str) and value == "none" else value
    gravity_vector(wanted)
    return replace(point, scene={**point.scene, "gravity": wanted})


def _lip_size(part: str, units: str) -> Axis:
    def changed(point: Point, value: Any) -> Point:
        if point.lips is None:
            raise InputError(f"lips.{part} changes the lips of the base, and it has none; give lips")
        own = as_lips(point.lips)
        new = {"length": own.length, "area": own.area, part: value}
        checked = Lips(**new)
        return replace(point, lips=(checked.length, checked.area))

    return Axis(name=f"lips.{part}", units=units, numeric=True, changed=changed)


def _shape(parameter: str, units: str) -> Axis:
    def changed(point: Point, value: Any) -> Point:
        return replace(point, shape={**point.shape, parameter: value})

    return Axis(name=f"shape.{parameter}", units=units, numeric=True, changed=changed)
