"""``glossa size``: what a finer mesh costs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

import typer
import xarray as xr

from glossa.cli import output
from glossa.cli.files import check_outputs, write, write_netcdf
from glossa.cli.options import JsonOption, MirrorOption, PlotOption, SaveOption, check_output, whole_numbers
from glossa.cli.running import refuse_failed
from glossa.cli.study_tables import cell, numbers
from glossa.studies.size import GROWING, committed_size_study, growth, size_study

_MILLION, _GIGA = 1e6, 1e9


@output.guarded
def size_command(
    show: Annotated[
        bool, typer.Option("--show", help="Compute nothing: print the study that comes with the package.")
    ] = False,
    resolutions: Annotated[
        str, typer.Option("--resolutions", "-r", metavar="R,R", help="Of the built-in speaker, to be solved.")
    ] = "1,2",
    counted: Annotated[
        str | None, typer.Option("--counted", metavar="R,R", help="Others, of which only the factor is counted.")
    ] = None,
    mirror: MirrorOption = True,
    plot: PlotOption = None,
    save: SaveOption = None,
    as_json: JsonOption = False,
) -> None:
    """What a finer mesh costs: vowels of the built-in speaker from rest, their factors and memory, and how these grow.

    Resolution 3 takes minutes, 4 a quarter of an hour.
    """
    check_outputs(plot)
    check_output(save, (".nc",))
    if show:
        study = committed_size_study()
    else:
        others = [] if counted is None else whole_numbers("--counted", counted)
        levels = whole_numbers("--resolutions", resolutions)
        study = size_study(levels, counted=others, progress=output.say, mirror=mirror is not False)
    if as_json:
        output.print_json(_json(study))
    else:
        for line in size_markdown(study):
            typer.echo(line)
    if plot is not None:
        from glossa import figures

        write(figures.size(study), plot)
    write_netcdf(study, save)
    refuse_failed(study["reason"].to_numpy().ravel().tolist(), "solves")


def size_markdown(study: xr.Dataset) -> list[str]:
    """A table by resolution, as README.md has it, and what the numbers mean."""
    facts = study.attrs
    half = "mirrored" if "mirror" in facts["effects"] else "full"
    vowels = study["vowel"].values.tolist()
    table = [["", *(f"r = {r}" for r in study["resolution"].values.tolist())]]
    table.append(["---"] * len(table[0]))
    table += [[title, *cells] for title, cells in _rows(study, vowels)]
    machine = f"{facts['processor']}, {facts['cores']} cores, {facts['kernel']}, {facts['load']:g} processes running"
    return [f"{machine} on the mean; {half}, from rest, once", "", *("| " + " | ".join(row) + " |" for row in table)]


def _rows(study: xr.Dataset, vowels: list[str]) -> Iterator[tuple[str, list[str]]]:
    def cells(values: Any, digits: int = 0, scale: float = 1.0) -> list[str]:
        return [cell(float(value) * scale, digits) for value in values]

    yield "hexahedra of the whole tongue", cells(study["hexahedra"])
    yield "unknowns", cells(study["unknowns"])
    for vowel in vowels:
        own = study.sel(vowel=vowel)
        yield f"/{vowel}/, CPU s", cells(own["cpu_seconds"], 2)
        yield f"/{vowel}/, s by the clock", cells(own["wall_seconds"], 2)
        yield f"/{vowel}/, factorisations", cells(own["factorisations"])
    yield "in factorisations, %", cells(study["factor_share"].mean("vowel", skipna=False), 0, 100.0)
    for title, key in (("factor", "factor"), ("with fibres in it", "whole")):
        entries, flops = study[f"{key}_entries"], study[f"{key}_flops"]
        yield f"{title}: entries, 10⁶", cells(entries, 2, 1.0 / _MILLION)
        yield f"{title}: operations, 10⁹", cells(flops, 2, 1.0 / _GIGA)
        yield f"{title}: their power of the unknowns", cells(growth(study, f"{key}_flops"), 2)
    yield "speaker and scene, CPU s", cells(study["making_seconds"], 1)
    yield "memory, GB", cells(study["memory"], 2, 1.0 / _GIGA)


def _json(study: xr.Dataset) -> dict[str, Any]:
    single = [name for name in study.data_vars if study[name].dims == ("resolution",)]
    several = [name for name in study.data_vars if "vowel" in study[name].dims and name != "reason"]
    return {
        "facts": {name: getattr(value, "item", lambda value=value: value)() for name, value in study.attrs.items()},
        "resolutions": study["resolution"].values.tolist(),
        **{str(name): numbers(study[name]) for name in single},
        "vowels": {
            vowel: {str(name): numbers(study[name].sel(vowel=vowel)) for name in several}
            for vowel in study["vowel"].values.tolist()
        },
        "powers": {name: numbers(growth(study, name), 3) for name in GROWING},
    }
