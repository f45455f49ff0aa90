"""Notebooks as tests, by nbmake: quick settings to check them, full ones to write their outputs (`make notebooks`)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import nbformat
import pytest

import glossa

SETTINGS = "GLOSSA_NOTEBOOKS"
"""Read by the first cell of notebooks whose studies take long; "coarse" or "full"."""


def pytest_configure(config: pytest.Config) -> None:
    """Kernels import the glossa of this process, wherever that is; what is written has full settings."""
    package = str(Path(glossa.__file__).parents[1])
    os.environ["PYTHONPATH"] = os.pathsep.join([package, os.environ.get("PYTHONPATH", "")])
    os.environ[SETTINGS] = "full" if config.getoption("overwrite") else "coarse"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The warnings of Jupyter are its own affair."""
    for item in items:
        if item.path.suffix == ".ipynb":
            item.add_marker(pytest.mark.filterwarnings("default"))


def pytest_runtest_teardown(item: pytest.Item) -> None:
    """Of what was written, the times of its execution go: they differ every time."""
    if item.config.getoption("overwrite") and item.path.suffix == ".ipynb":
        notebook: Any = nbformat.read(item.path, as_version=4)
        for cell in notebook.cells:
            cell.metadata.pop("execution", None)
        nbformat.write(notebook, item.path)
