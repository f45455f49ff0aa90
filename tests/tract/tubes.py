"""Tracts of known area function: a bent tube of elliptical sections, made of pieces with open seams between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from glossa import Speaker, Wall

Array = NDArray[np.float64]

RISE, RADIUS, FRONT = 50e-3, 35e-3, 45e-3  # m, along the midline: up, a quarter of a circle, forwards
LENGTH = RISE + RADIUS * np.pi / 2 + FRONT
FLATNESS = 1.6  # width of a section over its height
SEAM = 0.8e-3
TONGUE = (0.42 * LENGTH, 0.78 * LENGTH)
BREADTH = 1.0  # rad, of the tongue's share of a section on either side


@dataclass(frozen=True)
class Tube:
    """A speaker whose tract is the tube of these areas."""

    speaker: Speaker
    areas: Callable[[Array], Array]

    def truth(self, origins: Array) -> Array:
        """(k,) m², at points (k, 3) near the midline."""
        fine = np.linspace(0.0, LENGTH, 20001)
        line = frame(fine)[0]
        nearest = np.array([np.argmin(((line - p[[0, 2]]) ** 2).sum(axis=1)) for p in origins])
        return self.areas(fine[nearest])


def frame(s: Array) -> tuple[Array, Array]:
    """Midline (…, 2) x and z and the direction towards the outer wall, at distances s from the glottis."""
    angle = np.clip((s - RISE) / RADIUS, 0.0, np.pi / 2)
    out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    centre = np.array([85e-3, 70e-3])
    line = centre + RADIUS * out
    line = line + np.stack([-np.maximum(s - LENGTH + FRONT, 0.0), np.minimum(s - RISE, 0.0)], axis=-1)
    return line, out


def smooth_areas(s: Array) -> Array:
    """Between 1.4 and 4.2 cm²."""
    return (2.8 + 1.4 * np.sin(2.0 * np.pi * s / LENGTH - 0.7)) * 1e-4


def constricted(s: Array) -> Array:
    """4 cm² with a constriction of 0.2 cm² under the tongue."""
    depth = np.exp(-(((s - 0.6 * LENGTH) / 14e-3) ** 2))
    return (4.0 * (1.0 - depth) + 0.2 * depth) * 1e-4


def tube(areas: Callable[[Array], Array], *, fineness: int = 1, seam: float = SEAM) -> Tube:
    """A tube of 4 * fineness rows of facets per cm; the pieces are ``seam`` m apart, along the tract and sideways."""

    def surface(s: Array, theta: Array, side: float, depth: Array | float = 0.0) -> Array:
        across, along = np.meshgrid(theta, s)
        height = np.sqrt(areas(along) / (np.pi * FLATNESS))
        line, out = frame(along)
        t = side * (height * np.cos(across) + depth)
        sagittal = line + t[..., None] * out
        return np.stack([sagittal[..., 0], FLATNESS * height * np.sin(across), sagittal[..., 1]], axis=-1)

    def wall(start: float, end: float, low: float, high: float, side: float) -> Wall:
        rows = max(2, round((end - start) / 2.5e-3 * fineness))
        columns = max(2, round((high - low) / 0.2 * fineness))
        points = surface(np.linspace(start, end, rows + 1), np.linspace(low, high, columns + 1), side)
        number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
        faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
        return Wall(points.reshape(-1, 3), faces if side > 0.0 else faces[:, ::-1])

    start, end = TONGUE
    half, edge, gap = np.pi / 2, BREADTH, 0.5 * seam
    sideways = seam / 8e-3  # rad
    cuts = [0.0, 0.3 * LENGTH, 0.7 * LENGTH, LENGTH]
    walls = {
        f"roof {n}": wall(a + (gap if n else 0.0), b - (gap if n < 2 else 0.0), -half + 0.02, half - 0.02, 1.0)
        for n, (a, b) in enumerate(pairwise(cuts))
    }
    walls |= {
        "floor rear": wall(0.0, start - gap, -half, half, -1.0),
        "floor front": wall(end + gap, LENGTH, -half, half, -1.0),
        "side left": wall(start - gap, end + gap, -half, -edge - sideways, -1.0),
        "side right": wall(start - gap, end + gap, edge + sideways, half, -1.0),
    }
    return Tube(_speaker(surface, walls, fineness), areas)


def _speaker(surface: Callable[..., Array], walls: dict[str, Wall], fineness: int) -> Speaker:
    """The tongue: a block of hexahedra 6 mm deep below the airway."""
    s = np.linspace(*TONGUE, 20 * fineness + 1)
    theta = np.linspace(-BREADTH, BREADTH, 8 * fineness + 1)
    layers = [surface(s, theta, -1.0, depth) for depth in np.linspace(6e-3, 0.0, 3)]
    nodes = np.stack(layers)
    number = np.arange(nodes[..., 0].size).reshape(nodes.shape[:3])
    base = number[:-1]
    lower = [base[:, :-1, :-1], base[:, :-1, 1:], base[:, 1:, 1:], base[:, 1:, :-1]]
    top = number[1:]
    upper = [top[:, :-1, :-1], top[:, :-1, 1:], top[:, 1:, 1:], top[:, 1:, :-1]]
    hexahedra = np.stack([*lower, *upper], axis=-1).reshape(-1, 8)
    return Speaker(nodes.reshape(-1, 3), hexahedra, walls=walls, name="tube")
