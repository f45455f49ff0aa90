"""Reader of Wavefront OBJ surfaces: vertices and faces of three or four corners."""

from __future__ import annotations

from pathlib import Path

from glossa.anatomy.walls import Wall
from glossa.errors import InputError, SpeakerFileError


def read_obj(path: Path, scale: float = 1.0) -> Wall:
    """Vertices (``v``) and faces (``f``) of an OBJ file; every other line is skipped.

    Args:
        path: the file.
        scale: factor to metres.

    Raises:
        FileNotFoundError: no such file.
        SpeakerFileError: a line that cannot be read (naming file and line), or a surface without faces.
    """
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                x, y, z = (float(word) * scale for word in words[1:4])
                vertices.append([x, y, z])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
                if len(corners) not in (3, 4):
                    raise ValueError(f"{len(corners)} corners")
                faces.append(corners)
        except (ValueError, OverflowError) as error:
            raise SpeakerFileError(f"{path}, line {number}: cannot read {line!r} ({error})") from None
    if not faces:
        raise SpeakerFileError(f"{path}: no faces; is this a Wavefront OBJ surface?")
    columns = max(len(face) for face in faces)
    try:
        return Wall(vertices, [face + face[-1:] * (columns - len(face)) for face in faces])
    except InputError as error:
        raise SpeakerFileError(f"{path}: {error}") from None
