"""Options of the command line, and what they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from glossa.anatomy.mirror import half_body
from glossa.anatomy.speaker import Speaker
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
VowelArgument = Annotated[str, typer.Argument(metavar="VOWEL", help="i, a, u, or ə (@ on plain keyboards).")]


def make_speaker(name: str, resolution: int = 1) -> Speaker:
    """The speaker that ``--speaker`` and ``--resolution`` ask for.

    Raises:
        InputError, FileNotFoundError: no such speaker, or a resolution that does not suit it.
    """
    if name == "reference":
        return Speaker.reference(resolution)
    if resolution != 1:
        raise InputError("--resolution divides the built-in speaker only; leave it out with --speaker FILE or FOLDER")
    path = Path(name)
    if not path.exists():
        raise InputError(f"--speaker {name}: no such file or folder, and the only built-in speaker is 'reference'")
    if path.is_dir() and not (path / "pb_tongue.json").is_file():
        return Speaker.from_artisynth(path)
    return Speaker.load(path)


def make_scene(speaker: Speaker, gravity: str = "upright", mirror: bool | None = None) -> Scene:
    """The scene that ``--gravity`` and ``--mirror`` ask for.

    Raises:
        InputError: an unknown direction, or a half model of a speaker that is not symmetric.
    """
    if gravity not in ("upright", "supine", "none"):
        raise InputError(f"--gravity must be upright, supine or none, got {gravity!r}")
    half = is_symmetric(speaker) if mirror is None else mirror
    return Scene(speaker, gravity=None if gravity == "none" else gravity, mirror=half)


def is_symmetric(speaker: Speaker) -> bool:
    """Whether the half model represents the speaker."""
    try:
        half_body(speaker)
    except InputError:
        return False
    return True


def vowel_name(given: str) -> str:
    """Name of a vowel of Table III; "@" stands for ə.

    Raises:
        InputError: another name.
    """
    name = "ə" if given == "@" else given.strip("/[]")
    if name not in VOWELS:
        raise InputError(f"unknown vowel {given!r}; choose i, a, u or ə (also written @)")
    return name


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
    """Arguments in which ``--plot`` and ``--plot-3d`` have a file: ``glossa vowel i --plot`` writes vowel-i.png."""
    listed = list(arguments)
    words = [word for word in listed[:2] if not word.startswith("-")]
    stem = "-".join(words).replace("@", "schwa").replace("ə", "schwa")
    result = []
    for k, word in enumerate(listed):
        bare = k + 1 == len(listed) or listed[k + 1].startswith("-")
        named = word in ("--plot", "--plot-3d") and bare
        result.append(f"{word}={stem}{word.removeprefix('--plot')}.png" if named else word)
    return result
