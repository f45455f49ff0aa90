"""``glossa accuracy``: what accuracy costs in time."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer
import xarray as xr

from glossa.cli import output
from glossa.cli.accuracy_output import accuracy_json, accuracy_markdown, print_accuracy
from glossa.cli.files import check_outputs, write, write_netcdf
from glossa.cli.options import (
    JsonOption,
    LandmarksOption,
    MirrorOption,
    PlotOption,
    SaveOption,
    SpeakerOption,
    check_output,
    make_scene,
    make_speaker,
    whole_numbers,
)
from glossa.cli.running import refuse_failed, study_bar
from glossa.errors import InputError
from glossa.studies.accuracy import FULL, QUICK, AccuracySettings, accuracy_study, committed_study


@output.guarded
def accuracy_command(
    show: Annotated[
        bool, typer.Option("--show", help="Compute nothing: print the study that comes with the package.")
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Few choices and a short movement: seconds.")] = False,
    resolutions: Annotated[
        str | None,
        typer.Option(
            "--resolutions",
            metavar="R,R",
            help="Of the built-in speaker, rising from 1; with 1,2,3 its limit is extrapolated.",
            show_default="1,2; with --quick 1",
        ),
    ] = None,
    repetitions: Annotated[
        int | None,
        typer.Option("--repetitions", metavar="N", help="Runs of each choice; the shortest counts.", show_default="3"),
    ] = None,
    speaker: SpeakerOption = "reference",
    landmarks: LandmarksOption = None,
    mirror: MirrorOption = None,
    plot: PlotOption = None,
    save: SaveOption = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the tables of README.md.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Error in mm, N and Hz and time of every numerical choice, and of leaving effects out; takes minutes.

    Resolution, element, tolerances, half or full, threads, integrators, steps and presets of accuracy, each against a
    converged reference of the study's own.
    """
    check_outputs(plot)
    check_output(save, (".nc",))
    if as_json and markdown:
        raise InputError("choose one of --json and --markdown")
    if show:
        if quick or resolutions is not None or repetitions is not None or speaker != "reference" or landmarks:
            raise InputError("--show computes nothing; leave out what says how to compute")
        study = committed_study()
    else:
        settings = _settings(quick, resolutions, repetitions)
        scene = make_scene(make_speaker(speaker, 1, landmarks), mirror=mirror)
        with study_bar() as progress:
            study = accuracy_study(scene, settings, landmarks=landmarks, progress=progress)
    if as_json:
        output.print_json(accuracy_json(study))
    elif markdown:
        typer.echo(accuracy_markdown(study))
    else:
        print_accuracy(study)
    if plot is not None:
        from glossa import figures

        write(figures.accuracy(study), plot)
    write_netcdf(study, save)
    _refuse_failed(study)


def _settings(quick: bool, resolutions: str | None, repetitions: int | None) -> AccuracySettings:
    settings = QUICK if quick else FULL
    if resolutions is not None:
        settings = replace(settings, resolutions=whole_numbers("--resolutions", resolutions))
    return settings if repetitions is None else replace(settings, repetitions=repetitions)


def _refuse_failed(study: xr.Dataset) -> None:
    """Choices that fail without an effect are results; others are failures."""
    own = study.isel(choice=(study["family"] != "effects").to_numpy())
    refuse_failed(own["reason"].to_numpy().ravel().tolist(), "solves")
