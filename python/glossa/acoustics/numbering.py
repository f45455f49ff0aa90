"""Is the first pole F1?

In a nearly closed tract friction or the wall's resistance can damp the lowest resonance so much that it is none any
more; the first pole found is then F2. The poles of the same tract without friction, its wall a mere mass, all exist: if
the first two poles found lie nearer to the second and third of those than to the first and second, F1 is missing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from glossa.acoustics.constants import Complex, ResonantWall, TubeConstants, YieldingWall
from glossa.acoustics.poles import Tracts, find_poles

SUSPICIOUS = 0.35
"""First poles below this part of c/2L are taken for F1 unchecked; that of a uniform tube is at 0.5."""
REACH = 4.2
"""The undamped poles are looked for up to this many c/2L."""
SMALL = 1e-3


def undamped(constants: TubeConstants) -> TubeConstants:
    """The same without friction, the wall a mass without spring and nearly without resistance."""
    wall = constants.wall
    if isinstance(wall, YieldingWall):
        wall = YieldingWall(mass=wall.mass, resistance=SMALL * wall.resistance)
    elif isinstance(wall, ResonantWall):
        wall = ResonantWall(tract_frequency=wall.tract_frequency, wall_frequency=0.0, drag=SMALL * wall.drag)
    return constants.with_(losses=None, wall=wall)


def first_is_missing(tracts: Tracts, poles: list[Complex]) -> NDArray[np.bool_]:
    """For each tract whether the first pole found is the second resonance."""
    missing = np.zeros(len(poles), dtype=np.bool_)
    if tracts.constants.losses is None and tracts.constants.wall is None:
        return missing
    spacing = tracts.spacing
    suspects = [i for i, found in enumerate(poles) if found.size > 1 and found[0].real > SUSPICIOUS * spacing[i]]
    if not suspects:
        return missing
    rows = np.array(suspects, dtype=np.intp)
    free = Tracts(tracts.lengths[rows], tracts.areas[rows], undamped(tracts.constants))
    search = find_poles(free, REACH * free.spacing)
    for row, expected in zip(suspects, search.poles, strict=True):
        if expected.size > 2:
            found = poles[row].real[:2]
            missing[row] = np.abs(found - expected.real[1:3]).sum() < np.abs(found - expected.real[:2]).sum()
    return missing
