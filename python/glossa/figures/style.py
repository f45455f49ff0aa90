"""Colours, fonts and sheets shared by the figures.

The colours are those of Okabe & Ito (2008), which readers with any common colour vision tell apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import matplotlib as mpl
from matplotlib.figure import Figure

BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, YELLOW, BLACK = "#E69F00", "#56B4E9", "#F0E442", "#000000"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)

VOWEL_COLOURS = {"i": BLUE, "a": VERMILION, "u": GREEN, "ə": PURPLE}

REST = "#333333"
WALL = "#4D4D4D"
BONE = "#E4E0D4"
FAINT = "#B8B8B8"
TISSUE = "#D98C8C"
FIBRE = "#B2182B"
TOUCH = "#B2182B"
JAW = "#E0B400"
HYOID = BLUE

RC: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "savefig.facecolor": "white",
    "figure.dpi": 110.0,
    "savefig.dpi": 160.0,
}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def styled(function: _Function) -> _Function:
    """Decorator: run a drawing function under the style of the package, whatever the caller's."""
    decorated: _Function = mpl.rc_context(RC)(function)
    return decorated


def new_sheet(width: float, height: float) -> Figure:
    """An empty figure, inches; no global state, nothing to close."""
    return Figure(figsize=(width, height), layout="constrained")


def colours_of(names: Iterable[str]) -> dict[str, str]:
    """A colour for each name: vowels always have their own, others take the remaining ones in turn."""
    listed = list(names)
    taken = {VOWEL_COLOURS[name] for name in listed if name in VOWEL_COLOURS}
    free = [colour for colour in CYCLE if colour not in taken] or list(CYCLE)
    others = [name for name in listed if name not in VOWEL_COLOURS]
    return {name: VOWEL_COLOURS.get(name) or free[others.index(name) % len(free)] for name in listed}


def title_of(name: str) -> str:
    """Vowels between slashes, other names as they are."""
    return f"/{name}/" if name in VOWEL_COLOURS else name
