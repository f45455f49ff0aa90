"""Landmark tables as they stand in TOML files, and how entries of them are found, replaced and added to.

A name "table.entry" stands for a list of numbers of the tongue's tables, for a column of a table of the walls, or, as
"hyoid.springs", for the ends of all springs.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.data_files import data_path
from glossa.errors import InputError

Tables = dict[str, Any]

FILES = {"tongue": "landmarks/reference_tongue.toml", "walls": "landmarks/reference_walls.toml"}
"""Of the built-in speaker, in the data folder."""

SPRINGS = "hyoid.springs"


def read_toml(path: Path) -> Tables:
    """What a TOML file holds.

    Raises:
        InputError: no such file, or no TOML; the message names the file.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:  # no UTF-8, no TOML, too long a number, too many brackets
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"cannot read the landmarks {path}: {error.strerror}") from None


def built_in_tables(part: str) -> Tables:
    """The tables of a file of ``FILES`` by name, without its head."""
    return {name: table for name, table in read_toml(data_path(FILES[part])).items() if isinstance(table, dict)}


def entries(tables: Tables) -> list[str]:
    """Names of all entries that weights of a shape parameter may be for."""
    names: list[str] = []
    for title, table in tables.items():
        if "rows" in table:
            names += [f"{title}.{column}" for column in table["columns"]]
            names += [SPRINGS] * ("springs" in table)
        else:
            names += [f"{title}.{entry}" for entry, value in table.items() if not isinstance(value, dict)]
    return names


def weights_shape(tables: Tables, name: str) -> tuple[int, ...]:
    """Shape of the weights for an entry of ``entries``."""
    if name == SPRINGS:
        return (2, 3)
    title, entry = name.split(".")
    table = tables[title]
    return (len(table["rows"]),) if "rows" in table else np.shape(table[entry])


def add_to_entry(tables: Tables, name: str, change: FloatArray) -> None:
    """Add to an entry of ``entries``, in place; ``change`` is shaped as ``weights_shape`` says."""
    title, entry = name.split(".")
    table = tables[title]
    if name == SPRINGS:
        table[entry] = {spring: (np.array(ends) + change).tolist() for spring, ends in table[entry].items()}
    elif "rows" in table:
        column = table["columns"].index(entry)
        for row, extra in zip(table["rows"], change.tolist(), strict=True):
            row[column] += extra
    else:
        table[entry] = (np.array(table[entry]) + change).tolist()


def replace_entries(tables: Tables, title: str, given: Any) -> list[str]:
    """Put the entries of one table that are ``given`` in the place of those of ``tables``; returns what differs.

    Tables of rows take whole ``rows``, or single columns by name; springs are replaced one by one.

    Raises:
        InputError: not a table, an unknown entry, or a column of another length than the rows.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"[{title}] must be a table, got {given!r}")
    table, changed = tables[title], []
    columns = list(table["columns"]) if "rows" in table else []
    known = [*table, *columns]
    for entry in sorted(given, key=lambda entry: entry != "rows"):  # columns go into the rows that are given
        value = _plain(given[entry])
        if entry not in known:
            raise InputError(f"[{title}] has no entry {entry!r}; known are {', '.join(known)}")
        if entry == "springs":
            changed += [f"[{title}.springs] {spring}" for spring in _replace_springs(table["springs"], value)]
        elif entry in columns:
            changed += [f"[{title}] {entry}"] * _replace_column(table, title, entry, value)
        else:
            changed += [f"[{title}] {entry}"] * (table[entry] != value)
            table[entry] = value
    return changed


def _replace_springs(springs: dict[str, Any], given: Any) -> list[str]:
    unknown = [name for name in given if name not in springs] if isinstance(given, dict) else [given]
    if unknown:
        raise InputError(f"[hyoid.springs] has no spring {unknown[0]!r}; known are {', '.join(springs)}")
    changed = [name for name, ends in given.items() if ends != springs[name]]
    springs.update(given)
    return changed


def _replace_column(table: dict[str, Any], title: str, entry: str, value: Any) -> bool:
    column, rows = table["columns"].index(entry), table["rows"]
    if not isinstance(value, list) or len(value) != len(rows):
        raise InputError(f"[{title}] {entry} must be a list of {len(rows)} values, one for each row, got {value!r}")
    before = [row[column] for row in rows]
    for row, new in zip(rows, value, strict=True):
        row[column] = new
    return before != value


def _plain(value: Any) -> Any:
    """An own copy in lists, dicts and scalars, as TOML gives them."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return deepcopy(value)
