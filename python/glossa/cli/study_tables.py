"""Cells and tables that the commands of studies share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Table

from glossa.cli.output import number

MM = 1e3
"""Millimetres in a metre."""


def cell(value: float, digits: int = 2, sign: str = "") -> str:
    """A number, or a dash where it is not finite."""
    return f"{value:{sign}.{digits}f}" if math.isfinite(value) else "-"


def beside(ours: float, theirs: float, digits: int = 1) -> str:
    """Ours / the paper's, where the paper has one."""
    return f"{cell(ours, digits)} / {cell(theirs, digits)}" if math.isfinite(theirs) else cell(ours, digits)


def table_of(*headings: str) -> Table:
    """An empty table, all but the first column to the right."""
    shown = Table()
    for place, heading in enumerate(headings):
        shown.add_column(heading, justify="right" if place else "left")
    return shown


def print_title(console: Console, study: xr.Dataset, words: str) -> None:
    """Speaker and study."""
    console.print(f"{study.attrs['speaker']}: {words}", style="bold", highlight=False, soft_wrap=True)


def numbers(values: Any, digits: int = 6) -> Any:
    """Arrays as nested lists for JSON, rounded; None where not finite."""
    listed = np.asarray(values, dtype=float).tolist()

    def rounded(one: Any) -> Any:
        return [rounded(each) for each in one] if isinstance(one, list) else number(one, digits)

    return rounded(listed)
