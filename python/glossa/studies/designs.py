"""Which points a sweep takes: grids, Latin hypercubes, Monte Carlo samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import norm, qmc

from glossa.anatomy.arrays import FloatArray
from glossa.checks import finite_number, positive_number, whole_number
from glossa.errors import InputError

NORMAL = "normal"
"""First word of a normal distribution: ("normal", mean, standard deviation)."""

_MOST = 10_000_000
_SEEDS = 2**63 - 1

Range = tuple[float, float] | tuple[str, float, float]
"""(low, high), uniform, or ("normal", mean, standard deviation)."""


@dataclass(frozen=True, kw_only=True)
class Design:
    """Points of a sweep.

    Attributes:
        method: "grid", "latin_hypercube" or "monte_carlo".
        axes: names, see :func:`glossa.studies.axes.known_axes`.
        rows: a value of each axis, by point.
        shape: number of values by axis of a grid, the last axis running fastest; None for samples.
        ranges: by axis, of samples.
        seed: of samples.
    """

    method: str
    axes: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]
    shape: tuple[int, ...] | None = None
    ranges: Mapping[str, Range] | None = None
    seed: int | None = None

    def __len__(self) -> int:
        return len(self.rows)

    def as_dict(self) -> dict[str, Any]:
        """What to write down beside the points: method, axes, and how they were drawn."""
        facts = {"method": self.method, "axes": self.axes, "shape": self.shape, "ranges": self.ranges}
        return {name: value for name, value in {**facts, "seed": self.seed}.items() if value is not None}


def grid(values: Mapping[str, Sequence[Any] | FloatArray]) -> Design:
    """All combinations of values, the last axis running fastest.

    Args:
        values: by axis; numbers, or names and vectors of gravity and lips.

    Raises:
        InputError: no axis, an axis without values or with the same one twice, or more than 10 million points.
    """
    listed = {axis: _values(axis, given) for axis, given in _axes(values).items()}
    shape = tuple(len(given) for given in listed.values())
    if math.prod(shape) > _MOST:
        raise InputError(f"a grid of {' x '.join(map(str, shape))} is too many points; take a sample")
    return Design(method="grid", axes=tuple(listed), rows=tuple(itertools.product(*listed.values())), shape=shape)


def latin_hypercube(ranges: Mapping[str, Range], n: int, seed: int) -> Design:
    """A Latin hypercube: of the n equally probable parts of every axis, each has one point.

    Args:
        ranges: by axis: (low, high), or ("normal", mean, standard deviation).
        n: points.
        seed: the same gives the same points.

    Raises:
        InputError: no axis, bad ranges, n or seed.
    """
    checked, count, start = _sample(ranges, n, seed)
    uniform = qmc.LatinHypercube(len(checked), **{_seed_name(): np.random.default_rng(start)}).random(count)
    return _drawn("latin_hypercube", checked, uniform, start)


def monte_carlo(ranges: Mapping[str, Range], n: int, seed: int) -> Design:
    """Independent random points.

    Args:
        ranges: by axis: (low, high), or ("normal", mean, standard deviation).
        n: points.
        seed: the same gives the same points; more of them begin with the fewer.

    Raises:
        InputError: no axis, bad ranges, n or seed.
    """
    checked, count, start = _sample(ranges, n, seed)
    uniform = np.random.default_rng(start).random((count, len(checked)))
    return _drawn("monte_carlo", checked, uniform, start)


def _seed_name() -> str:
    """What scipy calls the generator: "rng" since 1.15."""
    import inspect

    return "rng" if "rng" in inspect.signature(qmc.LatinHypercube).parameters else "seed"


def _axes(given: Any) -> Mapping[str, Any]:
    if not isinstance(given, Mapping) or not all(isinstance(axis, str) for axis in given):
        raise InputError(f"a design maps names of axes to values, got {given!r}")
    if not given:
        raise InputError("a design needs at least one axis")
    return given


def _values(axis: str, given: Any) -> list[Any]:
    listed = given.tolist() if isinstance(given, np.ndarray) else given
    if isinstance(listed, str) or not isinstance(listed, Sequence):
        raise InputError(f"axis {axis}: a grid needs a list of values, got {given!r}")
    values = list(listed)
    if not values:
        raise InputError(f"axis {axis} has no values")
    if len({repr(value) for value in values}) < len(values):
        raise InputError(f"axis {axis} has the same value twice: {values}")
    return values


def _sample(ranges: Any, n: Any, seed: Any) -> tuple[dict[str, Range], int, int]:
    checked = {axis: _range(axis, given) for axis, given in _axes(ranges).items()}
    return checked, whole_number(n, "number of points", 1, _MOST), whole_number(seed, "seed", 0, _SEEDS)


def _range(axis: str, given: Any) -> Range:
    parts = tuple(given) if isinstance(given, Sequence) and not isinstance(given, str) else ()
    if len(parts) == 3 and parts[0] == NORMAL:
        mean = finite_number(parts[1], f"axis {axis}: mean")
        return NORMAL, mean, positive_number(parts[2], f"axis {axis}: standard deviation")
    if len(parts) != 2:
        raise InputError(f"axis {axis}: a range is (low, high) or ('normal', mean, standard deviation), got {given!r}")
    low, high = (finite_number(part, f"axis {axis}: range") for part in parts)
    if not low < high:
        raise InputError(f"axis {axis}: a range must rise, got {given!r}")
    return low, high


def _drawn(method: str, ranges: Mapping[str, Range], uniform: FloatArray, seed: int) -> Design:
    """Uniform numbers (n, axes) as points."""
    columns = [_quantiles(given, uniform[:, k]).tolist() for k, given in enumerate(ranges.values())]
    rows = tuple(zip(*columns, strict=True))
    return Design(method=method, axes=tuple(ranges), rows=rows, ranges=dict(ranges), seed=seed)


def _quantiles(given: Range, uniform: FloatArray) -> FloatArray:
    if len(given) == 3:
        inner = np.clip(uniform, np.finfo(float).tiny, 1.0 - np.finfo(float).epsneg)
        return np.asarray(norm.ppf(inner, given[1], given[2]), dtype=np.float64)
    low, high = given
    return np.asarray(low + (high - low) * uniform, dtype=np.float64)
