"""Files that commands write, checked before they compute."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from glossa.acoustics import AreaFunction
from glossa.cli import output
from glossa.cli.options import PICTURES, check_output
from glossa.errors import InputError
from glossa.result_files import write_dataset
from glossa.results import Posture

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def need(module: str, what: str, requirement: str) -> None:
    """Refuse what needs a package that is not installed."""
    if importlib.util.find_spec(module) is None:
        raise InputError(f"{what} needs {module}; install it with: pip install '{requirement}'")


def check_outputs(*pictures: Path | None, vtk: Path | None = None) -> None:
    """Refuse files of pictures and meshes that cannot be written, before anything is computed."""
    for picture in pictures:
        check_output(picture, PICTURES)
    check_output(vtk, (".vtu", ".vtk"))
    if vtk is not None:
        need("meshio", "--vtk", "meshio")


def need_tracts(option: str, tracts: dict[str, AreaFunction], reasons: dict[str, str]) -> None:
    """Refuse an option that shows the tract where there is none."""
    if reasons or not tracts:
        words = "; ".join(f"/{name}/: {reason}" for name, reason in reasons.items())
        raise InputError(f"{option} needs the area function, and there is none ({words})")


def write_tracts(
    tracts: dict[str, AreaFunction], reasons: dict[str, str], plot_tract: Path | None, plot_formants: Path | None
) -> None:
    """Pictures of area functions and transfer functions."""
    from glossa.figures import area_functions, transfer_functions

    if plot_tract is not None:
        need_tracts("--plot-tract", tracts, reasons)
        write(area_functions(tracts), plot_tract)
    if plot_formants is not None:
        need_tracts("--plot-formants", tracts, reasons)
        write(transfer_functions(tracts), plot_formants)


def write_posture(
    name: str, posture: Posture, plot: Path | None, plot_3d: Path | None, plot_contact: Path | None, vtk: Path | None
) -> None:
    """Pictures and mesh of one posture."""
    from glossa import figures

    if plot is not None:
        write(figures.midsagittal({name: posture}), plot)
    if plot_3d is not None:
        write(figures.surfaces({name: posture}), plot_3d)
    if plot_contact is not None:
        write(figures.contact_map({name: posture}), plot_contact)
    if vtk is not None:
        posture.to_meshio().write(vtk)
        output.wrote(vtk)


def write_netcdf(study: xr.Dataset, path: Path | None) -> None:
    """All results of a study, where a file is asked for."""
    if path is not None:
        write_dataset(study, path)
        output.wrote(path)


def write(figure: Figure, path: Path) -> None:
    """One picture."""
    figure.savefig(path)
    output.wrote(path)
