"""What is measured at each point of a study, and in which order it stands in a record."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from glossa.acoustics import AreaFunction, formants
from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.results import Posture
from glossa.studies.midsagittal_nodes import midsagittal_nodes
from glossa.studies.points import tracked_nodes

FORMANTS = 4
"""How many are looked for."""

EFFORT = ("quasi_newton", "residuals", "factorisations", "indefinite", "line_search", "contact_updates")
"""Counts of :class:`glossa.SolveReport` that tell what a solve took and which of its recoveries it needed."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One measured array.

    Attributes:
        name: in the result.
        dims: its dimensions, of every point.
        shape: their sizes.
        units: SI.
    """

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    units: str

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return math.prod(self.shape)


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The quantities of a study and the names along their dimensions. A record holds them one after the other.

    Attributes:
        quantities: in the order of a record.
        coordinates: names by dimension.
    """

    quantities: tuple[Quantity, ...]
    coordinates: Mapping[str, tuple[str | int, ...]]

    @classmethod
    def of(cls, speaker: Speaker, *, positions: bool) -> Layout:
        """What is measured on a speaker; ``positions``: every node, too."""
        nodes, muscles, walls = tuple(followed_nodes(speaker)), tuple(speaker.muscles), tuple(speaker.walls)
        rows = [
            ("forces", {"muscle": len(muscles)}, "N"),
            ("displacement", {"node": len(nodes), "axis": 3}, "m"),
            ("formants", {"formant": FORMANTS}, "Hz"),
            ("bandwidths", {"formant": FORMANTS}, "Hz"),
            ("tract_length", {}, "m"),
            ("contact_area", {"wall": len(walls)}, "m2"),
            ("contact_force", {"wall": len(walls), "axis": 3}, "N"),
            ("hyoid_displacement", {"axis": 3}, "m"),
            ("residual", {}, "1"),
            ("least_jacobian", {}, "1"),
            ("penetration", {}, "m"),
            ("effort", {"count": len(EFFORT)}, "1"),
            *([("positions", {"mesh_node": len(speaker.nodes), "axis": 3}, "m")] if positions else []),
        ]
        return cls(
            quantities=tuple(
                Quantity(name=name, dims=tuple(dims), shape=tuple(dims.values()), units=units)
                for name, dims, units in rows
            ),
            coordinates={
                "muscle": muscles,
                "node": nodes,
                "axis": ("x", "y", "z"),
                "formant": tuple(range(1, FORMANTS + 1)),
                "wall": walls,
                "count": EFFORT,
            },
        )

    @property
    def size(self) -> int:
        """How many numbers a record has."""
        return sum(quantity.size for quantity in self.quantities)

    def flat(self, values: Mapping[str, FloatArray]) -> FloatArray:
        """(size,) the quantities one after the other; NaN where one is missing."""
        parts = []
        for quantity in self.quantities:
            part = np.asarray(values.get(quantity.name, np.full(quantity.shape, math.nan)), dtype=np.float64)
            assert part.shape == quantity.shape, quantity.name
            parts.append(part.ravel())
        return np.concatenate(parts)

    def split(self, rows: FloatArray) -> dict[str, FloatArray]:
        """Rows (points, size) as arrays (points, ...) by name."""
        result, first = {}, 0
        for quantity in self.quantities:
            part = rows[:, first : first + quantity.size]
            result[quantity.name] = part.reshape(len(rows), *quantity.shape)
            first += quantity.size
        return result


def followed_nodes(speaker: Speaker) -> dict[str, int]:
    """The six midsagittal nodes of fig. 11; where a speaker has none, tip and dorsum; else nothing."""
    for find in (midsagittal_nodes, tracked_nodes):
        try:
            return find(speaker)
        except InputError:
            continue
    return {}


def measured(posture: Posture, *, positions: bool) -> dict[str, FloatArray]:
    """Quantities of a posture by name, those of its sound excepted."""
    nodes = list(followed_nodes(posture.speaker).values())
    found: dict[str, FloatArray] = {
        "forces": np.asarray(posture.forces.to_numpy(), dtype=np.float64),
        "displacement": np.asarray(posture.displacements[nodes].reshape(-1, 3)),
    }
    report = posture.report
    if report is not None:
        found["residual"] = np.array(report.residual / report.force_scale if report.force_scale > 0.0 else 0.0)
        found["least_jacobian"] = np.array(report.least_jacobian)
        found["penetration"] = np.array(report.penetration)
        found["effort"] = np.array([getattr(report, name) for name in EFFORT], dtype=np.float64)
    if posture.contact is not None:
        found["contact_area"] = np.asarray(posture.contact.touched_areas.to_numpy(), dtype=np.float64)
        found["contact_force"] = np.asarray(posture.contact.forces.to_numpy().reshape(-1, 3), dtype=np.float64)
    if posture.hyoid is not None:
        found["hyoid_displacement"] = np.asarray(posture.hyoid.displacement)
    if positions:
        found["positions"] = posture.positions
    return found


def heard(tract: AreaFunction) -> tuple[dict[str, FloatArray], str]:
    """Quantities of the sound of a tract by name; and empty, or why some formants are NaN."""
    table = formants([tract], FORMANTS)
    found = {
        "formants": np.asarray(table.frequencies[0]),
        "bandwidths": np.asarray(table.bandwidths[0]),
        "tract_length": np.array(tract.length),
    }
    return found, table.reasons[0]
