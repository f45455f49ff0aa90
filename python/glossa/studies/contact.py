"""What the walls do to the tongue and where the hyoid goes, as tables of postures and of movements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from glossa.errors import InputError
from glossa.results import Movement, Posture

_AXES = ["x", "y", "z"]


def contact_table(postures: Mapping[str, Posture]) -> xr.Dataset:
    """Contact and hyoid of postures of one speaker; NaN where a scene has no contact or no mobile hyoid, or failed.

    Returns:
        Dataset with ``area (posture, wall)``, mm2 of the tongue at rest that touches the wall, ``force (posture, wall,
        axis)``, N of the wall on the tongue, and ``hyoid_displacement (posture, axis)``, mm from rest of its centre.

    Raises:
        InputError: no posture, or postures of several speakers.
    """
    if not postures:
        raise InputError("a table needs at least one posture")
    speaker = next(iter(postures.values())).speaker
    if any(posture.speaker.fingerprint != speaker.fingerprint for posture in postures.values()):
        raise InputError("the postures of a table must belong to one speaker")
    return _table(list(postures.values()), "posture", list(postures))


def contact_over_time(movement: Movement) -> xr.Dataset:
    """As :func:`contact_table` for every frame of a movement; dimension ``time`` (s) in place of ``posture``."""
    return _table([movement.at(float(time)) for time in movement.times], "time", movement.times.tolist())


def _table(postures: Sequence[Posture], dimension: str, labels: Sequence[str] | Sequence[float]) -> xr.Dataset:
    walls = list(postures[0].speaker.walls)
    area = np.full((len(postures), len(walls)), math.nan)
    force = np.full((len(postures), len(walls), 3), math.nan)
    hyoid = np.full((len(postures), 3), math.nan)
    for row, posture in enumerate(postures):
        if posture.report is not None and not posture.report.converged:
            continue
        if posture.contact is not None:
            area[row] = posture.contact.touched_areas[walls].to_numpy() * 1e6
            force[row] = posture.contact.forces.loc[walls].to_numpy()
        if posture.hyoid is not None:
            hyoid[row] = posture.hyoid.displacement * 1e3
    return xr.Dataset(
        {
            "area": ((dimension, "wall"), area, {"units": "mm2"}),
            "force": ((dimension, "wall", "axis"), force, {"units": "N"}),
            "hyoid_displacement": ((dimension, "axis"), hyoid, {"units": "mm"}),
        },
        coords={dimension: list(labels), "wall": walls, "axis": _AXES},
    )
