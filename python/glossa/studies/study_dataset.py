"""Finished points of a study as a Dataset, and what a store has to know for that."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from glossa.errors import InputError
from glossa.studies.evaluation import Record
from glossa.studies.measurement import Layout, Quantity
from glossa.studies.store import read_store
from glossa.studies.study_point import Point
from glossa.tract.lips import as_lips

UNFINISHED = "unfinished"
"""Status of a point that has not been computed yet."""

_OF_POINTS = (
    "point",
    "status",
    "reason",
    "acoustic_reason",
    "started",
    "iterations",
    "seconds",
    "worker",
    "commands",
    "lips_length",
    "lips_area",
    "scene_options",
    "shape",
)


def open_study(path: str | Path) -> xr.Dataset:
    """The study in a store, finished or not, as :func:`glossa.studies.run_points` returns it.

    Points not computed yet have the status "unfinished" and NaN. A store that a study is writing at the moment can be
    read, too; one of any version of glossa that wrote the same format.

    Raises:
        FileNotFoundError: nothing at ``path``.
        InputError: a folder, a foreign or corrupt file.
    """
    header, records = read_store(path)
    return study_dataset(header, records)


def layout_dict(layout: Layout) -> dict[str, Any]:
    """Plain values of a layout."""
    return {
        "quantities": [[q.name, list(q.dims), list(q.shape), q.units] for q in layout.quantities],
        "coordinates": {name: list(values) for name, values in layout.coordinates.items()},
    }


def _layout(plain: Mapping[str, Any]) -> Layout:
    return Layout(
        quantities=tuple(
            Quantity(name=name, dims=tuple(dims), shape=tuple(shape), units=units)
            for name, dims, shape, units in plain["quantities"]
        ),
        coordinates={name: tuple(values) for name, values in plain["coordinates"].items()},
    )


def check_labels(points: Sequence[Point], layout: Layout) -> None:
    """Refuse labels whose names mean something else in the result, or that are numbers here and words there.

    Raises:
        InputError: naming the label.
    """
    taken = {*_OF_POINTS, *layout.coordinates, *(d for q in layout.quantities for d in (q.name, *q.dims))}
    kinds: dict[str, type] = {}
    for point in points:
        for name, value in point.labels.items():
            if name in taken:
                raise InputError(f"a label cannot be called {name!r}: the result has something of that name")
            kind = str if isinstance(value, str) else float
            if kinds.setdefault(name, kind) is not kind:
                raise InputError(f"label {name!r} is a number at some points and a word at others")


def study_dataset(header: Mapping[str, Any], records: Iterable[Record]) -> xr.Dataset:
    """Dataset over "point" of a header (see :func:`glossa.studies.run.study_header`) and finished points."""
    layout, points = _layout(header["layout"]), header["points"]
    found = {record.number: record for record in records}
    rows = np.full((len(points), layout.size), math.nan)
    for number, record in found.items():
        rows[number] = record.values
    of_each = {quantity.name: quantity for quantity in layout.quantities}
    variables: dict[str, Any] = _bookkeeping(found, len(points))
    for name, values in layout.split(rows).items():
        variables[name] = (("point", *of_each[name].dims), values, {"units": of_each[name].units})
    variables |= _asked_for(points, layout.coordinates["muscle"])
    coordinates: dict[str, Any] = {"point": np.arange(len(points))}
    coordinates |= {name: list(values) for name, values in layout.coordinates.items()}
    coordinates |= _labels(points, header["label_units"])
    return xr.Dataset(variables, coords=coordinates, attrs=dict(header["attributes"]))


def _bookkeeping(found: Mapping[int, Record], count: int) -> dict[str, Any]:
    def column(name: str, missing: Any) -> list[Any]:
        return [getattr(found[k], name) if k in found else missing for k in range(count)]

    words = {"status": UNFINISHED, "reason": "", "acoustic_reason": "", "started": "", "worker": ""}
    texts = {name: (("point",), np.array(column(name, missing), dtype=object)) for name, missing in words.items()}
    return {
        **texts,
        "iterations": (("point",), np.array(column("iterations", 0), dtype=np.int64)),
        "seconds": (("point",), np.array(column("seconds", math.nan), dtype=np.float64), {"units": "s"}),
    }


def _asked_for(points: Sequence[Mapping[str, Any]], muscles: Sequence[Any]) -> dict[str, Any]:
    """Commands and lips; scene options and shape parameters as JSON where there are any."""
    commands = [[point["commands"].get(muscle, math.nan) for muscle in muscles] for point in points]
    table = np.array(commands, dtype=np.float64).reshape(len(points), len(muscles))
    asked: dict[str, Any] = {"commands": (("point", "muscle"), table, {"units": "1", "silent": "NaN"})}
    if any(point["lips"] is not None for point in points):
        lips = [None if p["lips"] is None else as_lips(p["lips"]) for p in points]
        for name, units in (("length", "m"), ("area", "m2")):
            values = np.array([math.nan if one is None else getattr(one, name) for one in lips])
            asked[f"lips_{name}"] = (("point",), values, {"units": units})
    for name, key in (("scene_options", "scene"), ("shape", "shape")):
        if any(point[key] for point in points):
            texts = [json.dumps(point[key], ensure_ascii=False, sort_keys=True) for point in points]
            asked[name] = (("point",), np.array(texts, dtype=object))
    return asked


def _labels(points: Sequence[Mapping[str, Any]], units: Mapping[str, str]) -> dict[str, Any]:
    """Labels by name; NaN or empty where a point lacks one."""
    names = dict.fromkeys(name for point in points for name in point["labels"])
    result: dict[str, Any] = {}
    for name in names:
        values = [point["labels"].get(name) for point in points]
        attributes = {"units": units[name]} if name in units else {}
        if any(isinstance(value, str) for value in values):
            words = np.array(["" if value is None else value for value in values], dtype=object)
            result[name] = (("point",), words, attributes)
        else:
            numbers = np.array([math.nan if value is None else value for value in values], dtype=np.float64)
            result[name] = (("point",), numbers, attributes)
    return result
