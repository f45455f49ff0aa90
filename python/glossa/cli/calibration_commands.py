"""Commands about the built-in speaker itself: its calibration, and what its resolution is worth."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Annotated

import typer
import xarray as xr

from glossa.cli import output
from glossa.cli.files import write_netcdf
from glossa.cli.options import JsonOption, LandmarksOption, SaveOption, check_output, whole_numbers
from glossa.studies.calibration import Outcome, calibrate, calibrated_parameters, effects, outcome, summary
from glossa.studies.resolution import error_bars, resolution_study

BOUND = {"displacement": "mm", "forces": "N", "formants": "Hz"}


@output.guarded
def calibrate_command(
    iterations: Annotated[int, typer.Option("--iterations", metavar="N", help="At most.")] = 12,
    show: Annotated[
        bool, typer.Option("--show", help="Adjust nothing: print what the built-in values give, and all zero.")
    ] = False,
    single: Annotated[
        bool, typer.Option("--effects", help="Adjust nothing: print what each built-in value does.")
    ] = False,
    save: Annotated[Path | None, typer.Option("--save", metavar="FILE", help="Write the values (.toml).")] = None,
) -> None:
    """Adjust the built-in speaker's shape parameters to Tables IV and II; takes some twenty minutes.

    The values are printed and saved; data/landmarks/reference_shape.toml holds those of the built-in speaker.
    """
    check_output(save, (".toml",))
    logging.getLogger("glossa.anatomy").setLevel(logging.ERROR)  # trials tell of every flaw they try
    built_in = {name: parameter.value for name, parameter in calibrated_parameters().items()}
    if single:
        typer.echo(effects(built_in).to_dataframe().to_string(float_format="{:.4f}".format))
        return
    if show:
        history = [outcome(dict.fromkeys(built_in, 0.0)), outcome(built_in)]
    else:

        def tell(iteration: int, cost: float, found: Outcome) -> None:
            output.say(f"iteration {iteration}: cost {cost:.1f}; {_line(found)}")
            if save is not None:
                save.write_text(_values(found), encoding="utf-8")

        history = calibrate(iterations=iterations, progress=tell)
        typer.echo(_values(history[-1]))
    for title, found in (("before", history[0]), ("after", history[-1])):
        table = found.table()
        typer.echo(f"{title}: {_line(found)}")
        typer.echo(table.formant_Hz.round(0).to_pandas().to_string())
        typer.echo((100.0 * (table.formant_ratio - 1.0)).round(1).to_pandas().to_string())
        typer.echo((100.0 * table.force_ratio).round(0).to_pandas().to_string())


@output.guarded
def resolution_command(
    resolutions: Annotated[
        str, typer.Option("--resolutions", "-r", metavar="R,R,R", help="Three of them, rising.")
    ] = "1,2,3",
    landmarks: LandmarksOption = None,
    save: SaveOption = None,
    as_json: JsonOption = False,
) -> None:
    """The vowels of the built-in speaker at three resolutions: changes, observed orders, errors; takes minutes."""
    check_output(save, (".nc",))
    levels = whole_numbers("--resolutions", resolutions)
    study = resolution_study(levels, landmarks=landmarks, progress=output.say)
    bars = {quantity: error_bars(study, quantity) for quantity in BOUND}
    write_netcdf(study, save)
    if as_json:
        output.print_json({"study": _plain(study), "errors": {name: _plain(bar) for name, bar in bars.items()}})
        return
    typer.echo("change of shared nodes against the next coarser resolution, mm, rms and largest")
    typer.echo(study[["change_rms", "change_max"]].round(2).to_dataframe().unstack().to_string())
    for quantity, unit in BOUND.items():
        typer.echo(f"{quantity}, {unit}: value at each resolution, limit, observed order, error of each")
        bar = bars[quantity]
        table = xr.merge([study[[quantity]], bar[["error"]]]).to_dataframe().unstack("resolution")
        table["limit"], table["order"] = bar.limit.to_series(), bar.order.to_series()
        typer.echo(table.round(2).to_string())


def _plain(dataset: xr.Dataset) -> dict[str, object]:
    return {str(name): values.where(values.notnull(), None).values.tolist() for name, values in dataset.items()}


def _values(found: Outcome) -> str:
    return "".join(f"{name} = {value:.3f}\n" for name, value in found.values.items())


def _line(found: Outcome) -> str:
    mean, largest, force = summary(found)
    low, high = found.force_ratios.min(), found.force_ratios.max()
    return (
        f"formants {100 * mean:.2f} % on the mean, {100 * largest:.1f} % at most; forces {100 * low:.0f} to "
        f"{100 * high:.0f} %, deviation {force:.3f}; scaled Jacobian {found.jacobian:.3f}, volume "
        f"{found.volume * 1e6:.1f} cm3, overlap {found.overlap * 1e3:.2f} mm"
    )
