"""A study on disk: one SQLite file with a header and a record for each finished point.

Only the process that runs a study writes, each time a commit that reached the disk; whatever kills it leaves the
points committed so far, which the next run does not repeat. Numbers are stored as doubles in little-endian order,
every record with a checksum. Beside the file, ``<name>.lock`` tells that a study is running.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from glossa.errors import InputError
from glossa.studies.evaluation import Record

APPLICATION = 0x474C5354  # "GLST"
FORMAT = 2

_DOUBLES = np.dtype("<f8")
_WAIT = 30.0  # s for a reader to finish
_MOST = 200  # characters of a difference in a message
_TABLES = """
CREATE TABLE header (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE record (
    number INTEGER PRIMARY KEY, status TEXT NOT NULL, reason TEXT NOT NULL, acoustic_reason TEXT NOT NULL,
    started TEXT NOT NULL, iterations INTEGER NOT NULL, seconds REAL, worker TEXT NOT NULL, finished REAL NOT NULL,
    doubles BLOB NOT NULL, checksum INTEGER NOT NULL
);
"""
_COLUMNS = "number, status, reason, acoustic_reason, started, iterations, seconds, worker, finished, doubles, checksum"

COMPARED = {
    "speaker_fingerprint": "belongs to another speaker",
    "glossa_version": "was begun with another version of glossa",
    "scene": "has another scene",
    "start": "starts from another posture",
    "layout": "measures other quantities",
    "points": "has other points",
}
"""Entries of a header that have to agree when a study is resumed, and what it means where they do not."""


class Store:
    """An open store, locked against other writers; a context manager.

    Args:
        path: a file that is not there or empty, or the store of the same study.
        header: JSON values by name, with at least those of :data:`COMPARED`.

    Raises:
        InputError: a folder, a foreign or corrupt file, the store of another study (another speaker, scene, start,
            other points; another minor or major version of glossa: its numbers may differ), or one that another
            process is writing. Nothing is overwritten.
    """

    def __init__(self, path: str | Path, header: Mapping[str, Any]) -> None:
        self.path = _place(path)
        if not self.path.parent.is_dir():
            raise InputError(f"store {self.path}: there is no folder {self.path.parent}")
        self._lock = _locked(self.path)
        self._database: sqlite3.Connection | None = None
        try:
            self._database = _connected(self.path, create=True)
            with _explained(self.path):
                self._database.execute("PRAGMA synchronous=FULL")
                if _is_empty(self._database):
                    self._create(header)
                else:
                    _check_format(self._database, self.path)
                    _check_same(read_header(self._database, self.path), header, self.path)
        except BaseException:
            self.close()
            raise

    @property
    def _open(self) -> sqlite3.Connection:
        if self._database is None:
            raise InputError(f"store {self.path} is closed")
        return self._database

    def _create(self, header: Mapping[str, Any]) -> None:
        rows = [(name, _text(value)) for name, value in header.items()]
        database = self._open
        database.execute("BEGIN IMMEDIATE")
        for statement in _TABLES.split(";"):
            database.execute(statement)
        database.execute(f"PRAGMA application_id={APPLICATION}")
        database.execute(f"PRAGMA user_version={FORMAT}")
        database.executemany("INSERT INTO header VALUES (?, ?)", [*rows, ("checksum", _digest(rows))])
        database.execute("COMMIT")

    def records(self) -> list[Record]:
        """Finished points, by number.

        Raises:
            InputError: a record is damaged.
        """
        with _explained(self.path):
            return read_records(self._open, self.path)

    def add(self, records: Iterable[Record]) -> None:
        """Write finished points, all or none; one that is there already is replaced.

        Raises:
            OSError: the disk is full, or the like.
        """
        database = self._open
        rows = [_row(record) for record in records]
        try:
            database.execute("BEGIN IMMEDIATE")
            database.executemany(f"INSERT OR REPLACE INTO record ({_COLUMNS}) VALUES ({','.join('?' * 11)})", rows)
            database.execute("COMMIT")
        except BaseException as error:
            if database.in_transaction:
                database.execute("ROLLBACK")
            if isinstance(error, sqlite3.Error):
                raise OSError(f"store {self.path} cannot be written: {error}") from error
            raise

    def close(self) -> None:
        """Close and unlock."""
        if self._database is not None:
            self._database.close()
            self._database = None
        if self._lock is not None:
            Path(f"{self.path}.lock").unlink(missing_ok=True)
            os.close(self._lock)
            self._lock = None

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def read_store(path: str | Path) -> tuple[dict[str, Any], list[Record]]:
    """Header and finished points of a store, which may be in use.

    Raises:
        FileNotFoundError: nothing at ``path``.
        InputError: a folder, a foreign or corrupt file.
    """
    place = _place(path)
    if not place.exists():
        raise FileNotFoundError(f"no file at {place}")
    database = _connected(place, create=False)
    try:
        with _explained(place):
            _check_format(database, place)
            return read_header(database, place), read_records(database, place)
    finally:
        database.close()


# The file


def _place(path: Any) -> Path:
    try:
        place = Path(path)
        if place.is_dir():
            raise InputError(f"store {place} is a folder; name a file")
    except (TypeError, OSError) as error:  # no path at all, or none that can be
        raise InputError(f"store {path!r} cannot be opened: {error}") from None
    return place


def _locked(path: Path) -> int | None:
    """Descriptor of the lock file, held by this process until it ends."""
    name = f"{path}.lock"
    while True:
        try:
            lock = os.open(name, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o644)
        except (OSError, ValueError) as error:  # a null byte is a ValueError
            raise InputError(f"store {path} cannot be written: {error}") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            raise InputError(
                f"store {path} is being written by another process; wait for it, or use another file"
            ) from None
        try:
            if os.stat(name).st_ino == os.fstat(lock).st_ino:  # noqa: PTH116 - beside fstat
                return lock
        except FileNotFoundError:
            pass
        os.close(lock)  # whoever had it before has removed the file meanwhile


def _connected(path: Path, *, create: bool) -> sqlite3.Connection:
    """A connection without implicit transactions. A reader may have to roll back what a killed writer left."""
    writable = create or os.access(path, os.W_OK)
    mode = "rwc" if create else "rw" if writable else "ro"
    try:
        return sqlite3.connect(f"{path.absolute().as_uri()}?mode={mode}", uri=True, isolation_level=None, timeout=_WAIT)
    except sqlite3.Error as error:
        raise InputError(f"store {path} cannot be opened: {error}") from None


class _explained:  # noqa: N801 - a context manager
    """Faults of the file as InputError."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, sqlite3.DatabaseError | UnicodeDecodeError):  # of a name in a damaged schema
            raise InputError(f"{self.path} is no store of a study, or damaged ({error}); nothing was changed") from None


def _is_empty(database: sqlite3.Connection) -> bool:
    """A database without any table, as of a new file."""
    return bool(
        database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0
        and database.execute("PRAGMA application_id").fetchone()[0] == 0
    )


def _check_format(database: sqlite3.Connection, path: Path) -> None:
    if database.execute("PRAGMA application_id").fetchone()[0] != APPLICATION:
        raise InputError(f"{path} is no store of a study; nothing was changed")
    version = database.execute("PRAGMA user_version").fetchone()[0]
    if version != FORMAT:
        raise InputError(f"store {path} has format {version}, and this version of glossa knows {FORMAT}")
    fault = database.execute("PRAGMA quick_check(1)").fetchone()[0]
    if fault != "ok":
        raise InputError(f"store {path} is damaged ({fault}); nothing was changed")


# Header


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _digest(rows: Iterable[tuple[str, str]]) -> str:
    return hashlib.sha256(_text(sorted(rows)).encode()).hexdigest()


def read_header(database: sqlite3.Connection, path: Path) -> dict[str, Any]:
    """Values by name.

    Raises:
        InputError: incomplete or damaged.
    """
    texts: dict[str, str] = dict(database.execute("SELECT name, value FROM header"))
    if not all(isinstance(text, str) for pair in texts.items() for text in pair):
        raise InputError(f"store {path} is damaged (its header); nothing was changed")
    checksum = texts.pop("checksum", "")
    if checksum != _digest(texts.items()) or not set(COMPARED) <= set(texts):
        raise InputError(f"store {path} is damaged (its header); nothing was changed")
    return {name: json.loads(text) for name, text in texts.items()}


def _check_same(found: Mapping[str, Any], wanted: Mapping[str, Any], path: Path) -> None:
    for name, meaning in COMPARED.items():
        old, new = found[name], wanted[name]
        same = _release(old) == _release(new) if name == "glossa_version" else _text(old) == _text(new)
        if not same:
            raise InputError(
                f"store {path} {meaning}{_difference(name, old, new)}; nothing was changed. Use another file, or the "
                "study it was made for"
            )


def _release(version: str) -> list[str]:
    """Major and minor version: patches leave numbers as they are."""
    return version.split(".")[:2]


def _difference(name: str, old: Any, new: Any) -> str:
    """A few words on what differs."""
    if name == "points":
        if len(old) != len(new):
            return f" ({len(old)}, and this study has {len(new)})"
        first = next(k for k, pair in enumerate(zip(old, new, strict=True)) if _text(pair[0]) != _text(pair[1]))
        return f" (number {first} is the first that differs)"
    if name == "scene":
        keys = [key for key in new if _text(old.get(key)) != _text(new[key])]
        words = ", ".join(f"{key} {_text(old.get(key))} instead of {_text(new[key])}" for key in keys)
        return f" ({words[:_MOST]})"
    if name == "glossa_version":
        return f" ({old}, this is {new})"
    return ""


# Records


def _row(record: Record) -> tuple[Any, ...]:
    row = (
        record.number,
        record.status,
        record.reason,
        record.acoustic_reason,
        record.started,
        record.iterations,
        record.seconds,
        record.worker,
        record.finished,
        record.values.astype(_DOUBLES).tobytes(),
    )
    return (*row, _checksum(row))


def _checksum(row: tuple[Any, ...]) -> int:
    """Of a row without it; of NaN, which SQLite does not keep, nothing: seconds are left out."""
    return zlib.crc32(row[9], zlib.crc32(repr((*row[:6], *row[7:9])).encode()))


def read_records(database: sqlite3.Connection, path: Path) -> list[Record]:
    """Finished points, by number.

    Raises:
        InputError: a record is damaged.
    """
    records = []
    for *row, checksum in database.execute(f"SELECT {_COLUMNS} FROM record ORDER BY number"):
        if _checksum(tuple(row)) != checksum:
            raise InputError(f"store {path} is damaged (point {row[0]}); nothing was changed")
        number, status, reason, acoustic_reason, started, iterations, seconds, worker, finished, doubles = row
        if not isinstance(seconds, float | None):  # the checksum leaves it out
            raise InputError(f"store {path} is damaged (point {number}); nothing was changed")
        records.append(
            Record(
                number=number,
                status=status,
                reason=reason,
                acoustic_reason=acoustic_reason,
                started=started,
                iterations=iterations,
                seconds=float("nan") if seconds is None else seconds,  # SQLite has no NaN
                worker=worker,
                finished=finished,
                values=np.frombuffer(doubles, dtype=_DOUBLES).astype(np.float64),
            )
        )
    return records
