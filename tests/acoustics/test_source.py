from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from glossa import InputError
from glossa.acoustics import LF, Rosenberg
from glossa.acoustics.source import Source, voice_source

PHASE = (np.arange(200_000) + 0.5) / 200_000
SOURCES = [LF(rd=rd) for rd in (0.3, 0.8, 1.4, 2.7)] + [Rosenberg(), Rosenberg(open_quotient=1.0, speed_quotient=4.0)]


@pytest.mark.parametrize("source", SOURCES, ids=repr)
@pytest.mark.parametrize("softness", [0.0, 0.6])
def test_flow_opens_and_closes(source: Source, softness: float) -> None:
    """No flow is left at the end of the period, it is never negative, and the excitation is -1."""
    pulse = source.pulse(PHASE, softness)
    flow = np.cumsum(pulse) / PHASE.size
    assert abs(flow[-1]) < 1e-4 * flow.max()
    assert flow.min() > -1e-4 * flow.max()
    assert pulse.min() == pytest.approx(-1.0, abs=5e-3)  # of a breathy LF pulse the minimum is just before t_e
    assert flow.max() > 0.03
    assert abs(pulse[0]) < 0.01
    if not (isinstance(source, Rosenberg) and source.open_quotient == 1.0):
        assert abs(pulse[-1]) < 0.01


def test_lf_return_has_its_time_constant() -> None:
    """Rd = 1: R_a = 0.038; the tangent of the return phase at the excitation reaches zero after t_a."""
    pulse = LF(rd=1.0).pulse(PHASE)
    excited = int(np.argmin(pulse))
    step = 1.0 / PHASE.size
    slope = (pulse[excited + 20] - pulse[excited + 10]) / (10 * step)
    assert -pulse[excited + 15] / slope == pytest.approx(0.038, rel=0.02)
    assert PHASE[excited] == pytest.approx(0.650, abs=0.002)


def test_soft_voice_has_less_high_frequencies() -> None:
    phase = np.arange(512) / 512
    pressed, modal, breathy = (np.abs(np.fft.rfft(LF(rd=rd).pulse(phase))) for rd in (0.4, 1.0, 2.5))
    tilt = [spectrum[20] / spectrum[1] for spectrum in (pressed, modal, breathy)]
    assert tilt[0] > 2.0 * tilt[1] > 4.0 * tilt[2]


def test_choices() -> None:
    assert voice_source("lf") == LF()
    assert voice_source("rosenberg") == Rosenberg()
    assert voice_source(LF(rd=2.0)) == LF(rd=2.0)


@pytest.mark.parametrize("choice", ["LF", "noise", None, 3])
def test_unknown_sources_are_refused(choice: Any) -> None:
    with pytest.raises(InputError, match="source must be 'lf', 'rosenberg' or an object"):
        voice_source(choice)


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (LF, {"rd": 0.1}),
        (LF, {"rd": np.nan}),
        (Rosenberg, {"open_quotient": 1.2}),
        (Rosenberg, {"speed_quotient": 0.0}),
    ],
)
def test_bad_shapes_are_refused(kind: Any, values: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        kind(**values)
