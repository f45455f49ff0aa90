"""Poles of one tract by cutting its region until every piece holds one: slow, for the few tracts that need it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.constants import Complex
from glossa.acoustics.contour import Count, count_zeros
from glossa.acoustics.region import Region

if TYPE_CHECKING:
    from glossa.acoustics.poles import Tracts

SMALLEST = 1e-6
"""Hz: a piece of this size with several poles holds a multiple one."""
CUTS = (0.5, 0.47, 0.54, 0.43, 0.58)
"""Where a piece is cut, as parts of its longer side: the first cut that meets no pole."""
STEP = 20.0
MOST_PIECES = 400


def poles_by_bisection(tracts: Tracts, region: Region, row: int) -> tuple[Complex, str]:
    """All poles of one tract by rising F, and why not, empty if they are all there."""
    one = tracts.rows(np.array([row], dtype=np.intp))
    pieces = [region.corners()[row]]
    count = _count(one, pieces[0])
    if count.zeros[0] < 0:
        return _none(), f"a pole lies on the border of the region searched, up to {region.top[row]:.0f} Hz"
    pending = [(pieces[0], count)]
    found: list[complex] = []
    for _ in range(MOST_PIECES):
        if not pending:
            return np.array(sorted(found, key=lambda z: z.real), dtype=np.complex128), ""
        piece, count = pending.pop()
        inside = int(count.zeros[0])
        if inside == 0:
            continue
        if inside == 1:
            pole = _polish(one, piece, count)
            if pole is not None:
                found.append(pole)
                continue
        if _size(piece) < SMALLEST:
            found.extend([complex(piece.mean())] * inside)
            continue
        halves = _halved(one, piece, inside)
        if halves is None:
            return _none(), f"the poles near {piece.mean().real:.0f} Hz cannot be told apart"
        pending.extend(halves)
    return _none(), f"more than {MOST_PIECES} pieces of the region searched do not tell the poles apart"


def _none() -> Complex:
    return np.zeros(0, dtype=np.complex128)


def _size(piece: Complex) -> float:
    return float(max(np.ptp(piece.real), np.ptp(piece.imag)))


def _count(one: Tracts, corners: Complex) -> Count:
    """Poles inside a convex polygon."""
    edges = []
    for begin, end in zip(corners, np.roll(corners, -1), strict=True):
        steps = max(8, int(abs(end - begin) / STEP))
        edges.append(begin + (end - begin) * np.arange(steps) / steps)
    outline = np.concatenate(edges)[None, :]

    def function(points: Complex, rows: NDArray[np.intp]) -> Complex:
        return one.rows(np.zeros(len(rows), dtype=np.intp)).ratio(points)

    return count_zeros(function, outline)


def _polish(one: Tracts, piece: Complex, count: Count) -> complex | None:
    """The only pole in a piece by Newton's method from its first moment; None if that leaves the piece."""
    at = complex(count.centre[0] + count.scale[0] * count.moments[0, 0])
    for _ in range(40):
        if not np.isfinite(at) or at.real <= 0.0:
            return None
        step = complex(one.newton_step(np.array([[at]]))[0, 0])
        at -= step
        if abs(step) < 1e-10 * abs(at):
            return at if _inside(piece, at) else None
    return None


def _inside(piece: Complex, at: complex) -> bool:
    edges = np.roll(piece, -1) - piece
    return bool((np.imag(np.conj(edges) * (at - piece)) >= 0.0).all())


def _halved(one: Tracts, piece: Complex, inside: int) -> list[tuple[Complex, Count]] | None:
    """Both halves of a piece, with their counts; None if no cut gives counts that add up."""
    turn = 1.0 if np.ptp(piece.real) >= np.ptp(piece.imag) else -1.0j
    along = (piece * turn).real
    for part in CUTS:
        level = float(along.min() + part * np.ptp(along))
        halves = [_clipped(piece, turn, level, side) for side in (-1.0, 1.0)]
        counts = [_count(one, half) for half in halves]
        if all(c.zeros[0] >= 0 for c in counts) and sum(int(c.zeros[0]) for c in counts) == inside:
            return list(zip(halves, counts, strict=True))
    return None


def _clipped(piece: Complex, turn: complex, level: float, side: float) -> Complex:
    """The part of a convex polygon with side · (Re(turn z) - level) ≥ 0 (Sutherland & Hodgman)."""
    kept: list[complex] = []
    for begin, end in zip(piece, np.roll(piece, -1), strict=True):
        a, b = (side * (complex(z * turn).real - level) for z in (begin, end))
        if a >= 0.0:
            kept.append(complex(begin))
        if a * b < 0.0:
            kept.append(complex(begin + (end - begin) * a / (a - b)))
    return np.array(kept, dtype=np.complex128)
