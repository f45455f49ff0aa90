"""Files of postures and movements: NetCDF (HDF5), checked when they are read back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr

from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError


def write_dataset(data: xr.Dataset, path: str | Path) -> None:
    """Write a dataset to NetCDF (HDF5)."""
    data.to_netcdf(path, engine="h5netcdf")


def read_dataset(path: str | Path, kind: str, speaker: Speaker) -> xr.Dataset:
    """Read a dataset of ``kind`` that belongs to ``speaker``.

    Raises:
        FileNotFoundError: nothing at ``path``.
        InputError: unreadable, of another kind, or of another speaker.
    """
    if not Path(path).exists():
        raise FileNotFoundError(f"no file at {path}")
    try:
        with h5py.File(path, "r") as file:  # h5netcdf leaves behind half an object where either of these fails
            file.attrs.get("_nc3_strict")
        with xr.open_dataset(path, engine="h5netcdf", phony_dims="access") as opened:
            data = opened.load()
    except Exception as error:  # of four libraries, none of which says what a damaged file may raise
        raise InputError(f"{path} cannot be read as a NetCDF file: {error}") from None
    if data.attrs.get("glossa") != kind:
        raise InputError(f"{path} holds no {kind} of glossa")
    if data.attrs.get("speaker_fingerprint") != speaker.fingerprint:
        raise InputError(
            f"{path} belongs to another speaker ({data.attrs.get('speaker')!r}); load it with the speaker it was "
            "computed for"
        )
    return data


@contextmanager
def damaged_is_refused(path: str | Path) -> Iterator[None]:
    """Entries that are missing or of another kind than they should be, as InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path} is damaged: {error}") from None
    except (KeyError, TypeError, AttributeError, ValueError, IndexError, OverflowError) as error:
        raise InputError(f"{path} is damaged: missing or malformed entry ({error})") from None


def fields(data: xr.Dataset, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Any]:
    """Arrays of a dataset by name.

    Args:
        data: from :func:`read_dataset`.
        shapes: by name; -1 allows any size.

    Raises:
        InputError: one is missing, of another shape, no number or not finite.
    """
    found = {}
    for name, shape in shapes.items():
        if name not in data:
            raise InputError(f"it lacks {name}")
        values = data[name].values
        sizes = zip(values.shape, shape, strict=False)
        if values.ndim != len(shape) or any(size != wanted != -1 for size, wanted in sizes):
            raise InputError(f"{name} has shape {values.shape}, expected {shape}")
        if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
            raise InputError(f"{name} must be finite numbers")
        found[name] = values
    return found
