"""Options of the command line, and what they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from glossa.anatomy.reference import block_resolution
from glossa.anatomy.speaker import Speaker
from glossa.effects import DEFAULT
from glossa.errors import InputError
from glossa.motor.commands import VOWELS
from glossa.scene import Scene

PICTURES = (".png", ".pdf", ".svg")

SpeakerOption = Annotated[
    str,
    typer.Option(
        "--speaker",
        "-s",
        metavar="SPEAKER",
        help="reference (built in), a speaker file, a folder with pb_tongue.json, or an ArtiSynth checkout.",
    ),
]
ResolutionOption = Annotated[
    int,
    typer.Option("--resolution", "-r", metavar="R", help="Of the built-in speaker: every cell in R³."),
]
LandmarksOption = Annotated[
    Path | None,
    typer.Option(
        "--landmarks",
        metavar="FILE",
        help="Of the built-in speaker: a TOML file with what is to differ; glossa speaker --shape lists parameters.",
    ),
]
GravityOption = Annotated[
    str, typer.Option("--gravity", "-g", metavar="upright|supine|none", help="Direction of gravity.")
]
MirrorOption = Annotated[
    bool | None,
    typer.Option(
        "--mirror/--no-mirror",
        help="Compute one half only: the same result, faster.",
        show_default="on if symmetric",
    ),
]
ContactOption = Annotated[
    bool | None,
    typer.Option("--contact/--no-contact", help="Contact with the walls.", show_default="on if there are walls"),
]
FrictionOption = Annotated[
    float, typer.Option("--friction", metavar="MU", help="Coulomb coefficient of contact; 0 for none.")
]
HyoidOption = Annotated[
    str | None,
    typer.Option(
        "--hyoid",
        metavar="mobile|fixed",
        help="Whether the hyoid bone moves.",
        show_default="mobile if there is a bone",
    ),
]
EpgOption = Annotated[
    bool, typer.Option("--epg", help="Also print the palatogram: electrodes on the hard palate, # where touched.")
]
SpatialErrorOption = Annotated[
    bool,
    typer.Option("--spatial-error", help="Also estimate the error of the mesh, from a second solve: seconds each."),
]
PlotContactOption = Annotated[
    Path | None,
    typer.Option(
        "--plot-contact", metavar="FILE", help="Picture of what touches palate, velum and pharynx, from above."
    ),
]
PlotTractOption = Annotated[
    Path | None,
    typer.Option("--plot-tract", metavar="FILE", help="Picture of the area function, glottis to lips."),
]
PlotFormantsOption = Annotated[
    Path | None,
    typer.Option("--plot-formants", metavar="FILE", help="Picture of the transfer function, formants marked."),
]
WavOption = Annotated[
    Path | None, typer.Option("--wav", metavar="FILE", help="Sound (.wav), with the lips of Table IV.")
]
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FILE", help="Picture (.png, .pdf, .svg); without FILE, named after the command."),
]
Plot3dOption = Annotated[
    Path | None,
    typer.Option("--plot-3d", metavar="FILE", help="Picture of the surfaces in 3D, from the front and from behind."),
]
VtkOption = Annotated[
    Path | None,
    typer.Option("--vtk", metavar="FILE", help="Mesh for ParaView (.vtu or .vtk); needs the package meshio."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for machines, and nothing else, on stdout.")]
AccuracyOption = Annotated[
    str, typer.Option("--accuracy", metavar="draft|standard|reference", help="Of the time steps.")
]
StoreOption = Annotated[
    Path | None,
    typer.Option("--store", metavar="FILE", help="Keeps finished runs; the same command goes on from there."),
]
WorkersOption = Annotated[int, typer.Option("--workers", "-w", metavar="N", help="Processes on this machine.")]
SchedulerOption = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster, such as tcp://host:8786.")
]
SaveOption = Annotated[Path | None, typer.Option("--save", metavar="FILE", help="Write all results as NetCDF (.nc).")]
VowelArgument = Annotated[str, typer.Argument(metavar="VOWEL", help="i, a, u, or ə (@ on plain keyboards).")]


def make_speaker(name: str, resolution: int = 1, landmarks: Path | None = None) -> Speaker:
    """The speaker that ``--speaker``, ``--resolution`` and ``--landmarks`` ask for.

    Raises:
        InputError, FileNotFoundError: no such speaker, a resolution or landmarks that do not suit it, or landmarks that
            give no sound speaker.
    """
    if name == "reference":
        return Speaker.reference(resolution, landmarks)
    if landmarks is not None:
        raise InputError("--landmarks changes the built-in speaker only; leave it out with --speaker FILE or FOLDER")
    if resolution != 1:
        raise InputError("--resolution divides the built-in speaker only; leave it out with --speaker FILE or FOLDER")
    path = Path(name)
    if not path.exists():
        raise InputError(f"--speaker {name}: no such file or folder, and the only built-in speaker is 'reference'")
    if path.is_dir() and not (path / "pb_tongue.json").is_file():
        return Speaker.from_artisynth(path)
    return Speaker.load(path)


def finer_speaker(speaker: Speaker, landmarks: Path | None) -> Speaker | None:
    """For :meth:`glossa.Scene.spatial_error`: one with own landmarks at twice its resolution; None of any other."""
    return None if landmarks is None else Speaker.reference(2 * block_resolution(speaker), landmarks)


def make_scene(
    speaker: Speaker,
    gravity: str = "upright",
    mirror: bool | None = None,
    contact: bool | None = None,
    friction: float = 0.1,
    hyoid: str | None = None,
) -> Scene:
    """The scene that the options ask for; None leaves a choice to the speaker: ``mirror`` to its symmetry.

    Raises:
        InputError: an unknown direction or hyoid, what the speaker lacks, or a half model of one that is not symmetric.
    """
    if gravity not in ("upright", "supine", "none"):
        raise InputError(f"--gravity must be upright, supine or none, got {gravity!r}")
    if hyoid not in (None, "mobile", "fixed"):
        raise InputError(f"--hyoid must be mobile or fixed, got {hyoid!r}")
    make = partial(
        Scene,
        speaker,
        gravity=None if gravity == "none" else gravity,
        contact=DEFAULT if contact is None else contact,
        friction=friction,
        hyoid=DEFAULT if hyoid is None else hyoid,
    )
    if mirror is not None:
        return make(mirror=mirror)
    try:
        return make(mirror=True)
    except InputError:  # not symmetric, or a fault that the full model has, too
        return make(mirror=False)


def vowel_name(given: str) -> str:
    """Name of a vowel of Table III; "@" stands for ə.

    Raises:
        InputError: another name.
    """
    name = "ə" if given == "@" else given.strip("/[]")
    if name not in VOWELS:
        raise InputError(f"unknown vowel {given!r}; choose i, a, u or ə (also written @)")
    return name


def numbers(option: str, text: str) -> list[float]:
    """Numbers with commas between them.

    Raises:
        InputError: something else; the message names the option.
    """
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} must be numbers with commas between them, got {text!r}") from None


def whole_numbers(option: str, text: str) -> list[int]:
    """Whole numbers with commas between them.

    Raises:
        InputError: something else; the message names the option.
    """
    values = numbers(option, text)
    whole = [int(value) for value in values if value.is_integer()]
    if len(whole) < len(values):
        raise InputError(f"{option} must be whole numbers, got {text!r}")
    return whole


def check_output(path: Path | None, suffixes: Sequence[str] = ()) -> None:
    """Refuse a file that could not be written, before anything is computed.

    Raises:
        InputError: no such folder, a folder in its place, or another kind of file than ``suffixes`` name.
    """
    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(f"cannot write {path}: its name must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder")


def with_picture_names(arguments: Sequence[str]) -> list[str]:
    """Arguments in which every picture option has a file: ``glossa vowel i --plot`` writes vowel-i.png."""
    listed = list(arguments)
    words = [word for word in listed[:2] if not word.startswith("-")]
    stem = "-".join(words).replace("@", "schwa").replace("ə", "schwa")
    result = []
    for k, word in enumerate(listed):
        bare = k + 1 == len(listed) or listed[k + 1].startswith("-")
        named = word in ("--plot", "--plot-3d", "--plot-contact") and bare
        result.append(f"{word}={stem}{word.removeprefix('--plot')}.png" if named else word)
    return result
