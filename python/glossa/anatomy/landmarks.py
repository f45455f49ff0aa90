"""The landmark table of the built-in tongue and its closed-form map from block coordinates to space.

Block coordinates: s along the rays' numbers (0..16), layer j (0..6), column k (-4..4). Any real value may be asked for;
resolution r asks for multiples of 1/r, so that coarse nodes are reproduced bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, float_array
from glossa.errors import InputError

RAYS, LAYERS, COLUMNS = 16, 6, 4  # cells along i, along j, and along k on each side
_MILLIMETRE = 1e-3


def pchip_slopes(knots: FloatArray, values: FloatArray) -> FloatArray:
    """Slopes of the monotone cubic Hermite interpolant (Fritsch & Butland 1984) along the last axis.

    Interior: weighted harmonic mean of the secants, 0 at a local extremum. Ends: three-point formula, kept
    shape-preserving.
    """
    h = np.diff(knots)
    secants = np.diff(values, axis=-1) / h
    slopes = np.zeros_like(values)
    left, right = secants[..., :-1], secants[..., 1:]
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    monotone = left * right > 0.0
    safe_left, safe_right = np.where(monotone, left, 1.0), np.where(monotone, right, 1.0)
    slopes[..., 1:-1] = np.where(monotone, (w1 + w2) / (w1 / safe_left + w2 / safe_right), 0.0)
    slopes[..., 0] = _end_slope(h[0], h[1], secants[..., 0], secants[..., 1])
    slopes[..., -1] = _end_slope(h[-1], h[-2], secants[..., -1], secants[..., -2])
    return slopes


def _end_slope(h1: float, h2: float, d1: FloatArray, d2: FloatArray) -> FloatArray:
    slope = ((2.0 * h1 + h2) * d1 - h1 * d2) / (h1 + h2)
    slope = np.where(np.sign(slope) != np.sign(d1), 0.0, slope)
    limited = (np.sign(d1) != np.sign(d2)) & (np.abs(slope) > 3.0 * np.abs(d1))
    return np.where(limited, 3.0 * d1, slope)


def pchip(knots: Any, values: Any, at: FloatArray) -> FloatArray:
    """Monotone cubic interpolation of ``values`` (..., n) at ``at`` (m,) -> (..., m). Exact at the knots."""
    x, y = np.asarray(knots, dtype=float), np.asarray(values, dtype=float)
    slopes = pchip_slopes(x, y)
    left = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h = x[left + 1] - x[left]
    u = (at - x[left]) / h
    h00, h10, h01, h11 = _hermite(u)
    result: FloatArray = (
        h00 * y[..., left] + h10 * h * slopes[..., left] + h01 * y[..., left + 1] + h11 * h * slopes[..., left + 1]
    )
    return result


def _hermite(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Cubic Hermite basis: value and slope at 0, value and slope at 1."""
    rest = 1.0 - u
    return (1.0 + 2.0 * u) * rest * rest, u * rest * rest, u * u * (3.0 - 2.0 * u), u * u * (u - 1.0)


def _lagrange(rows: FloatArray, t: FloatArray) -> FloatArray:
    """Cubic polynomial in t through four rows (4, n, 1) at t = 0, 1/3, 2/3, 1; ``t`` (n, m) -> (n, m)."""
    a, b, c, d = 3.0 * t, 3.0 * t - 1.0, 3.0 * t - 2.0, 3.0 * t - 3.0
    result: FloatArray = (
        rows[0] * (b * c * d) / -6.0
        + rows[1] * (a * c * d) / 2.0
        + rows[2] * (a * b * d) / -2.0
        + rows[3] * (a * b * c) / 6.0
    )
    return result


@dataclass(frozen=True, eq=False, kw_only=True)
class Landmarks:
    """The table, lengths in mm and angles in degrees as in the file; columns run over the rays 0..16.

    Attributes:
        inner, outer: (2, 17) x and z of the ray ends P and Q.
        inner_angle, outer_angle: (17,) directions there, above +x.
        half_width, shift_x, shift_z: (4, 17) at t = 0, 1/3, 2/3, 1.
        linear_mix: start (ray), length (rays) and amount of the linear part of the lateral profile.
        columns: (5,) lateral fraction v of the columns 0..4.
        layer_stations, layers: (p,) ray numbers and (p, 7) fractions t of the layers 0..6 there.
        tangent_length: length of the end tangents over |Q - P|.
        styloid: (3,) tip of the styloid process on the side y > 0.
        peak_multiplier: of all muscles, see :class:`glossa.Muscle`.
    """

    inner: FloatArray
    outer: FloatArray
    inner_angle: FloatArray
    outer_angle: FloatArray
    half_width: FloatArray
    shift_x: FloatArray
    shift_z: FloatArray
    linear_mix: tuple[float, float, float]
    columns: FloatArray
    layer_stations: FloatArray
    layers: FloatArray
    tangent_length: float
    styloid: FloatArray
    peak_multiplier: float

    def __post_init__(self) -> None:
        rays = RAYS + 1
        expected = {
            "inner": (2, rays), "outer": (2, rays), "inner_angle": (rays,), "outer_angle": (rays,),
            "half_width": (4, rays), "shift_x": (4, rays), "shift_z": (4, rays), "columns": (COLUMNS + 1,),
            "layers": (len(self.layer_stations), LAYERS + 1), "styloid": (3,),
        }  # fmt: skip
        for name, shape in expected.items():
            if np.shape(getattr(self, name)) != shape:
                raise InputError(f"landmarks: {name} has shape {np.shape(getattr(self, name))}, expected {shape}")

    def positions(self, s: FloatArray, j: FloatArray, k: FloatArray) -> FloatArray:
        """(a, b, c, 3) m: the map at all combinations of ``s`` (a,), ``j`` (b,) and ``k`` (c,) with k >= 0."""
        t = self._layer_fractions(s, j)
        x_mid, z_mid = self._midsagittal(s, t)
        knots = np.arange(RAYS + 1)
        half_width, shift_x, shift_z = (
            _lagrange(pchip(knots, rows, s)[:, :, None], t) for rows in (self.half_width, self.shift_x, self.shift_z)
        )
        v = pchip(np.arange(COLUMNS + 1), self.columns, k)
        start, length, amount = self.linear_mix
        c = (amount * np.clip((s - start) / length, 0.0, 1.0))[:, None]
        f = c * v + (1.0 - c) * (v * v)
        points = np.empty((len(s), len(j), len(k), 3))
        points[..., 0] = x_mid[:, :, None] + f[:, None, :] * shift_x[:, :, None]
        points[..., 1] = v * half_width[:, :, None]
        points[..., 2] = z_mid[:, :, None] + f[:, None, :] * shift_z[:, :, None]
        points *= _MILLIMETRE
        return points

    def _layer_fractions(self, s: FloatArray, j: FloatArray) -> FloatArray:
        """(a, b) fraction t of layer ``j`` on ray ``s``."""
        at_stations = pchip(np.arange(LAYERS + 1), self.layers, j)
        return np.ascontiguousarray(pchip(self.layer_stations, at_stations.T, s).T)

    def _midsagittal(self, s: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(a, b) x and z, mm, of the midsagittal rays at ``t`` (a, b)."""
        knots = np.arange(RAYS + 1)
        p, q = pchip(knots, self.inner, s), pchip(knots, self.outer, s)
        length = self.tangent_length * np.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2)
        h00, h10, h01, h11 = _hermite(t)
        angles = [pchip(knots, angle, s) for angle in (self.inner_angle, self.outer_angle)]
        result = []
        for axis, function in ((0, math.cos), (1, math.sin)):
            start, end = (
                length * np.array([function(math.radians(value)) for value in angle.tolist()]) for angle in angles
            )
            result.append(h00 * p[axis][:, None] + h10 * start[:, None] + h01 * q[axis][:, None] + h11 * end[:, None])
        return result[0], result[1]

    @property
    def styloid_points(self) -> FloatArray:
        """(2, 3) m: the side y < 0, then the side y > 0."""
        sides: FloatArray = self.styloid * np.array([[1.0, -1.0, 1.0], [1.0, 1.0, 1.0]])
        return sides * _MILLIMETRE


def tongue_landmarks(table: Mapping[str, Any]) -> Landmarks:
    """The landmarks in a table laid out as data/landmarks/reference_tongue.toml.

    Raises:
        InputError: wrong lengths, or values that are no finite numbers.
        KeyError, TypeError: missing or malformed entries.
    """
    rays, lateral, spacing = table["rays"], table["lateral"], table["spacing"]
    columns = RAYS + 1
    mix = lateral["linear_mix"]
    return Landmarks(
        inner=float_array([rays["inner_x"], rays["inner_z"]], "inner_x, inner_z", columns),
        outer=float_array([rays["outer_x"], rays["outer_z"]], "outer_x, outer_z", columns),
        inner_angle=float_array(rays["inner_angle"], "inner_angle"),
        outer_angle=float_array(rays["outer_angle"], "outer_angle"),
        half_width=float_array(lateral["half_width"], "half_width", columns),
        shift_x=float_array(lateral["shift_x"], "shift_x", columns),
        shift_z=float_array(lateral["shift_z"], "shift_z", columns),
        linear_mix=(float(mix["start"]), float(mix["length"]), float(mix["amount"])),
        columns=float_array(spacing["columns"], "columns"),
        layer_stations=float_array(spacing["layer_stations"], "layer_stations"),
        layers=float_array(spacing["layers"], "layers", LAYERS + 1),
        tangent_length=float(spacing["tangent_length"]),
        styloid=float_array(table["styloid"]["point"], "styloid point"),
        peak_multiplier=float(table["muscles"]["peak_multiplier"]),
    )
