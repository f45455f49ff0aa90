"""The landmarks that a built-in speaker is generated from, and how a user's file changes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from glossa.anatomy.landmark_tables import FILES, Tables, built_in_tables, read_toml, replace_entries
from glossa.anatomy.landmarks import Landmarks, tongue_landmarks
from glossa.anatomy.shape import ShapeParameter, shape_parameters
from glossa.anatomy.wall_landmarks import WallLandmarks, wall_landmarks
from glossa.checks import finite_number
from glossa.data_files import data_path
from glossa.errors import InputError

_BUILT_IN = "reference"
_HEAD = {
    "format": ("glossa-landmarks", "glossa-wall-landmarks"),
    "version": (1,),
    "length_unit": ("mm",),
    "angle_unit": ("degree",),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeakerLandmarks:
    """Landmarks of tongue, walls and hyoid with all shape parameters applied.

    Attributes:
        tongue: of the body.
        walls: of walls and hyoid.
        name: free text.
        shape: total value of every shape parameter, in its unit.
        changes: what differs from the built-in landmarks, a few words each; empty where nothing does.
    """

    tongue: Landmarks
    walls: WallLandmarks
    name: str
    shape: Mapping[str, float]
    changes: tuple[str, ...]


def load_landmarks(source: str | Path | Mapping[str, Any] | None = None) -> SpeakerLandmarks:
    """The built-in landmarks with the changes of a TOML file, or of a mapping with the same content.

    Everything in it is optional:

    - ``[shape]``: values added to those of the shape parameters, for example ``vault_height = 4``, in their units;
    - ``[rays]``, ``[lateral]``, ``[spacing]``, ``[styloid]``: entries in place of those of reference_tongue.toml;
    - ``[outer]``, ``[larynx_front]``, ``[mandible]``, ``[hyoid]``: likewise for reference_walls.toml, as whole ``rows``
      or as single columns by name;
    - ``name``: of the speaker; otherwise that of the file.

    Shape parameters are added after entries are replaced, so that a copy of a built-in table changes nothing.

    Args:
        source: path, mapping, or None for the built-in landmarks.

    Raises:
        InputError: unreadable file, unknown entries, values outside of their limits, or malformed tables; the message
            names file, table and entry.
    """
    given, where, name = _read(source)
    parameters = shape_parameters()
    tables = {part: built_in_tables(part) for part in FILES}
    try:
        _check_head(given, tables, parameters)
        changes = [
            change
            for part in tables.values()
            for title in part
            if title in given
            for change in replace_entries(part, title, given[title])
        ]
        extra = _shape(given.get("shape", {}), parameters)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    except (TypeError, ValueError, IndexError, AttributeError) as error:
        raise InputError(f"{where}: malformed entry ({error})") from None
    changes += [f"[shape] {key} {value:+g} {parameters[key].unit}" for key, value in extra.items() if value != 0.0]
    values = {key: parameter.value + extra.get(key, 0.0) for key, parameter in parameters.items()}
    files = {part: where if source is not None else str(data_path(FILES[part])) for part in FILES}
    built = [_built(part, tables[part], parameters, values, files[part]) for part in FILES]
    if not name:
        name = f"changed {_BUILT_IN}" if changes else _BUILT_IN
    return SpeakerLandmarks(tongue=built[0], walls=built[1], name=name, shape=values, changes=tuple(changes))


def _read(source: str | Path | Mapping[str, Any] | None) -> tuple[Mapping[str, Any], str, str]:
    """Content, how messages call it, and the name it gives to a speaker, or none."""
    if source is None:
        return {}, _BUILT_IN, ""
    if isinstance(source, str | Path):
        content: Mapping[str, Any] = read_toml(Path(source))
        where, name = str(source), content.get("name", Path(source).stem)
    elif isinstance(source, Mapping):
        content, where, name = source, "landmarks", source.get("name", "")
    else:
        raise InputError(f"landmarks must be the path of a TOML file or a mapping, got {type(source).__name__}")
    if not isinstance(name, str):
        raise InputError(f"{where}: name must be a text, got {name!r}")
    return content, where, name


def _check_head(
    given: Mapping[str, Any], tables: Mapping[str, Tables], parameters: Mapping[str, ShapeParameter]
) -> None:
    """Known entries only, in known units."""
    titles = ["shape", *(title for part in tables.values() for title in part)]
    for key, value in given.items():
        if key in _HEAD:
            if value not in _HEAD[key]:
                raise InputError(f"{key} must be {' or '.join(map(repr, _HEAD[key]))}, got {value!r}")
        elif key in parameters:
            raise InputError(f"shape parameters belong into the table [shape]: put {key!r} there")
        elif key not in titles and key != "name":
            raise InputError(f"unknown entry {key!r}; known are the tables {', '.join(titles)}, and name")


def _shape(given: Any, parameters: Mapping[str, ShapeParameter]) -> dict[str, float]:
    """Values that a user adds."""
    if not isinstance(given, Mapping):
        raise InputError(f"[shape] must be a table, got {given!r}")
    values = {}
    for key, value in given.items():
        if key not in parameters:
            raise InputError(f"[shape] has no parameter {key!r}; known are {', '.join(parameters)}")
        parameter = parameters[key]
        values[key] = finite_number(value, f"[shape] {key}")
        low, high = parameter.room
        if not low <= values[key] <= high:
            raise InputError(f"[shape] {key} must lie between {low:g} and {high:g} {parameter.unit}, got {value!r}")
    return values


def _built(
    part: str, tables: Tables, parameters: Mapping[str, ShapeParameter], values: Mapping[str, float], where: str
) -> Any:
    """Checked landmarks of a part; tables are checked before anything is added to them, and after."""
    build: Any = tongue_landmarks if part == "tongue" else wall_landmarks
    try:
        landmarks = build(tables)
        chosen = [parameter for key, parameter in parameters.items() if values[key] != 0.0]
        for parameter in chosen:
            parameter.add_to(part, tables, values[parameter.name])
        return build(tables) if chosen else landmarks
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{where}: missing or malformed entry {error}") from None
