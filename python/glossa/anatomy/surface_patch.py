"""Shape functions of one face of the smooth surface.

Face corners 0 1 2 3 are at (u, v) = (0, 0), (1, 0), (1, 1), (0, 1). Seen from corner c, s runs along the face's edge c
from the corner and r inwards from that edge. With the cubic Hermite functions H0 = (1 - t)^2 (1 + 2 t), H1 = 1 - H0,
G0 = t (1 - t)^2, G1 = t^2 (t - 1) the patch is

    S = sum over c of  H0(s) H0(r) p + G0(s) H0(r) a + H0(s) G0(r) b  +  rho(s, r) G0(r) D(s)

with p the corner, a and b the tangents of the two edges that leave it. The first part is the Coons patch of the four
cubic edge curves, blended with H0 and H1; its slope off an edge goes from b at one end to the other with H0 and H1,
which bends the surface a little along the edge. D corrects that. Let w be the tangent perpendicular to the edge at
rest, e(s) the edge curve and b = alpha w + beta e' at both ends (alpha, beta known from rest); then

    D(s) = alpha(s) w(s) + beta(s) e'(s) - H0 b(0) - H1 b(1),     alpha, beta, w blended between the ends by H0 and H1

so that the slope off the edge is in the plane of w(s) and e'(s), which the face on the other side shares: the two
faces have one tangent plane all along the edge, in every posture. rho = q^2 / (q^2 + r^2), q = 4 s (1 - s), keeps the
correction away from the slopes off the other edges (a device of Gregory's patches).
"""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray

#: d(s, r)/d(u, v) for each corner: rows s, r; columns u, v.
ROTATIONS = np.array([[[1, 0], [0, 1]], [[0, 1], [-1, 0]], [[-1, 0], [0, -1]], [[0, -1], [1, 0]]], dtype=float)

# A function of (s, r) at k points is an array (3, k): value, derivative by s, derivative by r.


def corner_coordinates(corner: int, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(s, r) of the points (u, v), seen from a corner."""
    return [(u, v), (v, 1.0 - u), (1.0 - u, 1.0 - v), (1.0 - v, u)][corner]


def face_coordinates(corner: int, s: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(u, v) of the points (s, r) seen from a corner."""
    return [(s, r), (1.0 - r, s), (1.0 - s, 1.0 - r), (r, 1.0 - s)][corner]


def corner_functions(s: FloatArray, r: FloatArray) -> FloatArray:
    """(3, 3, k): what multiplies the corner p, the tangent a along the edge, the tangent b along the edge before."""
    h, g = _h0(s), _g0(s)
    across_h, across_g = _by_r(_h0(r)), _by_r(_g0(r))
    return np.stack([_product(h, across_h), _product(g, across_h), _product(h, across_g)])


def joint_functions(s: FloatArray, r: FloatArray, joint: FloatArray) -> FloatArray:
    """(4, 3, k): what multiplies w(0) - w(1), e(0) - e(1), e'(0), e'(1).

    ``joint`` (4, k): alpha at the start and the end of the edge, then beta; zeros give zeros.
    """
    alpha, beta = joint[:2], joint[2:]
    start, end = _h0(s), _h1(s)
    zero = np.zeros_like(s)
    factor = _product(_rho(s, r), _by_r(_g0(r)))
    blend = beta[0] * start + beta[1] * end
    slopes = (
        np.stack([6.0 * s * (s - 1.0), 12.0 * s - 6.0, zero]),
        np.stack([(1.0 - s) * (1.0 - 3.0 * s), 6.0 * s - 4.0, zero]),
        np.stack([s * (3.0 * s - 2.0), 6.0 * s - 2.0, zero]),
    )
    parts = [
        (alpha[1] - alpha[0]) * _product(start, end),
        _product(blend, slopes[0]),
        _product(blend, slopes[1]) - beta[0] * start,
        _product(blend, slopes[2]) - beta[1] * end,
    ]
    return np.stack([_product(factor, part) for part in parts])


def _h0(t: FloatArray) -> FloatArray:
    return np.stack([(1.0 - t) ** 2 * (1.0 + 2.0 * t), 6.0 * t * (t - 1.0), np.zeros_like(t)])


def _h1(t: FloatArray) -> FloatArray:
    return np.stack([t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t), np.zeros_like(t)])


def _g0(t: FloatArray) -> FloatArray:
    return np.stack([t * (1.0 - t) ** 2, (1.0 - t) * (1.0 - 3.0 * t), np.zeros_like(t)])


def _by_r(f: FloatArray) -> FloatArray:
    """The same function, of r instead of s."""
    return f[[0, 2, 1]]


def _product(f: FloatArray, g: FloatArray) -> FloatArray:
    result: FloatArray = f[0] * g
    result[1:] += f[1:] * g[0]
    return result


def _rho(s: FloatArray, r: FloatArray) -> FloatArray:
    q = 4.0 * s * (1.0 - s)
    total = q * q + r * r
    scale = 1.0 / np.where(total > 0.0, total, 1.0)  # at a corner the factor G0(r) D(s) vanishes
    by_q = 2.0 * q * (r * scale) ** 2
    return np.stack([q * q * scale, by_q * (4.0 - 8.0 * s), -2.0 * r * (q * scale) ** 2])
