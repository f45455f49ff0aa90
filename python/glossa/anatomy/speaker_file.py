"""The speaker file: one JSON document that holds a whole speaker, SI units, indices from 0.

::

    {"format": "glossa-speaker", "version": 2, "name": "...",
     "nodes": [[x, y, z], ...],                                   metres
     "hexahedra": [[8 node indices, VTK order], ...],
     "muscles": {name: {"elements": [...], "fibres": [[nodes], ...],
                        "force_capacity": N, "fibres_per_element": count or null,
                        "peak_multiplier": number}},
     "node_sets": {name: [nodes]}, "contours": {name: [nodes in order]},
     "walls": {name: {"vertices": [[x, y, z], ...], "faces": [[3 or 4 vertices], ...]}},
     "contact_faces": {wall: [[4 nodes of a boundary face], ...]},   may be absent: no wall has faces of its own
     "hyoid": null or {"surface": null or wall, "mass": kg, "centre": [x, y, z],
                       "springs": [{"on_hyoid": [x, y, z], "fixed": [x, y, z], "stiffness": N/m,
                                    "rest_length": m, "name": "..."}]}}

Numbers are written with the shortest text that reads back to the same double, so a round trip is exact.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from glossa.anatomy.muscle import Muscle
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Spring, Wall
from glossa.errors import InputError, SpeakerFileError

FORMAT = "glossa-speaker"
VERSION = 2


def save_speaker(speaker: Speaker, path: Path) -> None:
    """Write ``speaker`` to ``path``: complete or not at all (temporary file in the same folder, then a rename)."""
    text = json.dumps(_document(speaker), allow_nan=False, separators=(",", ":"))
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.write("\n")
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def load_speaker(path: Path) -> Speaker:
    """Read a speaker file.

    Raises:
        FileNotFoundError: no such file.
        SpeakerFileError: truncated, foreign, of another version, or inconsistent; the message says what and where.
    """
    try:
        text = path.read_bytes().decode("utf-8")
        document = json.loads(text)
    except UnicodeDecodeError:
        raise SpeakerFileError(f"{path}: not a speaker file (not UTF-8 text)") from None
    except json.JSONDecodeError as error:
        state = "ends too early (truncated)" if error.pos >= len(text.rstrip()) - 1 else "is not valid JSON"
        raise SpeakerFileError(f"{path} {state} at line {error.lineno}, column {error.colno}: {error.msg}") from None
    except RecursionError:
        raise SpeakerFileError(f"{path}: not a speaker file (nested too deeply)") from None
    except ValueError as error:  # a number of thousands of digits
        raise SpeakerFileError(f"{path}: not a speaker file ({error})") from None
    _check_header(path, document)
    reader = _Reader(path)
    try:
        return reader.speaker(document)
    except SpeakerFileError:
        raise
    except InputError as error:
        raise SpeakerFileError(f"{path}: {error}") from None


def _check_header(path: Path, document: Any) -> None:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise SpeakerFileError(f'{path}: not a speaker file (its "format" is not "{FORMAT}")')
    if document.get("version") != VERSION:
        raise SpeakerFileError(
            f"{path}: speaker file version {document.get('version')!r}; this program reads version {VERSION}"
        )


def _document(speaker: Speaker) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": speaker.name,
        "nodes": speaker.nodes.tolist(),
        "hexahedra": speaker.hexahedra.tolist(),
        "muscles": {
            name: {
                "elements": muscle.elements.tolist(),
                "fibres": [fibre.tolist() for fibre in muscle.fibres],
                "force_capacity": muscle.force_capacity,
                "fibres_per_element": muscle.fibres_per_element,
                "peak_multiplier": muscle.peak_multiplier,
            }
            for name, muscle in speaker.muscles.items()
        },
        "node_sets": {name: nodes.tolist() for name, nodes in speaker.node_sets.items()},
        "contours": {name: nodes.tolist() for name, nodes in speaker.contours.items()},
        "walls": {name: _wall_document(wall) for name, wall in speaker.walls.items()},
        "contact_faces": {wall: faces.tolist() for wall, faces in speaker.contact_faces.items()},
        "hyoid": _hyoid_document(speaker.hyoid),
    }


def _wall_document(wall: Wall) -> dict[str, Any]:
    return {"vertices": wall.vertices.tolist(), "faces": wall.faces.tolist()}


def _hyoid_document(hyoid: Hyoid | None) -> dict[str, Any] | None:
    if hyoid is None:
        return None
    return {
        "surface": None if hyoid.surface is None else _wall_document(hyoid.surface),
        "mass": hyoid.mass,
        "centre": hyoid.centre.tolist(),
        "springs": [
            {
                "on_hyoid": spring.on_hyoid.tolist(),
                "fixed": spring.fixed.tolist(),
                "stiffness": spring.stiffness,
                "rest_length": spring.rest_length,
                "name": spring.name,
            }
            for spring in hyoid.springs
        ],
    }


class _Reader:
    """Turns the parts of a document into objects; ``path`` names the file in messages."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def speaker(self, document: dict[str, Any]) -> Speaker:
        muscles = self._mapping(document, "muscles")
        walls = self._mapping(document, "walls")
        hyoid = self._entry(document, "hyoid", "the file")
        return Speaker(
            self._entry(document, "nodes", "the file"),
            self._entry(document, "hexahedra", "the file"),
            muscles={name: self._muscle(entry, f"muscle {name!r}") for name, entry in muscles.items()},
            node_sets=self._mapping(document, "node_sets"),
            walls={name: self._wall(entry, f"wall {name!r}") for name, entry in walls.items()},
            hyoid=None if hyoid is None else self._hyoid(hyoid),
            contours=self._mapping(document, "contours"),
            name=self._entry(document, "name", "the file"),
            contact_faces=self._mapping(document, "contact_faces") if "contact_faces" in document else {},
        )

    def _entry(self, mapping: Any, key: str, where: str) -> Any:
        if not isinstance(mapping, dict):
            raise SpeakerFileError(f"{self.path}: {where} must be a JSON object, got {type(mapping).__name__}")
        if key not in mapping:
            raise SpeakerFileError(f"{self.path}: {where} lacks the entry {key!r}")
        return mapping[key]

    def _mapping(self, document: dict[str, Any], key: str) -> dict[str, Any]:
        value = self._entry(document, key, "the file")
        if not isinstance(value, dict):
            raise SpeakerFileError(f"{self.path}: {key!r} must be a JSON object, got {type(value).__name__}")
        return value

    def _muscle(self, entry: Any, where: str) -> Muscle:
        keys = ("elements", "fibres", "force_capacity", "fibres_per_element", "peak_multiplier")
        values = [self._entry(entry, key, where) for key in keys]
        if not isinstance(values[1], list):
            raise SpeakerFileError(f"{self.path}: {where}: 'fibres' must be a list of node lists")
        try:
            return Muscle(*values)
        except InputError as error:
            raise SpeakerFileError(f"{self.path}: {where}: {error}") from None

    def _wall(self, entry: Any, where: str) -> Wall:
        vertices, faces = self._entry(entry, "vertices", where), self._entry(entry, "faces", where)
        try:
            return Wall(vertices, faces)
        except (InputError, ValueError) as error:
            raise SpeakerFileError(f"{self.path}: {where}: {error}") from None

    def _hyoid(self, entry: Any) -> Hyoid:
        surface = self._entry(entry, "surface", "hyoid")
        springs = self._entry(entry, "springs", "hyoid")
        if not isinstance(springs, list):
            raise SpeakerFileError(f"{self.path}: hyoid: 'springs' must be a list")
        return Hyoid(
            None if surface is None else self._wall(surface, "hyoid surface"),
            self._entry(entry, "mass", "hyoid"),
            self._entry(entry, "centre", "hyoid"),
            tuple(self._spring(spring, f"hyoid spring {i}") for i, spring in enumerate(springs)),
        )

    def _spring(self, entry: Any, where: str) -> Spring:
        keys = ("on_hyoid", "fixed", "stiffness", "rest_length", "name")
        return Spring(*(self._entry(entry, key, where) for key in keys))
