"""``glossa stability``: where the delayed reflex loop oscillates by itself."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from glossa.cli import output
from glossa.cli.files import check_outputs, write, write_netcdf
from glossa.cli.options import (
    ContactOption,
    FrictionOption,
    GravityOption,
    HyoidOption,
    JsonOption,
    LandmarksOption,
    MirrorOption,
    PlotOption,
    ResolutionOption,
    SaveOption,
    SpeakerOption,
    check_output,
    make_scene,
    make_speaker,
    numbers,
    vowel_name,
)
from glossa.cli.running import refuse_failed
from glossa.cli.stability_output import print_stability, stability_json
from glossa.errors import InputError
from glossa.studies.stability import (
    DELAYS,
    FIRING_GRADIENTS,
    VELOCITY_GAINS,
    StabilityGrid,
    committed_stability,
    stability,
)


@output.guarded
def stability_command(
    vowel: Annotated[str, typer.Argument(metavar="VOWEL", help="i, a, u, ə (or @), with or without slashes.")] = "i",
    show: Annotated[
        bool, typer.Option("--show", help="Compute nothing: print the study of all vowels that comes with the package.")
    ] = False,
    delays: Annotated[
        str | None,
        typer.Option(
            "--delays",
            metavar="MS",
            help="Milliseconds, rising.",
            show_default=",".join(f"{1e3 * value:g}" for value in DELAYS),
        ),
    ] = None,
    gains: Annotated[
        str | None,
        typer.Option(
            "--gains",
            metavar="MS",
            help="Velocity gains µ of the reflex, milliseconds, rising.",
            show_default=",".join(f"{1e3 * value:g}" for value in VELOCITY_GAINS),
        ),
    ] = None,
    gradients: Annotated[
        str | None,
        typer.Option(
            "--gradients",
            metavar="C,C",
            help="Of the force law (c of eq. 3), 1/m, rising.",
            show_default=",".join(f"{value:g}" for value in FIRING_GRADIENTS),
        ),
    ] = None,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    plot: PlotOption = None,
    save: SaveOption = None,
    as_json: JsonOption = False,
) -> None:
    """Growth and frequency of the delayed reflex loop about a vowel, over delay, velocity gain and firing gradient.

    Rightmost roots of the linearised motion: positive growth oscillates whatever the time step. Takes minutes.
    """
    check_outputs(plot)
    check_output(save, (".nc",))
    if show:
        if any(given is not None for given in (delays, gains, gradients)) or speaker != "reference" or landmarks:
            raise InputError("--show computes nothing; leave out what says how to compute")
        study = committed_stability()
    else:
        name = vowel_name(vowel)
        grid = StabilityGrid(
            delays=DELAYS if delays is None else [1e-3 * value for value in numbers("--delays", delays)],
            velocity_gains=VELOCITY_GAINS if gains is None else [1e-3 * value for value in numbers("--gains", gains)],
            firing_gradients=FIRING_GRADIENTS if gradients is None else numbers("--gradients", gradients),
        )
        scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
        study = stability(scene, name, grid, progress=output.say if sys.stderr.isatty() else None)
    if as_json:
        output.print_json(stability_json(study))
    else:
        print_stability(study)
    if plot is not None:
        from glossa import figures

        write(figures.stability(study), plot)
    write_netcdf(study, save)
    refuse_failed(study["reason"].to_numpy().ravel().tolist(), "equilibria")
