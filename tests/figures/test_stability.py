"""The chart of a study of stability: growth in its cells, the border as a line."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh

from glossa.errors import InputError
from glossa.figures import stability
from glossa.studies.stability import committed_stability


@pytest.fixture(scope="module")
def study() -> xr.Dataset:
    return committed_stability()


def test_every_chart_shows_growth_and_border(study: xr.Dataset) -> None:
    figure = stability(study)
    rows, columns = study.sizes["posture"], study.sizes["firing_gradient"]
    panels = figure.axes[: rows * columns]
    for place, axes in enumerate(panels):
        one = study.isel(posture=place // columns, firing_gradient=place % columns)
        (mesh,) = [artist for artist in axes.collections if isinstance(artist, QuadMesh)]
        growth = one["growth"][..., 0].to_numpy()
        assert np.asarray(mesh.get_array()).ravel() == pytest.approx(growth.ravel())
        words = [text.get_text() for text in axes.texts]
        assert len(words) == np.isfinite(growth).sum()
        assert f"{growth[0, 0]:+.0f}\n{float(one['frequency'][0, 0, 0]):.0f}" in words
        (border,) = [line for line in axes.lines if line.get_gid() == "border"]
        delays = one["delay"].to_numpy()
        seen = one["border_delay"].to_numpy()
        seen = seen[np.isfinite(seen) & (seen <= delays[-1])]
        assert np.interp(np.asarray(border.get_xdata()), np.arange(len(delays)), delays) == pytest.approx(seen)
        assert f"c = {float(one['firing_gradient']):g}" in axes.get_title("left")


def test_refuses_what_is_no_chart(study: xr.Dataset) -> None:
    with pytest.raises(InputError, match=r"studies\.stability"):
        stability(study.assign_attrs(study="delay"))
    with pytest.raises(InputError, match="two or more delays"):
        stability(study.isel(delay=[0]))
