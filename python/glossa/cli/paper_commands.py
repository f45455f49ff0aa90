"""Commands of the paper's studies: sensitivity (section IV), gravity (V), transversalis (III.B), delay (II.C.1)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from glossa.checks import whole_number
from glossa.cli import output, paper_output, sensitivity_output
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
    SchedulerOption,
    SpeakerOption,
    StoreOption,
    VowelArgument,
    WorkersOption,
    check_output,
    make_scene,
    make_speaker,
    numbers,
    vowel_name,
)
from glossa.cli.running import refuse_failed, study_bar, study_executor
from glossa.studies.delay import DELAYS, delay
from glossa.studies.gravity import CARDINALS, gravity
from glossa.studies.sensitivity import sensitivity
from glossa.studies.sensitivity_summary import sensitivity_summary
from glossa.studies.transversalis import VOLUNTARY, transversalis


@output.guarded
def sensitivity_command(
    vowel: VowelArgument = "i",
    changes: Annotated[
        str | None,
        typer.Option(
            "--changes",
            metavar="PERCENTS",
            help="Of every command, for example --changes=-5,5.",
            show_default="those of Table VI",
        ),
    ] = None,
    store: StoreOption = None,
    workers: WorkersOption = 1,
    scheduler: SchedulerOption = None,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    plot: PlotOption = None,
    plot_saturation: Annotated[
        Path | None, typer.Option("--plot-saturation", metavar="FILE", help="Picture of F1 to F3 against GGa.")
    ] = None,
    save: SaveOption = None,
    as_json: JsonOption = False,
) -> None:
    """Motor commands of a vowel changed one at a time (section IV, Table VI): formants, and scatter of six nodes.

    --plot draws the scatter with its 3σ ellipses as fig. 11.
    """
    name = vowel_name(vowel)
    check_outputs(plot, plot_saturation)
    check_output(save, (".nc",))
    whole_number(workers, "--workers", 1, 1000)
    percents = None if changes is None else numbers("--changes", changes)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    with study_executor(workers, scheduler) as executor, study_bar() as progress:
        study = sensitivity(scene, name, percents, store=store, executor=executor, progress=progress)
    summary = sensitivity_summary(study)
    if as_json:
        output.print_json(sensitivity_output.sensitivity_json(study, summary))
    else:
        sensitivity_output.print_sensitivity(study, summary)
    from glossa import figures

    if plot is not None:
        write(figures.dispersion(study, scene.speaker), plot)
    if plot_saturation is not None:
        write(figures.saturation(study), plot_saturation)
    write_netcdf(study, save)
    if int(summary["failed"]):
        raise output.failure(f"{int(summary['failed'])} of {int(summary['runs'])} runs failed", 1)


@output.guarded
def gravity_command(
    until: Annotated[
        float, typer.Option("--until", "-u", metavar="SECONDS", help="End of the movements without commands, s.")
    ] = 1.0,
    vowel_until: Annotated[
        float, typer.Option("--vowel-until", metavar="SECONDS", help="End of the movements to vowels, s.")
    ] = 0.2,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    plot: PlotOption = None,
    plot_forces: Annotated[
        Path | None, typer.Option("--plot-forces", metavar="FILE", help="Picture of the forces of GGp in vowels.")
    ] = None,
    save: SaveOption = None,
    as_json: JsonOption = False,
) -> None:
    """Upright, supine, and without gravity (section V): shapes without commands, and movements to /i/, /u/ and /a/.

    --plot draws the shapes with silent muscles and with the reflex only as figs 12 and 13.
    """
    check_outputs(plot, plot_forces)
    check_output(save, (".nc",))
    scene = make_scene(make_speaker(speaker, resolution, landmarks), "upright", mirror, contact, friction, hyoid)
    study = gravity(scene, CARDINALS, until=until, vowel_until=vowel_until, progress=_told())
    if as_json:
        output.print_json(paper_output.gravity_json(study))
    else:
        paper_output.print_gravity(study)
    from glossa import figures

    if plot is not None:
        write(figures.gravity_shapes(study, scene.speaker), plot)
    if plot_forces is not None:
        write(figures.gravity_forces(study), plot_forces)
    write_netcdf(study, save)
    refuse_failed([*study["final_reason"].values.ravel(), *study["static_reason"].values.ravel()])
    refuse_failed(study["vowel_reason"].values.ravel().tolist())


@output.guarded
def transversalis_command(
    vowel: VowelArgument = "i",
    voluntary: Annotated[
        float, typer.Option("--voluntary", metavar="FRACTION", help="Command of the transversalis in the third run.")
    ] = VOLUNTARY,
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
    """A vowel with the transversalis by reflex, silent, and activated voluntarily (section III.B)."""
    name = vowel_name(vowel)
    check_outputs(plot)
    check_output(save, (".nc",))
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    study = transversalis(scene, name, voluntary=voluntary)
    if as_json:
        output.print_json(paper_output.transversalis_json(study))
    else:
        paper_output.print_transversalis(study)
    if plot is not None:
        from glossa import figures

        write(figures.transversalis(study, scene.speaker), plot)
    write_netcdf(study, save)
    refuse_failed(study["reason"].values.tolist())


@output.guarded
def delay_command(
    vowel: VowelArgument = "i",
    delays: Annotated[
        str, typer.Option("--delays", metavar="MS", help="Milliseconds, rising, such as 5,10,17.")
    ] = ",".join(f"{1e3 * value:g}" for value in DELAYS),
    until: Annotated[float, typer.Option("--until", "-u", metavar="SECONDS", help="End of the movements, s.")] = 0.2,
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
    """The movement to a vowel with several delays of the reflex (section II.C.1): paths, speeds and forces."""
    name = vowel_name(vowel)
    check_outputs(plot)
    check_output(save, (".nc",))
    values = [1e-3 * value for value in numbers("--delays", delays)]
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    study = delay(scene, name, values, until=until, progress=_told())
    if as_json:
        output.print_json(paper_output.delay_json(study))
    else:
        paper_output.print_delay(study)
    if plot is not None:
        from glossa import figures

        write(figures.delay_traces(study), plot)
    write_netcdf(study, save)
    refuse_failed(study["reason"].values.tolist())


def _told() -> Callable[[str], None] | None:
    """What is being computed, on stderr, where somebody looks on."""
    return output.say if sys.stderr.isatty() else None
