"""Where the data files of the package are: landmark tables and the paper's tables."""

from __future__ import annotations

import importlib.resources
from pathlib import Path

from glossa.errors import InputError


def data_path(name: str) -> Path:
    """Path of a data file.

    Looks in the folder ``glossa/data`` of the installed package, then in the folder ``data`` of a source checkout.

    Args:
        name: path relative to the data folder, for example ``"landmarks/reference_tongue.toml"``.

    Raises:
        InputError: no such data file in either place.
    """
    package = Path(str(importlib.resources.files("glossa")))
    candidates = [package / "data" / name, package.parents[1] / "data" / name]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    looked = " and ".join(str(candidate) for candidate in candidates)
    raise InputError(f"data file {name!r} not found; looked for {looked}")
