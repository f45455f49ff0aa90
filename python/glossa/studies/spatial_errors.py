"""Errors of several postures that are due to their mesh, as a table."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

import numpy as np
import xarray as xr

from glossa.anatomy.speaker import Speaker
from glossa.errors import SolveError
from glossa.results import Posture
from glossa.scene import Scene
from glossa.spatial_error import SpatialError
from glossa.studies.acoustics import formant_error
from glossa.studies.failure import reason_of
from glossa.studies.provenance import provenance
from glossa.tract import LIPS


def spatial_errors(scene: Scene, postures: Mapping[str, Posture], *, finer: Speaker | None = None) -> xr.Dataset:
    """Estimated errors of equilibria of motor commands, see :meth:`glossa.Scene.spatial_error`.

    Args:
        scene: of the postures.
        postures: by name; the formants of vowels have the lips of Table IV.
        finer: as for :meth:`glossa.Scene.spatial_error`.

    Returns:
        Over ``posture``: ``root_mean_square`` and ``largest`` error of the positions of all nodes, m; ``forces (…,
        muscle)`` N, ``formants (…, formant)`` Hz, ``touched_areas (…, wall)`` m2: what the limit of fine meshes has
        more; ``cpu_seconds`` of the estimate. NaN where there is none; ``reason``: why a posture has no errors or no
        formants, or empty.

    Raises:
        InputError: as for :meth:`glossa.Scene.spatial_error`.
        SolveInterrupted: Ctrl-C.
    """
    scene.divided(finer)  # making it is no part of an estimate
    rows = [_row(scene, name, posture, finer) for name, posture in postures.items()]
    result = xr.concat(rows, dim="posture", combine_attrs="drop_conflicts") if rows else xr.Dataset()
    return result.assign_coords(posture=list(postures)).assign_attrs(provenance(scene, "spatial_errors"))


def _row(scene: Scene, name: str, posture: Posture, finer: Speaker | None) -> xr.Dataset:
    begin, error, reason = time.process_time(), None, ""
    if posture.report is not None and not posture.report.converged:
        reason = "the posture has not converged"
    else:
        try:
            error = scene.spatial_error(posture, finer=finer)
        except SolveError as failure:
            reason = reason_of(failure)
    seconds = time.process_time() - begin
    formants, unheard = _formants(error, name)
    speaker = scene.speaker
    forces = np.full(len(speaker.muscles), math.nan) if error is None else error.forces.to_numpy()
    known = None if error is None or error.touched_areas.empty else error.touched_areas.to_numpy()
    return xr.Dataset(
        {
            "root_mean_square": ((), math.nan if error is None else error.root_mean_square, {"units": "m"}),
            "largest": ((), math.nan if error is None else error.largest, {"units": "m"}),
            "forces": (("muscle",), forces, {"units": "N"}),
            "formants": (("formant",), formants, {"units": "Hz"}),
            "touched_areas": (
                ("wall",),
                np.full(len(speaker.walls), math.nan) if known is None else known,
                {"units": "m2"},
            ),
            "cpu_seconds": ((), seconds, {"units": "s"}),
            "reason": reason or unheard,
        },
        coords={"muscle": list(speaker.muscles), "formant": [1, 2, 3, 4], "wall": list(speaker.walls)},
    )


def _formants(error: SpatialError | None, name: str) -> tuple[np.ndarray, str]:
    if error is None or name not in LIPS or not error.posture.speaker.walls:
        return np.full(4, math.nan), ""
    return formant_error(error, LIPS[name])
