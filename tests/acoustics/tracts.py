"""Tracts that several tests use."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from glossa import AreaFunction

REFERENCE = Path(__file__).resolve().parents[3] / "shared" / "reference" / "acoustics"

TWO_TUBES = {
    "a": AreaFunction([0.09, 0.08], [1e-4, 7e-4]),
    "i": AreaFunction([0.09, 0.06], [8e-4, 1e-4]),
    "u": AreaFunction([0.02, 0.06, 0.02, 0.06, 0.015], [2e-4, 6e-4, 0.4e-4, 5e-4, 0.4e-4]),
    "e": AreaFunction([0.02, 0.07, 0.06, 0.02], [2e-4, 6e-4, 2e-4, 3e-4]),
}


def rough(
    seed: int, tracts: int, sections: int = 40, step: float = 0.4, least: float = 1e-6, most: float = 2e-3
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lengths (17.5 cm in all) and areas (tracts, sections) that wander at random about 3 cm²."""
    walk = np.cumsum(np.random.default_rng(seed).normal(size=(tracts, sections)) * step, axis=1)
    areas = np.exp(walk - walk.mean(axis=1, keepdims=True)) * 3e-4
    return np.full((tracts, sections), 0.175 / sections), np.clip(areas, least, most)


def vowels() -> dict[str, AreaFunction]:
    """Two- to five-tube vowels and a rough tract."""
    lengths, areas = rough(3, 1)
    return TWO_TUBES | {"rough": AreaFunction(lengths[0], areas[0])}


def reference(name: str) -> dict[str, Any]:
    """A file of reference values; the test is skipped where they are absent."""
    path = REFERENCE / name
    if not path.is_file():
        pytest.skip(f"reference values not found at {path}")
    result: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return result
