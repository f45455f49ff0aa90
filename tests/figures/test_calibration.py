"""The calibration figure shows every deviation, before and after."""

from __future__ import annotations

import numpy as np
import xarray as xr

from glossa import figures


def table(shift: float) -> xr.Dataset:
    return xr.Dataset(
        {
            "formant_ratio": (("vowel", "formant"), np.linspace(0.9, 1.1, 8).reshape(2, 4) + shift),
            "force_ratio": (("force",), np.array([0.7, 1.2]) + shift),
        },
        coords={"vowel": ["i", "a"], "formant": [1, 2, 3, 4], "force": ["GGp of i", "HG of a"]},
    )


def test_every_deviation_is_drawn() -> None:
    sheet = figures.calibration(table(0.1), table(0.0))
    upper, lower = sheet.axes
    assert [text.get_text() for text in upper.get_xticklabels()][:2] == ["F1 /i/", "F2 /i/"]
    assert [text.get_text() for text in lower.get_xticklabels()] == ["GGp /i/", "HG /a/"]
    shown = {line.get_label(): line.get_ydata() for line in lower.lines}
    assert np.allclose(shown["after"], [-30.0, 20.0])
    assert np.allclose(shown["before"], [-20.0, 30.0])
