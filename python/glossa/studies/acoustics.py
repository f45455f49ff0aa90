"""Vocal tracts of postures and movements, and their formants as a table (Table IV)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from glossa.acoustics import AreaFunction, TubeConstants, formants
from glossa.anatomy.arrays import FloatArray
from glossa.errors import InputError
from glossa.results import Movement, Posture
from glossa.spatial_error import LACKING, SpatialError
from glossa.tract import LIPS, Lips, area_function


def vowel_tracts(
    postures: Mapping[str, Posture], lips: Mapping[str, Lips] | None = None
) -> tuple[dict[str, AreaFunction], dict[str, str]]:
    """Area function of each posture, and the reason of each that has none.

    Args:
        postures: by vowel.
        lips: by vowel; None: those of Table IV.

    Returns:
        Area functions by name; reasons by name: not converged, no lips known, or why the tract cannot be cut.
    """
    known = LIPS if lips is None else lips
    tracts: dict[str, AreaFunction] = {}
    reasons: dict[str, str] = {}
    for name, posture in postures.items():
        if posture.report is not None and not posture.report.converged:
            reasons[name] = "the posture has not converged"
        elif name not in known:
            reasons[name] = f"no lips known for {name!r}"
        else:
            try:
                tracts[name] = area_function(posture, known[name])
            except InputError as error:
                reasons[name] = str(error)
    return tracts, reasons


def formant_table(
    tracts: Mapping[str, AreaFunction], n: int = 4, *, constants: str | TubeConstants = "badin"
) -> xr.Dataset:
    """Formants of several tracts.

    Args:
        tracts: by name.
        n: formants of each.
        constants: as in :meth:`glossa.AreaFunction.formants`.

    Returns:
        Dataset with ``frequency`` and ``bandwidth (tract, formant)`` in Hz, nan where not found, ``reason (tract,)``,
        empty where all were found, and ``length (tract,)`` in m.

    Raises:
        InputError: no tract, or bad arguments.
    """
    if not tracts:
        raise InputError("a table of formants needs at least one tract")
    found = formants(list(tracts.values()), n, constants=constants)
    return xr.Dataset(
        {
            "frequency": (("tract", "formant"), found.frequencies, {"units": "Hz"}),
            "bandwidth": (("tract", "formant"), found.bandwidths, {"units": "Hz"}),
            "reason": (("tract",), np.array(found.reasons, dtype=object)),
            "length": (("tract",), np.array([tract.length for tract in tracts.values()]), {"units": "m"}),
        },
        coords={"tract": list(tracts), "formant": np.arange(1, found.frequencies.shape[1] + 1)},
        attrs={"constants": constants if isinstance(constants, str) else constants.name},
    )


def posture_formants(posture: Posture, lips: str | tuple[float, float] | Lips) -> tuple[FloatArray, str]:
    """(4,) F1 to F4 of a posture, Hz, NaN where not found; and why, or empty."""
    try:
        found = area_function(posture, lips).formants(4)
    except InputError as error:
        return np.full(4, math.nan), str(error)
    return found.frequencies, found.reason


def formant_error(error: SpatialError, lips: str | tuple[float, float] | Lips) -> tuple[FloatArray, str]:
    """(4,) Hz that F1 to F4 of a posture lack by the error of its mesh, NaN where not found; and why, or empty.

    Where two resonances change places the numbers of formants do, too, and a large error is told.

    Args:
        error: of :meth:`glossa.Scene.spatial_error`.
        lips: as in :func:`glossa.area_function`.
    """
    found, reason = posture_formants(error.posture, lips)
    finer, other = posture_formants(error.finer, lips)
    return LACKING * (finer - found), reason or other


def movement_tracts(movement: Movement, times: ArrayLike, lips: str | tuple[float, float] | Lips) -> list[AreaFunction]:
    """Area functions along a movement, for :func:`glossa.synthesize`.

    Args:
        movement: of a speaker with walls.
        times: s, rising, within the movement.
        lips: as in :func:`glossa.area_function`; they stand still.

    Raises:
        InputError: times that do not rise or lie outside, or as :func:`glossa.area_function`.
    """
    moments = np.asarray(times, dtype=float)
    if moments.ndim != 1 or not len(moments) or not np.isfinite(moments).all() or (np.diff(moments) <= 0.0).any():
        raise InputError("times must be a list of rising times in s")
    return [area_function(movement.at(float(time)), lips) for time in moments]
