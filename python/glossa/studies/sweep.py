"""General sweeps: a design over motor commands, tissue, gravity, lips and anatomy, run as a study."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr

from glossa.checks import instance
from glossa.errors import InputError
from glossa.motor.commands import VOWELS, MotorCommands
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.axes import Axis, axis_label, known_axes
from glossa.studies.designs import Design
from glossa.studies.run import Progress, run_points
from glossa.studies.study_point import Point
from glossa.tract import LIPS, Lips

log = logging.getLogger(__name__)

_DYNAMIC = ("reflex.delay", "reflex.velocity_gain")


def sweep(
    scene: Scene,
    design: Design,
    base: str | Mapping[str, float] | None = "i",
    *,
    lips: str | tuple[float, float] | Lips | None = None,
    store: str | Path | None = None,
    executor: Executor | None = None,
    start: Posture | None = None,
    progress: Callable[[Progress], object] | None = None,
    positions: bool = False,
    retry_failed: bool = False,
) -> xr.Dataset:
    """The equilibria of a design, each a change of the same base.

    Args:
        scene: what the axes change.
        design: of :func:`grid`, :func:`latin_hypercube` or :func:`monte_carlo`.
        base: motor commands where no axis sets them: vowel of Table III, or by muscle; None: silent.
        lips: of every point; None: those of Table IV if the base is a vowel, else none, and no formants.
        store: as in :func:`run_points`.
        executor: as in :func:`run_points`.
        start: as in :func:`run_points`.
        progress: as in :func:`run_points`.
        positions: as in :func:`run_points`.
        retry_failed: as in :func:`run_points`.

    Returns:
        As :func:`run_points`, with the axes as coordinates; :func:`as_grid` gives a grid a dimension for each axis.

    Raises:
        InputError: an unknown axis, impossible values, an unknown base, or as :func:`run_points`.
        SolveInterrupted, SolveError: as :func:`run_points`.
    """
    points, units = sweep_points(scene, design, base, lips=lips)
    return run_points(
        scene,
        points,
        store=store,
        executor=executor,
        start=start,
        progress=progress,
        positions=positions,
        retry_failed=retry_failed,
        design={**design.as_dict(), "base": base},
        label_units=units,
    )


def sweep_points(
    scene: Scene,
    design: Design,
    base: str | Mapping[str, float] | None = "i",
    *,
    lips: str | tuple[float, float] | Lips | None = None,
) -> tuple[list[Point], dict[str, str]]:
    """The points of a design, and the units of its axes.

    Raises:
        InputError: as :func:`sweep`.
    """
    instance(design, Design, "design")
    first = _base_point(scene, base, lips)
    axes = _axes(design, known_axes(scene, first.commands))
    units = {axis.name: axis.units for axis in axes if axis.units}
    return [_point(first, axes, row, number) for number, row in enumerate(design.rows)], units


def _base_point(scene: Scene, base: Any, lips: Any) -> Point:
    instance(scene, Scene, "scene")
    if isinstance(base, str):
        if base not in VOWELS:
            raise InputError(f"unknown base {base!r}; Table III has {', '.join(VOWELS)}, or give motor commands")
        own = base if lips is None and base in LIPS and scene.speaker.walls else lips
        return Point(commands=VOWELS[base], lips=own)
    return Point(commands=MotorCommands({} if base is None else base), lips=lips)


def _axes(design: Design, known: Mapping[str, Axis]) -> list[Axis]:
    for name in design.axes:
        if name not in known:
            raise InputError(f"unknown axis {name!r}; this scene has {', '.join(known)}")
        if design.ranges is not None and not known[name].numeric:
            raise InputError(f"axis {name} has no numbers to sample; use it in a grid")
        if name.startswith("change.") and f"command.{name.removeprefix('change.')}" in design.axes:
            raise InputError(f"{name} and command.{name.removeprefix('change.')} set the same command; leave one out")
        if name == "lips" and any(other.startswith("lips.") for other in design.axes):
            raise InputError("lips and lips.length or lips.area set the same lips; leave one out")
        if name in _DYNAMIC:
            log.warning("%s acts on movements only; equilibria do not change with it", name)
    return [known[name] for name in design.axes]


def _point(first: Point, axes: list[Axis], row: tuple[Any, ...], number: int) -> Point:
    point = first
    for axis, value in zip(axes, row, strict=True):
        try:
            point = axis.changed(point, value)
        except (InputError, TypeError) as error:
            raise InputError(f"axis {axis.name} = {value!r} (point {number}): {error}") from None
    labels = {axis.name: axis_label(value) for axis, value in zip(axes, row, strict=True)}
    return replace(point, labels=labels)


def as_grid(result: xr.Dataset) -> xr.Dataset:
    """The result of a grid with a dimension for each axis in place of "point", in the order of the design.

    Raises:
        InputError: a result of something else than a grid.
    """
    design = json.loads(result.attrs.get("design", "{}"))
    if design.get("method") != "grid":
        raise InputError(f"only a grid has a dimension for each axis, not {design.get('method', 'these points')!r}")
    axes, shape = design["axes"], design["shape"]
    places = result.drop_vars(["point", *axes])
    coordinates: dict[str, Any] = {}
    for k, axis in enumerate(axes):
        stride = math.prod(shape[k + 1 :])
        taken = result[axis].to_numpy()[: stride * shape[k] : stride]
        coordinates[axis] = ((axis,), taken, result[axis].attrs)
    variables = {
        name: (
            [*axes, *values.dims[1:]] if "point" in values.dims else values.dims,
            values.to_numpy().reshape(*shape, *values.shape[1:]) if "point" in values.dims else values.to_numpy(),
            values.attrs,
        )
        for name, values in places.data_vars.items()
    }
    others = {name: values for name, values in places.coords.items() if "point" not in values.dims}
    return xr.Dataset(variables, coords={**coordinates, **others}, attrs=result.attrs)
