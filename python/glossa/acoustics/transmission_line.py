"""Exact chain matrices of a row of cylindrical sections, closed at the glottis.

Pressure and flow (p, U) at the two ends of a section of length l, glottis side on the left:

    (p, U)_left = [[C, z l S], [y l S, C]] (p, U)_right,   q = z y l²,  C = cosh √q,  S = sinh √q / √q

C and S are entire functions of q: no branch of the square root has to be chosen. The lumped T of the same section has
C = 1 + q/2, z l (1 + q/4) above and y l below. From the lips, (Z_rad, 1), to the glottis the product gives the flow
ratio D(ω) = U_glottis / U_lips; the transfer function is 1/D and its poles are the zeros of D.

Shapes: m tracts, f frequencies, k sections; ω (m, f) rad/s, lengths and areas (m, k), glottis to lips. A section of
length 0 changes nothing, so tracts with fewer sections are filled up with those.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.constants import Coefficients, Complex, TubeConstants

Real = NDArray[np.float64]

BLOCK = 16384
"""Tracts are taken in groups of about this many frequencies, to stay in the cache."""

SERIES_LIMIT = 4.0
"""Largest |q| for which power series of C and S are used."""


class Section(NamedTuple):
    """Factors of one section's matrix: C, S above (beside z l), S below (beside y l)."""

    across: Complex
    above: Complex
    below: Complex | float


def flow_ratio(omega: Complex, lengths: Real, areas: Real, constants: TubeConstants) -> Complex:
    """D(ω) = U_glottis/U_lips, (m, f)."""
    result = np.empty(omega.shape, dtype=np.complex128)
    for rows in _blocks(omega.shape):
        result[rows] = _ratio(omega[rows], lengths[rows], areas[rows], constants)
    return result


def flow_ratio_slope(omega: Complex, lengths: Real, areas: Real, constants: TubeConstants) -> tuple[Complex, Complex]:
    """D(ω) and dD/dω, (m, f) each."""
    value = np.empty(omega.shape, dtype=np.complex128)
    slope = np.empty(omega.shape, dtype=np.complex128)
    for rows in _blocks(omega.shape):
        value[rows], slope[rows] = _ratio_slope(omega[rows], lengths[rows], areas[rows], constants)
    return value, slope


def flow_ratio_gradient(
    omega: Complex, lengths: Real, areas: Real, constants: TubeConstants
) -> tuple[Complex, Complex, Complex]:
    """dD/dω (m, f), and the derivatives of D by each section's area and length, (m, f, k).

    D = (0, 1) M₁ … M_k (Z_rad, 1): the derivative by anything in section i is (row left of i) dMᵢ (column right of i).
    """
    coefficients, slopes = constants.line(omega)
    load, load_slope, load_area = constants.load(omega, areas[:, -1:])
    count = areas.shape[1]
    sections = [_matrix(coefficients, lengths[:, i : i + 1], areas[:, i : i + 1], constants) for i in range(count)]
    right = [(load, np.ones_like(load))]
    for i in reversed(range(count)):
        p, u = right[-1]
        a, b, c = sections[i]
        right.append((a * p + b * u, c * p + a * u))
    right.reverse()
    row_p, row_u = np.zeros_like(load), np.ones_like(load)
    by_area = np.empty((*omega.shape, count), dtype=np.complex128)
    by_length = np.empty_like(by_area)
    by_omega = np.zeros_like(load)
    for i in range(count):
        p, u = right[i + 1]
        length, area = lengths[:, i : i + 1], areas[:, i : i + 1]
        changes = _matrix_changes(coefficients, slopes, length, area, constants)
        sums = [row_p * (a * p + b * u) + row_u * (c * p + a * u) for a, b, c in changes]
        by_omega += sums[0]
        by_area[..., i], by_length[..., i] = sums[1], sums[2]
        a, b, c = sections[i]
        row_p, row_u = row_p * a + row_u * c, row_p * b + row_u * a
    by_omega += row_p * load_slope
    by_area[..., -1] += row_p * load_area
    return by_omega, by_area, by_length


def _blocks(shape: tuple[int, ...]) -> list[slice]:
    rows = max(1, BLOCK // max(shape[1], 1))
    return [slice(start, start + rows) for start in range(0, shape[0], rows)]


def _ratio(omega: Complex, lengths: Real, areas: Real, constants: TubeConstants) -> Complex:
    coefficients, _ = constants.line(omega)
    p, _, _ = constants.load(omega, areas[:, -1:])
    u = np.ones_like(p)
    for i in reversed(range(areas.shape[1])):
        a, b, c = _matrix(coefficients, lengths[:, i : i + 1], areas[:, i : i + 1], constants)
        p, u = a * p + b * u, c * p + a * u
    return u


def _ratio_slope(omega: Complex, lengths: Real, areas: Real, constants: TubeConstants) -> tuple[Complex, Complex]:
    coefficients, slopes = constants.line(omega)
    p, dp, _ = constants.load(omega, areas[:, -1:])
    u, du = np.ones_like(p), np.zeros_like(p)
    for i in reversed(range(areas.shape[1])):
        length, area = lengths[:, i : i + 1], areas[:, i : i + 1]
        (a, b, c), (da, db, dc) = _matrix_slope(coefficients, slopes, length, area, constants)
        dp, du = a * dp + b * du + da * p + db * u, c * dp + a * du + dc * p + da * u
        p, u = a * p + b * u, c * p + a * u
    return u, du


def _line(coefficients: Coefficients, area: Real) -> tuple[Complex, Complex]:
    """Elements z and y of a section; of derivatives of the coefficients, those of z and y."""
    root = np.sqrt(area)
    z1, z2, y1, y2 = coefficients
    return (z1 + z2 / root) / area, (y1 * root + y2) * root


def _matrix(
    coefficients: Coefficients, length: Real, area: Real, constants: TubeConstants
) -> tuple[Complex, Complex, Complex]:
    """Elements across (both diagonal ones), above and below of one section's matrix."""
    z, y = _line(coefficients, area)
    z *= length
    y *= length
    factors = _factors(z * y, constants.sections == "lumped")
    return factors.across, factors.above * z, factors.below * y


def _matrix_slope(
    coefficients: Coefficients, slopes: Coefficients, length: Real, area: Real, constants: TubeConstants
) -> tuple[tuple[Complex, ...], tuple[Complex, ...]]:
    """The matrix and its derivative by ω."""
    z, y = _line(coefficients, area)
    dz, dy = _line(slopes, area)
    z, y, dz, dy = z * length, y * length, dz * length, dy * length
    factors, rates = _factors_and_rates(z * y, constants.sections == "lumped")
    dq = dz * y + z * dy
    value = (factors.across, factors.above * z, factors.below * y)
    return value, _change(factors, rates, dq, (z, y), (dz, dy))


def _matrix_changes(
    coefficients: Coefficients, slopes: Coefficients, length: Real, area: Real, constants: TubeConstants
) -> list[tuple[Complex, ...]]:
    """Derivatives of the matrix by ω, area and length."""
    z, y = _line(coefficients, area)
    z1, z2, y1, y2 = coefficients
    root = np.sqrt(area)
    z_area = (-z1 - 1.5 * z2 / root) / area**2
    y_area = y1 + 0.5 * y2 / root
    z_omega, y_omega = _line(slopes, area)
    series, shunt = z * length, y * length
    factors, rates = _factors_and_rates(series * shunt, constants.sections == "lumped")
    steps = [(z_omega * length, y_omega * length), (z_area * length, y_area * length), (z, y)]
    line = (series, shunt)
    return [_change(factors, rates, dz * shunt + series * dy, line, (dz, dy)) for dz, dy in steps]


def _change(
    factors: Section, rates: Section, dq: Complex, line: tuple[Complex, Complex], change: tuple[Complex, Complex]
) -> tuple[Complex, ...]:
    (z, y), (dz, dy) = line, change
    return (
        rates.across * dq,
        factors.above * dz + rates.above * dq * z,
        factors.below * dy + rates.below * dq * y,
    )


def _factors(q: Complex, lumped: bool) -> Section:
    if lumped:
        return Section(1.0 + 0.5 * q, 1.0 + 0.25 * q, 1.0)
    largest = _largest(q)
    if largest < SERIES_LIMIT:
        even, odd, _ = _series_coefficients(largest)
        ratio = _horner(odd, q)
        return Section(_horner(even, q), ratio, ratio)
    across, ratio = _hyperbolic(q)
    return Section(across, ratio, ratio)


def _factors_and_rates(q: Complex, lumped: bool) -> tuple[Section, Section]:
    """Factors and their derivatives by q: dC/dq = S/2, dS/dq = (C - S)/(2q)."""
    if lumped:
        half = np.full_like(q, 0.5)
        return _factors(q, lumped=True), Section(half, 0.5 * half, 0.0)
    largest = _largest(q)
    if largest < SERIES_LIMIT:
        even, odd, slope = _series_coefficients(largest)
        across, ratio, rate = _horner(even, q), _horner(odd, q), _horner(slope, q)
    else:
        across, ratio = _hyperbolic(q)
        small = np.abs(q) < 1e-3
        rate = (across - ratio) / (2.0 * np.where(small, 1.0, q))
        rate[small] = (1.0 / 6.0) + q[small] / 60.0 + q[small] ** 2 / 1680.0
    return Section(across, ratio, ratio), Section(0.5 * ratio, rate, rate)


def _largest(q: Complex) -> float:
    """A bound on |q|."""
    return float(np.abs(q.real).max(initial=0.0) + np.abs(q.imag).max(initial=0.0))


def _hyperbolic(q: Complex) -> tuple[Complex, Complex]:
    """Factors C = cosh √q and S = sinh √q / √q."""
    root = np.sqrt(q)
    small = np.abs(q) < 1e-8
    root[small] = 1.0
    grown = np.exp(root)
    shrunk = 1.0 / grown
    across = np.asarray(0.5 * (grown + shrunk), dtype=np.complex128)
    ratio = np.asarray(0.5 * (grown - shrunk) / root, dtype=np.complex128)
    across[small], ratio[small] = 1.0 + q[small] / 2.0, 1.0 + q[small] / 6.0
    return across, ratio


def _series_coefficients(largest: float) -> tuple[list[float], list[float], list[float]]:
    """Power series of C, S and dS/dq, long enough for an error below 1e-17."""
    terms = 3
    while largest**terms / math.factorial(2 * terms) > 1e-18:
        terms += 1
    even = [1.0 / math.factorial(2 * i) for i in range(terms)]
    odd = [1.0 / math.factorial(2 * i + 1) for i in range(terms)]
    slope = [i / math.factorial(2 * i + 1) for i in range(1, terms + 1)]
    return even, odd, slope


def _horner(coefficients: list[float], q: Complex) -> Complex:
    result = q * coefficients[-1]
    result += coefficients[-2]
    for coefficient in coefficients[-3::-1]:
        result *= q
        result += coefficient
    return result
