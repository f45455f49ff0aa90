"""The area function of a vocal tract: a row of cylindrical sections from glottis to lips."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glossa.checks import positive_number, real_array, whole_number
from glossa.errors import InputError

if TYPE_CHECKING:
    from glossa.acoustics.constants import TubeConstants
    from glossa.acoustics.formants import Formants

LONGEST = 1.0
"""m; a longer tract was meant in other units."""
LARGEST = 0.01
"""m²; a larger section was meant in other units."""
SMALLEST = 1e-8
"""m²: a narrower section, thinner than the layer of air that sticks to its wall, is closed."""

MOST_SECTIONS = 100_000

COLUMNS = {
    ("length_m", "area_m2"): (1.0, 1.0),
    ("length_cm", "area_cm2"): (1e-2, 1e-4),
    ("length_mm", "area_mm2"): (1e-3, 1e-6),
}


@dataclass(frozen=True, eq=False, init=False, repr=False)
class AreaFunction:
    """Sections from the glottis to the lips.

    Attributes:
        lengths: m, (k,); read-only copy.
        areas: m², (k,); read-only copy.
        sections: what is known of each section besides (how it was cut, what bounds it), or None; not used here.

    Raises:
        InputError: unequal or empty arrays; lengths or areas that are not positive and finite, or that look as if
            given in other units than m and m².
    """

    lengths: NDArray[np.float64]
    areas: NDArray[np.float64]
    sections: Any

    def __init__(self, lengths: ArrayLike, areas: ArrayLike, sections: Any = None) -> None:
        object.__setattr__(self, "lengths", _row(lengths, "lengths"))
        object.__setattr__(self, "areas", _row(areas, "areas"))
        object.__setattr__(self, "sections", sections)
        if self.lengths.size != self.areas.size:
            raise InputError(
                f"lengths and areas must have one value for each section, got {self.lengths.size} and {self.areas.size}"
            )
        check_tracts(self.lengths[None, :], self.areas[None, :])

    @classmethod
    def uniform(cls, length: float, area: float, sections: int = 1) -> AreaFunction:
        """A cylinder of this length (m) and area (m²) in equal sections."""
        count = whole_number(sections, "sections", 1, MOST_SECTIONS)
        total = positive_number(length, "length (m)")
        return cls(np.full(count, total / count), np.full(count, positive_number(area, "area (m²)")))

    @classmethod
    def from_csv(cls, path: str | Path) -> AreaFunction:
        """Reads a table of one row for each section, glottis to lips; lines that begin with # are left out.

        Columns ``length_m`` and ``area_m2``, or ``length_cm`` and ``area_cm2``, or ``length_mm`` and ``area_mm2``;
        others are ignored.

        Raises:
            InputError: no such file, columns missing, a cell that is no number, or values refused by the class.
        """
        try:
            with Path(path).open(encoding="utf-8-sig", newline="") as file:
                reader = csv.DictReader(line for line in file if not line.startswith("#"))
                rows = list(reader)
                header = [name.strip() for name in reader.fieldnames or []]
                reader.fieldnames = header
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise InputError(f"area function {str(path)!r} cannot be read: {error}") from error
        names = next((names for names in COLUMNS if set(names) <= set(header)), None)
        if names is None:
            raise InputError(
                f"area function {str(path)!r} has columns {', '.join(header) or 'none'}; it needs length_m and area_m2 "
                "(or length_cm and area_cm2, or length_mm and area_mm2), one row for each section, glottis to lips"
            )
        clean = [{(key or "").strip(): cell for key, cell in row.items()} for row in rows]
        columns = [[_cell(row, name, path, i) for i, row in enumerate(clean, 1)] for name in names]
        try:
            return cls(*(np.array(column) * unit for column, unit in zip(columns, COLUMNS[names], strict=True)))
        except InputError as error:
            raise InputError(f"area function {str(path)!r}: {error}") from error

    def to_csv(self, path: str | Path) -> None:
        """Writes columns ``length_m`` and ``area_m2``, one row for each section; reading gives the same bits.

        Raises:
            InputError: the file cannot be written.
        """
        lines = [
            f"{length!r},{area!r}" for length, area in zip(self.lengths.tolist(), self.areas.tolist(), strict=True)
        ]
        try:
            Path(path).write_text("\n".join(["length_m,area_m2", *lines, ""]), encoding="utf-8")
        except OSError as error:
            raise InputError(f"area function {str(path)!r} cannot be written: {error}") from error

    @property
    def length(self) -> float:
        """Length of the tract, m."""
        return float(self.lengths.sum())

    @property
    def volume(self) -> float:
        """Volume of the tract, m³."""
        return float(self.lengths @ self.areas)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Distance of each section's middle from the glottis, m (k,)."""
        return np.cumsum(self.lengths) - 0.5 * self.lengths

    def with_lips(self, length: float, area: float) -> AreaFunction:
        """The same with one more section in front: lips of this protrusion (m) and aperture (m²).

        Section data are dropped, as the lips have none.
        """
        return AreaFunction(
            np.append(self.lengths, positive_number(length, "lip length (m)")),
            np.append(self.areas, positive_number(area, "lip area (m²)")),
        )

    def transfer_function(
        self, frequency: ArrayLike, *, constants: str | TubeConstants = "badin"
    ) -> NDArray[np.complex128]:
        """Volume flow through the lips over that at the glottis, at frequencies in Hz of any shape.

        Raises:
            InputError: a frequency that is negative or not finite.
        """
        from glossa.acoustics.spectrum import transfer_function

        return transfer_function(self, frequency, constants=constants)

    def formants(self, n: int = 4, *, constants: str | TubeConstants = "badin", method: str = "poles") -> Formants:
        """The first n formants.

        Args:
            n: how many.
            constants: name of a set in :data:`glossa.acoustics.TUBE_CONSTANTS`, or the set.
            method: ``"poles"`` of the transfer function, or ``"peaks"`` of its magnitude.

        Raises:
            InputError: bad arguments.
            SolveError: fewer formants were found; ``status`` says why.
        """
        from glossa.acoustics.formants import formants_of_one

        return formants_of_one(self, n, constants=constants, method=method)

    def sensitivity(
        self,
        n: int = 4,
        *,
        constants: str | TubeConstants = "badin",
        by: str = "area",
        relative: bool = False,
    ) -> NDArray[np.float64]:
        """Change of each formant with each section's area or length, (n, k).

        See :func:`glossa.acoustics.sensitivity`.
        """
        from glossa.acoustics.sensitivity import sensitivity

        return sensitivity(self, n, constants=constants, by=by, relative=relative)

    def __repr__(self) -> str:
        least = int(np.argmin(self.areas))
        return (
            f"AreaFunction({self.areas.size} sections, {self.length * 100:.2f} cm, least {self.areas[least] * 1e4:.3g} "
            f"cm² at {self.positions[least] * 100:.1f} cm, lips {self.areas[-1] * 1e4:.3g} cm²)"
        )


def check_tracts(lengths: NDArray[np.float64], areas: NDArray[np.float64], names: Sequence[str] = ()) -> None:
    """Refuses lengths and areas (m, k) that no tract has.

    Args:
        lengths: m.
        areas: m².
        names: what to call each row; nothing for a single one.

    Raises:
        InputError: the first bad value, where it is and what may be wrong.
    """
    prefix = [f"{name}: " for name in names] or [""] * len(areas)
    if areas.shape[1] == 0:
        raise InputError("an area function needs at least one section, got none")
    for what, values, unit in (("length", lengths, "m"), ("area", areas, "m²")):
        bad = np.argwhere(~(np.isfinite(values) & (values > 0.0)))
        if bad.size:
            row, place = bad[0]
            hint = "; a closed tract has no formants: floor its areas, for example at 1e-6 m²" if what == "area" else ""
            raise InputError(
                f"{prefix[row]}{what} of section {place} (counted from 0 at the glottis) must be a positive number of "
                f"{unit}, got {values[row, place]}{hint if values[row, place] == 0 else ''}"
            )
    if areas.min() < SMALLEST:
        row, place = np.unravel_index(int(areas.argmin()), areas.shape)
        raise InputError(
            f"{prefix[row]}area of section {place} is {areas[row, place]:g} m², below {SMALLEST:g} m² (0.01 mm²): "
            "such a section is closed; floor the areas, for example at 1e-6 m²"
        )
    totals = lengths.sum(axis=1)
    if totals.max() > LONGEST:
        row = int(totals.argmax())
        raise InputError(
            f"{prefix[row]}lengths add up to {totals[row]:g} m, over {LONGEST:g} m: they must be in m (0.175 m, not "
            "17.5 cm or 175 mm)"
        )
    if areas.max() > LARGEST:
        row, place = np.unravel_index(int(areas.argmax()), areas.shape)
        raise InputError(
            f"{prefix[row]}area of section {place} is {areas[row, place]:g} m², over {LARGEST:g} m² (100 cm²): areas "
            "must be in m² (3e-4 m², not 3 cm² or 300 mm²)"
        )


def _row(values: Any, what: str) -> NDArray[np.float64]:
    array = real_array(values, f"{what} must be numbers, one for each section")
    if array.ndim != 1:
        raise InputError(f"{what} must be one row of numbers, got an array of shape {array.shape}")
    array.flags.writeable = False
    return array


def _cell(row: dict[str, Any], name: str, path: str | Path, number: int) -> float:
    try:
        return float(row[name])
    except (TypeError, ValueError) as error:
        raise InputError(
            f"area function {str(path)!r}: row {number} has {row[name]!r} as {name}, not a number"
        ) from error
