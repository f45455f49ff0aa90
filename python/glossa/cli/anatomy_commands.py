"""Commands that show a speaker's anatomy and compute nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from glossa.anatomy.shape import shape_parameters
from glossa.anatomy.speaker_landmarks import load_landmarks
from glossa.cli import anatomy_output, output
from glossa.cli.files import write
from glossa.cli.options import (
    PICTURES,
    JsonOption,
    LandmarksOption,
    PlotOption,
    ResolutionOption,
    SpeakerOption,
    check_output,
    make_speaker,
)
from glossa.errors import InputError


@output.guarded
def muscles_command(
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> None:
    """The muscles of a speaker; --plot draws elements, fibres and insertions as fig. 1."""
    check_output(plot, PICTURES)
    body = make_speaker(speaker, resolution, landmarks)
    if as_json:
        output.print_json({"speaker": body.name, "muscles": anatomy_output.muscles_json(body)})
    else:
        anatomy_output.print_muscles(body)
    if plot is not None:
        from glossa.figures import muscles

        write(muscles(body), plot)


@output.guarded
def speaker_command(
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    shape: Annotated[
        bool, typer.Option("--shape", help="List the shape parameters that a file of --landmarks may change.")
    ] = False,
    summary: Annotated[bool, typer.Option("--summary", help="Print the summary, also with --save.")] = False,
    plot: PlotOption = None,
    save: Annotated[Path | None, typer.Option("--save", metavar="FILE", help="Write the speaker to one file.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Summary and quality of a speaker; --plot draws its sections; --save copies it in glossa's own file format."""
    check_output(plot, PICTURES)
    check_output(save)
    if shape:
        _show_shape(speaker, landmarks, as_json)
        if plot is None and save is None:
            return
    body = make_speaker(speaker, resolution, landmarks)
    if as_json and not shape:
        output.print_json(anatomy_output.speaker_json(body))
    elif not shape and (summary or save is None):
        typer.echo(body.summary())
        typer.echo(body.quality().text())
    if plot is not None:
        from glossa import figures

        write(figures.speaker(body), plot)
    if save is not None:
        body.save(save)
        output.wrote(save)


def _show_shape(speaker: str, landmarks: Path | None, as_json: bool) -> None:
    if speaker != "reference":
        raise InputError("--shape lists parameters of the built-in speaker; leave --speaker out")
    parameters, chosen = shape_parameters(), load_landmarks(landmarks)
    if as_json:
        output.print_json({"landmarks": chosen.name, "shape": anatomy_output.shape_json(parameters, chosen.shape)})
    else:
        anatomy_output.print_shape(parameters, chosen.shape)
