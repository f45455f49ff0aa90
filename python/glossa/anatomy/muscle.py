"""A muscle: its elements, its macrofibres and its force capacity."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from glossa.anatomy.arrays import IntArray, frozen, int_array
from glossa.checks import finite_number, items, real_array
from glossa.errors import InputError

PEAK_MULTIPLIER = 10.0
"""The maximal law of fig. 3 over the passive one: Buchaillard, Perrier & Payan 2009."""


@dataclass(frozen=True, eq=False, init=False)
class Muscle:
    """A muscle of a speaker; both sides of the body together.

    Attributes:
        elements: (k,) indices of the hexahedra that belong to the muscle.
        fibres: macrofibres, each a node list of at least two nodes, ordered along the fibre.
        force_capacity: rho(m) of eq. 3, N, total over left and right (Buchaillard et al. 2009, Table I).
        fibres_per_element: fibre count from which the stiffening p1 of eq. 1 is set; None takes the largest number
            of fibres found in one element.
        peak_multiplier: stiffness of an element passed by so many saturated fibres, over that of passive tissue.

    Raises:
        InputError: no element or fibre, wrong types, short fibre, or a non-positive force capacity,
            or a multiplier below 1.
    """

    elements: IntArray
    fibres: tuple[IntArray, ...]
    force_capacity: float
    fibres_per_element: int | None
    peak_multiplier: float

    def __init__(
        self,
        elements: Any,
        fibres: Iterable[Any],
        force_capacity: float,
        fibres_per_element: int | None = None,
        peak_multiplier: float = PEAK_MULTIPLIER,
    ) -> None:
        elements = int_array(elements, "muscle elements")
        if len(elements) == 0:
            raise InputError("muscle has no elements; name the hexahedra that belong to it")
        node_lists = tuple(int_array(fibre, f"fibre {i}") for i, fibre in enumerate(items(fibres, "muscle fibres")))
        if not node_lists:
            raise InputError("muscle has no fibres; give at least one node list")
        for i, fibre in enumerate(node_lists):
            if len(fibre) < 2:
                raise InputError(f"fibre {i} has {len(fibre)} node(s); a fibre needs at least two")
        object.__setattr__(self, "elements", elements)
        object.__setattr__(self, "fibres", node_lists)
        object.__setattr__(self, "force_capacity", _positive_force(force_capacity))
        object.__setattr__(self, "fibres_per_element", _positive_count(fibres_per_element))
        object.__setattr__(self, "peak_multiplier", _multiplier(peak_multiplier))

    @cached_property
    def segments(self) -> IntArray:
        """(s, 3) straight pieces of all fibres: first node, second node, fibre index; along each fibre in order."""
        flat = np.concatenate(self.fibres)
        owner = np.repeat(np.arange(len(self.fibres)), [len(fibre) for fibre in self.fibres])
        inside = owner[1:] == owner[:-1]
        pieces = np.stack([flat[:-1][inside], flat[1:][inside], owner[:-1][inside]], axis=1).astype(np.int32)
        frozen(pieces)
        return pieces

    def __reduce__(self) -> tuple[Any, ...]:
        return Muscle, (self.elements, self.fibres, self.force_capacity, self.fibres_per_element, self.peak_multiplier)

    def __repr__(self) -> str:
        return f"Muscle({len(self.elements)} elements, {len(self.fibres)} fibres, {self.force_capacity:g} N)"


def _positive_force(value: Any) -> float:
    force = real_array(value, f"force_capacity {value!r} is not a number (newtons expected)")
    if force.shape != () or not math.isfinite(force) or force <= 0.0:
        raise InputError(f"force_capacity must be a positive finite number of newtons, got {value!r}")
    return float(force)


def _multiplier(value: Any) -> float:
    multiplier = finite_number(value, "peak_multiplier")
    if multiplier < 1.0:
        raise InputError(f"peak_multiplier must be at least 1, got {multiplier!r}")
    return multiplier


def _positive_count(value: Any) -> int | None:
    if value is None:
        return None
    try:
        count = operator.index(value)
    except TypeError:
        raise InputError(f"fibres_per_element {value!r} is not a whole number or None") from None
    if count < 1:
        raise InputError(f"fibres_per_element must be at least 1, got {count}")
    return count
