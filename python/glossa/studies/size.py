"""What a finer mesh costs: vowels of the built-in speaker from rest at several resolutions.

The factor of a mesh of N unknowns in three dimensions takes N^(4/3) entries and N^2 operations where the order of
elimination is that of nested dissection (George 1973, SIAM J. Numer. Anal. 10:345). A fibre's stiffness to stretch
couples all its nodes, which no such order keeps apart: on fine meshes the solver leaves it out of the factor, and the
factor of the whole tangent shows what that saves. :func:`growth` tells the powers found.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr

from glossa import _core
from glossa.anatomy.speaker import Speaker
from glossa.checks import one_of, whole_number
from glossa.data_files import data_path
from glossa.errors import InputError, SolveError
from glossa.motor.commands import vowel_commands
from glossa.scene import Scene
from glossa.studies.executors import worker_pool
from glossa.studies.failure import reason_of
from glossa.studies.machine import machine
from glossa.studies.peak_memory import peak_memory
from glossa.studies.provenance import provenance

COMMITTED = "results/size.nc"
"""Data file with the study that comes with the package."""

GROWING = ("factor_entries", "factor_flops", "whole_entries", "whole_flops", "memory", "cpu_seconds")
"""Quantities of :func:`growth`."""

_COUNTS = ("iterations", "factorisations", "residuals")
_MOST = 12  # of the resolution: 1.3 million hexahedra


def size_study(
    resolutions: Sequence[int] = (1, 2, 3),
    *,
    counted: Sequence[int] = (),
    names: Sequence[str] = ("i", "ə", "u", "a"),
    progress: Callable[[str], None] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Vowels from rest, each once, every resolution in a process of its own.

    Args:
        resolutions: to be solved.
        counted: others, of which only unknowns and factor are counted.
        names: vowels of Table III.
        progress: called with a line of text before each resolution.
        options: of :class:`glossa.Scene`; ``mirror`` is True unless given.

    Returns:
        Over ``resolution``: ``hexahedra`` of the whole tongue, ``unknowns``, ``factor_entries`` and ``factor_flops`` of
        one factorisation as the solver makes it, ``whole_entries`` and ``whole_flops`` of one with the fibres'
        stiffness to stretch in it, ``memory`` B (the most that the process held), ``making_seconds`` of speaker and
        scene; and over ``vowel``: ``cpu_seconds``, ``wall_seconds``, ``factor_share`` of factorisations in the time by
        the clock, ``iterations``, ``factorisations``, ``residuals``.
        NaN where nothing was solved; ``reason`` of a failure, or empty. Attributes: machine, provenance.

    Raises:
        InputError: bad resolutions, vowels or options.
    """
    levels = sorted([whole_number(r, "resolution", 1, _MOST) for r in (*resolutions, *counted)])
    if not levels or len(set(levels)) < len(levels):
        raise InputError(f"resolutions must differ, got {levels}")
    for name in names:
        vowel_commands(name)
    chosen: dict[str, Any] = {"mirror": True} | options
    rows = []
    for r in levels:
        if progress is not None:
            progress(f"resolution {r}")
        with worker_pool(1) as pool:
            rows.append(pool.submit(_row, r, list(names) if r in resolutions else [], list(names), chosen).result())
    scene = Scene(Speaker.reference(levels[0]), **chosen)
    result = xr.concat(rows, dim="resolution", combine_attrs="drop_conflicts")
    return result.assign_attrs(provenance(scene, "size") | machine())


def _row(resolution: int, solved: Sequence[str], names: Sequence[str], options: dict[str, Any]) -> xr.Dataset:
    """One resolution."""
    begin = time.process_time()
    speaker = Speaker.reference(resolution)
    scene = Scene(speaker, **options)
    making = time.process_time() - begin
    sizes = _sizes(scene, names[0])
    found = {name: np.full(len(names), math.nan) for name in ("cpu_seconds", "wall_seconds", "factor_share", *_COUNTS)}
    reasons = np.full(len(names), "", dtype=object)
    for place, name in enumerate(names):
        if name not in solved:
            continue
        begin, start = time.process_time(), time.perf_counter()
        try:
            report = scene.equilibrate(vowel_commands(name)).report
        except SolveError as error:
            reasons[place] = reason_of(error)
            continue
        found["cpu_seconds"][place] = time.process_time() - begin
        found["wall_seconds"][place] = time.perf_counter() - start
        assert report is not None
        found["factor_share"][place] = report.seconds["factorisation"] / report.seconds["total"]
        for count in _COUNTS:
            found[count][place] = getattr(report, count)
    units = {"cpu_seconds": "s", "wall_seconds": "s"}
    return xr.Dataset(
        {
            "hexahedra": len(speaker.hexahedra),
            **sizes,
            "memory": ((), peak_memory() if solved else math.nan, {"units": "B"}),
            "making_seconds": ((), making, {"units": "s"}),
            **{
                name: (("vowel",), values, {"units": units[name]} if name in units else {})
                for name, values in found.items()
            },
            "reason": (("vowel",), reasons),
        },
        coords={"resolution": resolution, "vowel": list(names)},
    )


def _sizes(scene: Scene, vowel: str) -> dict[str, float]:
    """Unknowns, entries and operations of the solver's factor and of that of the whole tangent."""
    found = {}
    for kind in ("factor", "whole"):
        pieces = _core.Pieces(scene._solver, scene._fractions(vowel_commands(vowel)), whole=kind == "whole")
        found[f"{kind}_entries"], found[f"{kind}_flops"] = float(pieces.factor_entries), float(pieces.factor_flops)
        found["unknowns"] = float(len(pieces.unknowns))
    return found


def committed_size_study() -> xr.Dataset:
    """The study that comes with the package.

    Raises:
        InputError: its file is not there.
    """
    with xr.open_dataset(data_path(COMMITTED), engine="h5netcdf") as opened:
        return opened.load()


def growth(study: xr.Dataset, quantity: str) -> xr.DataArray:
    """Powers of the number of unknowns with which a quantity grows from each resolution to the next.

    Args:
        study: of :func:`size_study`.
        quantity: one of :data:`GROWING`; of the seconds, their mean over the vowels.

    Returns:
        Over ``resolution``; NaN for the coarsest and where nothing was solved.

    Raises:
        InputError: another Dataset, or an unknown quantity.
    """
    check_size(study)
    values = study[one_of(quantity, GROWING, "quantity")]
    if "vowel" in values.dims:
        values = values.mean("vowel", skipna=False)
    sizes = zip(np.log(study["unknowns"].to_numpy()), np.log(values.to_numpy()), strict=True)
    powers = [math.nan, *((b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(sizes))]
    return xr.DataArray(powers, dims="resolution", coords={"resolution": study["resolution"]}, name=quantity)


def check_size(study: Any) -> None:
    """Refuse what is not the result of a size study.

    Raises:
        InputError: that.
    """
    if not isinstance(study, xr.Dataset) or study.attrs.get("study") != "size":
        raise InputError("this needs the result of glossa.studies.size_study")
