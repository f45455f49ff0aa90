"""Errors of meshes: distances from the limit of fine meshes (Richardson; see glossa.studies.resolution).

Forces and formants are extrapolated one by one. Positions of all nodes share one observed order for a vowel, that of
their root mean square change: single components often change sign between two resolutions and would have none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from glossa.anatomy.arrays import FloatArray
from glossa.studies.accuracy_runs import Distance, Outcome, distance
from glossa.studies.resolution import error_bars, observed_order


class Limit:
    """What the solves of one vowel tend to.

    Args:
        outcomes: by resolution, two or more, none failed; 1 among them. Its first nodes are those that all share.
        nodes: the six midsagittal ones at resolution 1.
    """

    def __init__(self, outcomes: Mapping[int, Outcome], nodes: list[int]) -> None:
        self._nodes = nodes
        self._shared = min(outcome.trace.shape[1] for outcome in outcomes.values() if outcome.trace is not None)
        levels = sorted(outcomes)[-3:]
        traces, forces, formants = _stacked([outcomes[r] for r in levels], self._shared)
        self.finest = levels[-1]
        self.order = math.nan
        self._trace, self._forces, self._formants = traces[-1], forces[-1], formants[-1]
        self._last: Distance | None = None
        if len(levels) == 3:
            first, second = traces[1] - traces[0], traces[2] - traces[1]
            self.order = observed_order(levels, _rms(first), _rms(second))
            if math.isfinite(self.order):
                _, b, c = ((1.0 / r) ** self.order for r in levels)
                self._trace = traces[2] + second * c / (b - c)
            bars = _bars(levels, forces, formants)
            self._forces, self._formants = bars["forces"].limit.to_numpy(), bars["formants"].limit.to_numpy()
            last = distance(
                (traces[2] - self._trace if math.isfinite(self.order) else second)[None],
                bars["forces"].error.to_numpy()[2:],
                bars["formants"].error.to_numpy()[2],
                nodes,
            )
            self._last = last

    def error(self, outcome: Outcome, resolution: int, *, of_limit: bool) -> Distance:
        """How far an outcome lies from the limit.

        Args:
            outcome: of any element.
            resolution: its own.
            of_limit: it is one of those that the limit comes from. The finest of three has its extrapolated error, or
                its last change where no order is observed; of two, none that could be known: NaN.
        """
        if of_limit and resolution == self.finest:
            return self._last if self._last is not None else _unknown(self._forces.shape[-1])
        assert outcome.trace is not None
        assert outcome.forces is not None
        return distance(
            outcome.trace[:, : self._shared] - self._trace,
            outcome.forces - self._forces,
            outcome.formants - self._formants,
            self._nodes,
        )


def _stacked(outcomes: Sequence[Outcome], shared: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(levels, n, 3) m, (levels, muscles) N, (levels, 4) Hz."""
    traces = [outcome.trace[0, :shared] for outcome in outcomes if outcome.trace is not None]
    forces = [outcome.forces[0] for outcome in outcomes if outcome.forces is not None]
    return np.stack(traces), np.stack(forces), np.stack([outcome.formants for outcome in outcomes])


def _bars(levels: Sequence[int], forces: FloatArray, formants: FloatArray) -> dict[str, xr.Dataset]:
    study = xr.Dataset(
        {"forces": (("resolution", "muscle"), forces), "formants": (("resolution", "formant"), formants)},
        coords={"resolution": list(levels)},
    )
    return {name: error_bars(study, name) for name in ("forces", "formants")}


def _rms(change: FloatArray) -> float:
    return float(np.sqrt((change**2).sum(axis=-1).mean()))


def _unknown(muscles: int) -> Distance:
    return Distance(
        nodes=np.full(6, math.nan),
        largest=math.nan,
        forces=np.full(muscles, math.nan),
        formants=np.full(4, math.nan),
    )
