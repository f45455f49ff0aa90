"""Formants of one tract or of many.

A formant is a pole of the transfer function whose bandwidth is at most 350 Hz; wider poles, such as that of an open
front cavity, stay in the list of poles. If F1 itself is damped away, it is nan and the others keep their numbers. With
``method="peaks"`` a formant is a maximum of |H| on the real axis instead, numbered as it comes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glossa.acoustics.area_function import AreaFunction, check_tracts
from glossa.acoustics.constants import Complex, TubeConstants, tube_constants
from glossa.acoustics.numbering import first_is_missing
from glossa.acoustics.peaks import find_peaks
from glossa.acoustics.poles import PoleSearch, Tracts, find_poles
from glossa.checks import one_of, whole_number
from glossa.errors import InputError, SolveError

WIDEST = 350.0
"""Hz of bandwidth above which a pole is not counted as a formant."""
METHODS = ("poles", "peaks")
MOST = 40
OVERDAMPED = "F1 is damped so much that it is no resonance: the tract is nearly closed"
GROWTH = 1.35
ATTEMPTS = 3
"""The search ends at (n + 0.7) c/2L times GROWTH², not to call a far resonance the n-th formant."""


@dataclass(frozen=True, eq=False)
class Formants:
    """Formants of one tract.

    Attributes:
        frequencies: Hz, (n,), rising; nan where not found.
        bandwidths: Hz, (n,); of peaks, nan where the peak does not stand out by 3 dB.
        poles: F + jB/2 in Hz of all resonances found, wide ones too, by rising F; of peaks, the peaks.
        reason: empty, or why some formants are nan.
    """

    frequencies: NDArray[np.float64]
    bandwidths: NDArray[np.float64]
    poles: Complex
    reason: str = ""

    def __post_init__(self) -> None:
        for array in (self.frequencies, self.bandwidths, self.poles):
            array.flags.writeable = False

    def __len__(self) -> int:
        return len(self.frequencies)

    def __repr__(self) -> str:
        pairs = [
            f"F{i} {f:.0f} ({b:.0f})" for i, (f, b) in enumerate(zip(self.frequencies, self.bandwidths, strict=True), 1)
        ]
        return f"Formants({', '.join(pairs)} Hz{'; ' + self.reason if self.reason else ''})"


@dataclass(frozen=True, eq=False)
class FormantTable(Sequence[Formants]):
    """Formants of m tracts; a sequence of :class:`Formants`.

    Attributes:
        frequencies: Hz, (m, n); nan where not found.
        bandwidths: Hz, (m, n).
        poles: of each tract, F + jB/2 in Hz.
        reasons: of each tract, empty or why some formants are nan.
    """

    frequencies: NDArray[np.float64]
    bandwidths: NDArray[np.float64]
    poles: tuple[Complex, ...]
    reasons: tuple[str, ...]

    def __post_init__(self) -> None:
        for array in (self.frequencies, self.bandwidths):
            array.flags.writeable = False

    def __len__(self) -> int:
        return len(self.frequencies)

    @overload
    def __getitem__(self, index: int) -> Formants: ...
    @overload
    def __getitem__(self, index: slice) -> list[Formants]: ...
    def __getitem__(self, index: int | slice) -> Formants | list[Formants]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        return Formants(self.frequencies[index], self.bandwidths[index], self.poles[index], self.reasons[index])

    def __iter__(self) -> Iterator[Formants]:
        return (self[i] for i in range(len(self)))


def formants(
    tracts: Sequence[AreaFunction] | ArrayLike,
    n: int = 4,
    *,
    lengths: ArrayLike | None = None,
    constants: str | TubeConstants = "badin",
    method: str = "poles",
) -> FormantTable:
    """The first n formants of many tracts at once.

    Args:
        tracts: area functions, or areas in m², (m, k), glottis to lips.
        n: how many.
        lengths: with areas as array: section lengths in m, (m, k) or (k,) for all.
        constants: name of a set in :data:`glossa.acoustics.TUBE_CONSTANTS`, or the set.
        method: ``"poles"`` or ``"peaks"``.

    Returns:
        The table; formants that were not found are nan, and ``reasons`` tells why.

    Raises:
        InputError: bad arguments.
    """
    chosen = tube_constants(constants)
    number = whole_number(n, "n", 1, MOST)
    one_of(method, METHODS, "method")
    rows = Tracts(*_arrays(tracts, lengths), chosen)
    poles, reasons = _search(rows, number, method)
    first = np.zeros(len(poles), dtype=np.intp)
    if method == "poles":
        first[first_is_missing(rows, poles)] = 1
    frequencies = np.full((len(poles), number), np.nan)
    bandwidths = np.full((len(poles), number), np.nan)
    for row, found in enumerate(poles):
        begin = first[row]
        kept = found[_counted(found, method)][: number - begin]
        frequencies[row, begin : begin + kept.size] = kept.real
        bandwidths[row, begin : begin + kept.size] = 2.0 * kept.imag
        if begin:
            reasons[row] = OVERDAMPED + (f"; {reasons[row]}" if reasons[row] else "")
    return FormantTable(frequencies, bandwidths, tuple(poles), tuple(reasons))


def formants_of_one(area: AreaFunction, n: int, *, constants: str | TubeConstants, method: str) -> Formants:
    """The first n formants of one tract; see :meth:`AreaFunction.formants`."""
    result = formants([area], n, constants=constants, method=method)[0]
    if result.reason:
        raise SolveError(f"formants of {area!r}: {result.reason}", status=result.reason)
    return result


def _counted(found: Complex, method: str) -> NDArray[np.bool_]:
    wide = 2.0 * found.imag > WIDEST if method == "poles" else np.zeros(found.size, dtype=np.bool_)
    return ~wide


def _search(tracts: Tracts, n: int, method: str) -> tuple[list[Complex], list[str]]:
    """Poles of every tract, searched higher up until there are n formants among them."""
    find: Callable[[Tracts, NDArray[np.float64]], PoleSearch] = find_poles if method == "poles" else find_peaks
    count = len(tracts.areas)
    poles: list[Complex] = [np.zeros(0, dtype=np.complex128)] * count
    reasons = ["not searched"] * count
    top = (n + 0.7) * tracts.spacing
    open_rows = np.arange(count)
    for _ in range(ATTEMPTS):
        result = find(tracts.rows(open_rows), top[open_rows])
        still = []
        for i, row in enumerate(open_rows):
            poles[row], reasons[row] = result.poles[i], result.failures[i]
            found = int(_counted(poles[row], method).sum())
            if found < n:
                reasons[row] = reasons[row] or _shortage(poles[row], found, n, method, float(top[row]))
                still.append(row)
        open_rows = np.array(still, dtype=np.intp)
        if not open_rows.size:
            break
        top[open_rows] *= GROWTH
    return poles, reasons


def _shortage(poles: Complex, found: int, n: int, method: str, top: float) -> str:
    """Why there are fewer than n formants."""
    text = f"only {found} of {n} formants ({method}) up to {top:.0f} Hz"
    wide = poles[~_counted(poles, method)]
    if wide.size:
        listed = ", ".join(f"{pole.real:.0f} ({2.0 * pole.imag:.0f})" for pole in wide)
        text += f"; wider than {WIDEST:.0f} Hz and not counted, frequency (bandwidth) in Hz: {listed}"
    return text


def _arrays(tracts: Any, lengths: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lengths and areas (m, k)."""
    if isinstance(tracts, AreaFunction):
        raise InputError("formants() takes a sequence of area functions; one alone has the method .formants()")
    if isinstance(tracts, Sequence) and len(tracts) and all(isinstance(tract, AreaFunction) for tract in tracts):
        if lengths is not None:
            raise InputError("lengths are for areas given as array; area functions bring their own")
        return _stacked(tracts)
    areas = _table(tracts, "areas")
    if lengths is None:
        raise InputError("areas given as array need lengths (m), (k,) for all tracts or (m, k)")
    given = _table(lengths, "lengths")
    if given.shape not in {areas.shape, (1, areas.shape[1])}:
        raise InputError(f"lengths must have shape {areas.shape} or ({areas.shape[1]},), got {given.shape}")
    spread = np.ascontiguousarray(np.broadcast_to(given, areas.shape))
    check_tracts(spread, areas, [f"tract {row}" for row in range(len(areas))])
    return spread, areas


def _stacked(tracts: Sequence[AreaFunction]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Area functions side by side; shorter ones get sections of length 0 at the glottis."""
    most = max(tract.areas.size for tract in tracts)
    lengths, areas = np.zeros((len(tracts), most)), np.empty((len(tracts), most))
    for row, tract in enumerate(tracts):
        lengths[row, most - tract.areas.size :] = tract.lengths
        areas[row, : most - tract.areas.size] = tract.areas[0]
        areas[row, most - tract.areas.size :] = tract.areas
    return lengths, areas


def _table(values: Any, what: str) -> NDArray[np.float64]:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be numbers, or tracts must all be AreaFunction: {error}") from error
    if array.ndim == 1 and what == "lengths":
        array = array[None, :]
    if array.ndim != 2 or not array.size:
        raise InputError(f"{what} must be an array (tracts, sections) that is not empty, got shape {array.shape}")
    return array
