"""How each formant moves with each section's area or length, exactly.

A pole is D(ω, x) = 0, so dω/dx = -(∂D/∂x)/(∂D/∂ω); the derivatives of D come from the chain product itself, one pass
for all sections (:func:`glossa.acoustics.transmission_line.flow_ratio_gradient`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.area_function import AreaFunction
from glossa.acoustics.constants import TubeConstants, tube_constants
from glossa.acoustics.transmission_line import flow_ratio_gradient
from glossa.checks import flag, one_of


def sensitivity(
    area: AreaFunction,
    n: int = 4,
    *,
    constants: str | TubeConstants = "badin",
    by: str = "area",
    relative: bool = False,
) -> NDArray[np.float64]:
    """Derivatives of the first n formants (poles) by every section's area or length.

    Args:
        area: the tract.
        n: how many formants.
        constants: name of a set, or the set.
        by: ``"area"``, Hz/m², or ``"length"``, Hz/m.
        relative: x/F dF/dx instead, the percentage of change of F for each percent of x (Fant & Pauli 1974).

    Returns:
        (n, k), k sections from the glottis to the lips.

    Raises:
        InputError: bad arguments.
        SolveError: fewer than n formants were found.
    """
    one_of(by, ("area", "length"), "by")
    flag(relative, "relative")
    found = area.formants(n, constants=constants)
    poles = np.asarray(found.frequencies + 0.5j * found.bandwidths, dtype=np.complex128)
    omega = 2.0 * np.pi * poles[None, :]
    by_omega, by_area, by_length = flow_ratio_gradient(
        omega, area.lengths[None, :], area.areas[None, :], tube_constants(constants)
    )
    change = (by_area if by == "area" else by_length)[0]
    result: NDArray[np.float64] = (-change / by_omega[0][:, None]).real / (2.0 * np.pi)
    if relative:
        result *= (area.areas if by == "area" else area.lengths) / found.frequencies[:, None]
    return result
