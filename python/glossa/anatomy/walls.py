"""What surrounds a tongue: walls, hyoid bone and the springs that hold it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray, float_array, frozen, int_array
from glossa.checks import items, real_array
from glossa.errors import InputError


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Wall:
    """A rigid surface of triangles or quadrilaterals, normals towards the tongue.

    Attributes:
        vertices: (n, 3) m.
        faces: (m, 3) triangles or (m, 4) quadrilaterals, vertex indices. In (m, 4) a triangle repeats its last vertex.

    Raises:
        InputError: wrong shapes, non-finite vertices, or a face that names an unknown vertex.
    """

    vertices: FloatArray
    faces: IntArray

    def __init__(self, vertices: Any, faces: Any) -> None:
        vertices = float_array(vertices, "wall vertices", 3)
        try:
            shape = np.shape(faces)
        except ValueError:
            raise InputError("wall faces: expected shape (m, 3) or (m, 4), got rows of unequal length") from None
        columns = shape[1] if len(shape) == 2 else 0
        if columns not in (3, 4):
            raise InputError(f"wall faces: expected shape (m, 3) or (m, 4), got {shape}")
        faces = int_array(faces, "wall faces", columns)
        outside = np.flatnonzero((faces >= len(vertices)).any(axis=1))
        if len(outside):
            raise InputError(
                f"wall face {outside[0]} names vertex {faces[outside[0]].max()}; there are {len(vertices)} vertices"
            )
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    def __reduce__(self) -> tuple[Any, ...]:
        return Wall, (self.vertices, self.faces)

    def __repr__(self) -> str:
        return f"Wall({len(self.vertices)} vertices, {len(self.faces)} faces)"

    @cached_property
    def triangles(self) -> IntArray:
        """(k, 3) triangles; a quadrilateral is split along its shorter diagonal, which its mirror image is, too."""
        if self.faces.shape[1] == 3:
            return self.faces
        whole = self.faces[:, 2] != self.faces[:, 3]
        quads = self.faces[whole]
        corners = self.vertices[quads]
        first = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
        second = np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
        other = second < first * (1.0 - 1e-9)
        equal = np.abs(second - first) <= 1e-9 * first
        other[equal] = _lower_corner(corners[equal]) % 2 == 1
        turned = np.where(other[:, None], np.roll(quads, -1, axis=1), quads)
        return frozen(np.concatenate([self.faces[~whole][:, :3], turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]))


def _lower_corner(corners: FloatArray) -> IntArray:
    """(q,) which of four corners (q, 4, 3) comes first by z, x and distance from the midplane, within rounding."""
    keys = np.round(np.stack([corners[..., 2], corners[..., 0], np.abs(corners[..., 1])], axis=-1), 9)
    best = np.zeros(len(corners), dtype=np.int32)
    for k in range(1, 4):
        here = keys[np.arange(len(keys)), best]
        difference = keys[:, k] - here
        first = np.argmax(difference != 0.0, axis=1)
        best = np.where(difference[np.arange(len(keys)), first] < 0.0, k, best).astype(np.int32)
    return best


@dataclass(frozen=True, eq=False, init=False)
class Spring:
    """A linear spring between a point of the hyoid and a fixed point.

    Attributes:
        on_hyoid: (3,) m, moves with the bone.
        fixed: (3,) m.
        stiffness: N/m.
        rest_length: m; None at construction takes the distance of the two points.
        name: anatomical name, free text.
    """

    on_hyoid: FloatArray
    fixed: FloatArray
    stiffness: float
    rest_length: float
    name: str

    def __init__(
        self, on_hyoid: Any, fixed: Any, stiffness: float, rest_length: float | None = None, name: str = ""
    ) -> None:
        ends = [float_array(end, f"spring {name!r} end point") for end in (on_hyoid, fixed)]
        if ends[0].shape != (3,) or ends[1].shape != (3,):
            raise InputError(f"spring {name!r}: end points need three coordinates each")
        if rest_length is None:
            rest_length = float(np.linalg.norm(ends[1] - ends[0]))
        object.__setattr__(self, "on_hyoid", ends[0])
        object.__setattr__(self, "fixed", ends[1])
        object.__setattr__(self, "stiffness", _not_negative(stiffness, f"spring {name!r} stiffness"))
        object.__setattr__(self, "rest_length", _not_negative(rest_length, f"spring {name!r} rest length"))
        object.__setattr__(self, "name", name)

    def __reduce__(self) -> tuple[Any, ...]:
        return Spring, (self.on_hyoid, self.fixed, self.stiffness, self.rest_length, self.name)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Hyoid:
    """The hyoid bone: a rigid body held by springs; the speaker's node set "hyoid" moves with it.

    Attributes:
        surface: closed surface of the bone, or None.
        mass: kg.
        centre: (3,) centre of mass, m.
        springs: springs to fixed points.
    """

    surface: Wall | None
    mass: float
    centre: FloatArray
    springs: tuple[Spring, ...]

    def __init__(self, surface: Wall | None, mass: float, centre: Any, springs: tuple[Spring, ...] = ()) -> None:
        centre = float_array(centre, "hyoid centre")
        if centre.shape != (3,):
            raise InputError(f"hyoid centre: expected three coordinates, got shape {centre.shape}")
        object.__setattr__(self, "surface", surface)
        object.__setattr__(self, "mass", _not_negative(mass, "hyoid mass"))
        object.__setattr__(self, "centre", centre)
        object.__setattr__(self, "springs", items(springs, "hyoid springs"))

    def __reduce__(self) -> tuple[Any, ...]:
        return Hyoid, (self.surface, self.mass, self.centre, self.springs)

    def __repr__(self) -> str:
        return f"Hyoid({self.mass * 1e3:.2f} g, {len(self.springs)} springs, surface {self.surface!r})"


def _not_negative(value: Any, what: str) -> float:
    number = real_array(value, f"{what} must be a number")
    if number.shape != () or not math.isfinite(number) or number < 0.0:
        raise InputError(f"{what} must be finite and not negative, got {value!r}")
    return float(number)
