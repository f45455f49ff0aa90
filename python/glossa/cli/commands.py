"""The commands. Each reads options, computes, and hands results to figures, files and output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
import xarray as xr

import glossa
from glossa import paper
from glossa.acoustics import AreaFunction, synthesize
from glossa.cli import output
from glossa.cli.accuracy_command import accuracy_command
from glossa.cli.anatomy_commands import muscles_command, speaker_command
from glossa.cli.calibration_commands import calibrate_command, resolution_command
from glossa.cli.files import check_outputs, need, need_tracts, write, write_posture, write_tracts
from glossa.cli.options import (
    PICTURES,
    AccuracyOption,
    ContactOption,
    EpgOption,
    FrictionOption,
    GravityOption,
    HyoidOption,
    JsonOption,
    LandmarksOption,
    MirrorOption,
    Plot3dOption,
    PlotContactOption,
    PlotFormantsOption,
    PlotOption,
    PlotTractOption,
    ResolutionOption,
    SpatialErrorOption,
    SpeakerOption,
    VowelArgument,
    VtkOption,
    WavOption,
    check_output,
    finer_speaker,
    make_scene,
    make_speaker,
    vowel_name,
)
from glossa.cli.paper_commands import delay_command, gravity_command, sensitivity_command, transversalis_command
from glossa.cli.replicate_command import replicate_command
from glossa.cli.size_command import size_command
from glossa.cli.spatial_output import print_spatial_errors, spatial_json
from glossa.cli.stability_command import stability_command
from glossa.cli.study_commands import sweep_command
from glossa.errors import InputError
from glossa.motor import VOWELS, Ramp
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies import (
    effect_costs,
    formant_table,
    movement_tracts,
    posture_table,
    rest_posture,
    single_muscle,
    single_muscle_command,
    spatial_errors,
    vowel_tracts,
    vowels,
)

SOUND_FRAME = 0.010
"""Between the area functions from which the sound of a movement is made, s."""

AFTERSOUND = 0.2
"""How long the sound of a movement holds its last tract, s."""

app = typer.Typer(
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"]},
    epilog="Example: glossa vowels --plot vowels.png",
)


@app.callback(invoke_without_command=True)
def glossa_command(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.", is_eager=True)] = False,
) -> None:
    """A simulator of the human tongue: motor commands in, tongue shapes out.

    Results go to stdout, everything else to stderr. Every command has its own --help.

    Exit codes: 0 done, 1 a solve failed, 2 wrong input, 130 interrupted.
    """
    if version:
        typer.echo(glossa.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit


@app.command("vowels", epilog="Examples: glossa vowels | glossa vowels --plot v.pdf | glossa vowels -g supine --json")
@output.guarded
def vowels_command(
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    epg: EpgOption = False,
    spatial_error: SpatialErrorOption = False,
    plot: PlotOption = None,
    plot_3d: Plot3dOption = None,
    plot_contact: PlotContactOption = None,
    plot_tract: PlotTractOption = None,
    plot_formants: PlotFormantsOption = None,
    as_json: JsonOption = False,
) -> None:
    """The equilibria of /i/, /ə/, /u/ and /a/ (Table III): forces and formants beside the paper's, shapes, contact."""
    check_outputs(plot, plot_3d, plot_contact, plot_tract, plot_formants)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    _check_contact(scene, epg, plot_contact)
    postures = vowels(scene)
    table = posture_table(postures)
    tracts, reasons = vowel_tracts(postures)
    formants = formant_table(tracts) if tracts else None
    errors = spatial_errors(scene, postures, finer=finer_speaker(scene.speaker, landmarks)) if spatial_error else None
    if as_json:
        rows = {
            name: output.posture_json(table, name, posture, formants, epg=epg) | _errors_json(errors, name)
            for name, posture in postures.items()
        }
        output.print_json({"speaker": scene.speaker.name, "vowels": rows})
    else:
        output.print_postures(scene, postures, table, epg=epg)
        output.print_formants(formants, reasons)
        if errors is not None:
            print_spatial_errors(errors)
    from glossa import figures

    if plot is not None:
        write(figures.overview(postures, paper.forces()), plot)
    if plot_3d is not None:
        write(figures.surfaces(postures), plot_3d)
    if plot_contact is not None:
        write(figures.contact_map(postures), plot_contact)
    write_tracts(tracts, reasons, plot_tract, plot_formants)
    _refuse_unconverged(postures)


@app.command(
    "vowel", epilog="Examples: glossa vowel i --plot i.png --vtk i.vtu | glossa vowel @ --spatial-error --json"
)
@output.guarded
def vowel_command(
    vowel: VowelArgument,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    epg: EpgOption = False,
    spatial_error: SpatialErrorOption = False,
    plot: PlotOption = None,
    plot_3d: Plot3dOption = None,
    plot_contact: PlotContactOption = None,
    plot_tract: PlotTractOption = None,
    plot_formants: PlotFormantsOption = None,
    vtk: VtkOption = None,
    wav: WavOption = None,
    as_json: JsonOption = False,
) -> None:
    """The equilibrium of one vowel: shape, contact, formants and sound."""
    name = vowel_name(vowel)
    check_outputs(plot, plot_3d, plot_contact, plot_tract, plot_formants, vtk=vtk)
    check_output(wav, (".wav",))
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    _check_contact(scene, epg, plot_contact)
    posture = vowels(scene, [name])[name]
    tracts, reasons = vowel_tracts({name: posture})
    finer = finer_speaker(scene.speaker, landmarks) if spatial_error else None
    errors = spatial_errors(scene, {name: posture}, finer=finer) if spatial_error else None
    _report_posture(scene, name, posture, {"vowel": name}, as_json, epg, (tracts, reasons), errors)
    write_posture(name, posture, plot, plot_3d, plot_contact, vtk)
    write_tracts(tracts, reasons, plot_tract, plot_formants)
    if wav is not None:
        need_tracts("--wav", tracts, reasons)
        synthesize(tracts[name]).save(wav)
        output.wrote(wav)


@app.command("movement", epilog="Examples: glossa movement i --plot i.png | glossa movement u --until 0.4 --save u.nc")
@output.guarded
def movement_command(
    vowel: VowelArgument,
    until: Annotated[float, typer.Option("--until", "-u", metavar="SECONDS", help="End of the movement, s.")] = 0.2,
    ramp: Annotated[
        float, typer.Option("--ramp", metavar="SECONDS", help="Time the commands take to change, s.")
    ] = 0.03,
    accuracy: AccuracyOption = "standard",
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    plot: PlotOption = None,
    save: Annotated[Path | None, typer.Option("--save", metavar="FILE", help="Write it as NetCDF (.nc).")] = None,
    wav: WavOption = None,
    as_json: JsonOption = False,
) -> None:
    """The movement from rest to a vowel: tip and dorsum, and forces, over time; its sound with the vowel's lips."""
    name = vowel_name(vowel)
    check_output(plot, PICTURES)
    check_output(wav, (".wav",))
    check_output(save, (".nc",))
    schedule = Ramp(VOWELS[name], duration=ramp)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    movement = scene.simulate(schedule, until, accuracy=accuracy)
    if as_json:
        output.print_json(output.movement_json(movement, name))
    else:
        output.print_movement(movement, name)
    if save is not None:
        movement.save(save)
        output.wrote(save)
    if wav is not None:
        times = np.linspace(0.0, until, max(2, round(until / SOUND_FRAME) + 1))
        tracts = movement_tracts(movement, times, name)
        synthesize(tracts, duration=until + AFTERSOUND, times=times).save(wav)
        output.wrote(wav)
    if plot is not None:
        from glossa.figures import movement_traces

        write(movement_traces(movement), plot)


@app.command("muscle", epilog="Examples: glossa muscle GGp | glossa muscle Sty --command 0.9 --plot sty.png")
@output.guarded
def muscle_command(
    muscle: Annotated[str, typer.Argument(metavar="MUSCLE", help="GGa GGm GGp Sty HG Vert Trans IL SL GH MH.")],
    command: Annotated[
        float | None,
        typer.Option(
            "--command",
            "-c",
            metavar="FRACTION",
            help="Lambda as a fraction of rest length; less pulls harder.",
            show_default="0.75; 0.85 for Sty, IL, SL",
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
    epg: EpgOption = False,
    plot: PlotOption = None,
    plot_3d: Plot3dOption = None,
    plot_contact: PlotContactOption = None,
    vtk: VtkOption = None,
    as_json: JsonOption = False,
) -> None:
    """What one muscle does alone (section III.A.1, fig. 5): every other muscle is silent."""
    check_outputs(plot, plot_3d, plot_contact, vtk=vtk)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    _check_contact(scene, epg, plot_contact)
    posture = single_muscle(scene, muscle, command)
    fraction = single_muscle_command(muscle) if command is None else command
    _report_posture(scene, muscle, posture, {"muscle": muscle, "command": fraction}, as_json, epg)
    write_posture(muscle, posture, plot, plot_3d, plot_contact, vtk)


app.command("muscles", epilog="Examples: glossa muscles | glossa muscles --plot muscles.png")(muscles_command)
app.command(
    "speaker", epilog="Examples: glossa speaker -r 2 --save fine.json | glossa speaker --landmarks my.toml --plot"
)(speaker_command)
app.command("calibrate", epilog="Examples: glossa calibrate --show | glossa calibrate --save shape.toml")(
    calibrate_command
)
app.command("resolution", epilog="Examples: glossa resolution | glossa resolution -r 1,2,4 --json")(resolution_command)
app.command("accuracy", epilog="Examples: glossa accuracy --show | glossa accuracy --save accuracy.nc --plot")(
    accuracy_command
)
app.command("size", epilog="Examples: glossa size --show | glossa size -r 1,2 --counted 3,4 --plot size.png")(
    size_command
)
app.command(
    "sweep",
    epilog="Examples: glossa sweep -a command.GGp=0.55:0.65:5 -a gravity=upright,supine | glossa sweep -b u "
    "-a change.Sty=-10:10 -a tissue.c10=normal:1037:100 --random 1000 --seed 1 --store u.study -w 2 --save u.nc",
)(sweep_command)


app.command(
    "sensitivity", epilog="Examples: glossa sensitivity i --plot fig11.png | glossa sensitivity u --changes=-5,5 --json"
)(sensitivity_command)
app.command("gravity", epilog="Examples: glossa gravity --plot fig12.png | glossa gravity --until 0.3 --json")(
    gravity_command
)
app.command("transversalis", epilog="Examples: glossa transversalis | glossa transversalis --plot trans.png")(
    transversalis_command
)
app.command("delay", epilog="Examples: glossa delay i --plot delay.png | glossa delay u --delays 5,17 --json")(
    delay_command
)
app.command(
    "stability",
    epilog="Examples: glossa stability --show | glossa stability i --plot stability.png | glossa stability u "
    "--delays 10,17,25 --gains 5,10 --gradients 40 --json",
)(stability_command)
app.command(
    "replicate",
    epilog="Examples: glossa replicate --html paper.html | glossa replicate -s pb_folder -w 2 --store pb.study --json",
)(replicate_command)


@app.command("costs", epilog="Examples: glossa costs | glossa costs u --repetitions 5 --json")
@output.guarded
def costs_command(
    vowel: VowelArgument = "i",
    until: Annotated[float, typer.Option("--until", "-u", metavar="SECONDS", help="End of the movement, s.")] = 0.2,
    step: Annotated[float, typer.Option("--step", metavar="SECONDS", help="Time step, s.")] = 0.002,
    repetitions: Annotated[
        int, typer.Option("--repetitions", metavar="N", help="Runs of each scene; the shortest counts.")
    ] = 3,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    mirror: Annotated[bool, typer.Option("--mirror/--no-mirror", help="Compute one half only.")] = True,
    as_json: JsonOption = False,
) -> None:
    """What contact, friction, a mobile hyoid and gravity cost in a movement, and what leaving each out changes."""
    name = vowel_name(vowel)
    body = make_speaker(speaker, resolution, landmarks)
    costs = effect_costs(body, name, until, dt=step, mirror=mirror, repetitions=repetitions)
    if as_json:
        output.print_json(output.costs_json(costs))
    else:
        output.print_costs(costs)


@app.command("view", epilog="Examples: glossa view | glossa view i | glossa view i --muscle GGp --screenshot i.png")
@output.guarded
def view_command(
    vowel: Annotated[str | None, typer.Argument(metavar="VOWEL", help="i, a, u, ə (or @); left out: rest.")] = None,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    muscle: Annotated[str | None, typer.Option("--muscle", metavar="MUSCLE", help="Show its fibres.")] = None,
    springs: Annotated[bool, typer.Option("--springs", help="Show the springs of the hyoid.")] = False,
    screenshot: Annotated[Path | None, typer.Option("--screenshot", metavar="FILE", help="A PNG, no window.")] = None,
) -> None:
    """A 3D view to turn and zoom; needs pyvista, the extra "view" of this package."""
    name = None if vowel is None else vowel_name(vowel)
    check_output(screenshot, (".png",))
    need("pyvista", "the 3D view", "glossa[view]")
    body = make_speaker(speaker, resolution, landmarks)
    if name is None:
        posture = rest_posture(body)
    else:
        posture = make_scene(body, gravity, mirror, contact, friction, hyoid).equilibrate(VOWELS[name])
    from glossa.figures.interactive import view

    view(posture, muscle=muscle, springs=springs, screenshot=screenshot)
    if screenshot is not None:
        output.wrote(screenshot)


def _check_contact(scene: Scene, epg: bool, plot_contact: Path | None) -> None:
    """Refuse pictures of contact in a scene without, and palatograms of a speaker without palate."""
    for option, wanted in (("--epg", epg), ("--plot-contact", plot_contact is not None)):
        if wanted and not scene.contact:
            raise InputError(f"{option} shows contact, and this scene has none")
    if epg and "hard_palate" not in scene.speaker.walls:
        raise InputError(f"--epg needs the wall 'hard_palate'; this speaker has {', '.join(scene.speaker.walls)}")


def _report_posture(
    scene: Scene,
    name: str,
    posture: Posture,
    facts: dict[str, object],
    as_json: bool,
    epg: bool,
    acoustics: tuple[dict[str, AreaFunction], dict[str, str]] | None = None,
    errors: xr.Dataset | None = None,
) -> None:
    postures = {name: posture}
    table = posture_table(postures)
    tracts, reasons = acoustics or ({}, {})
    formants = formant_table(tracts) if tracts else None
    if as_json:
        entry = output.posture_json(table, name, posture, formants, epg=epg)
        output.print_json({"speaker": scene.speaker.name, **facts, **entry, **_errors_json(errors, name)})
    else:
        output.print_postures(scene, postures, table, epg=epg)
        output.print_formants(formants, reasons)
        if errors is not None:
            print_spatial_errors(errors)
    _refuse_unconverged(postures)


def _errors_json(errors: xr.Dataset | None, name: str) -> dict[str, object]:
    return {} if errors is None else {"spatial_error": spatial_json(errors, name)}


def _refuse_unconverged(postures: dict[str, Posture]) -> None:
    failed = {name: p.report for name, p in postures.items() if p.report is not None and not p.report.converged}
    if failed:
        words = "; ".join(f"{name}: {r.status} after {r.iterations} iterations" for name, r in failed.items())
        raise output.failure(f"no equilibrium ({words})", 1)
