"""The quality report, against what is known of simple bodies and of the built-in speaker."""

from __future__ import annotations

import numpy as np
import pytest
from tests.anatomy.wall_geometry import Front

from glossa import Speaker, Wall
from glossa.anatomy.clearance import clearances


def cube(shift: float = 0.0, lean: float = 0.0, walls: dict[str, Wall] | None = None) -> Speaker:
    """A cube of 10 mm whose top is moved along x by ``lean``, m."""
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float) * 1e-2
    corners[4:, 0] += lean
    corners[:, 2] += shift
    return Speaker(corners, [list(range(8))], walls=walls or {})


def plate(height: float) -> Wall:
    """Level, 40 mm wide, facing down."""
    return Wall([[-0.01, -0.01, height], [-0.01, 0.03, height], [0.03, 0.03, height], [0.03, -0.01, height]],
                [[0, 1, 2, 3]])  # fmt: skip


def test_a_cube() -> None:
    quality = cube().quality()
    assert quality.jacobian_min == pytest.approx(1.0)
    assert (quality.elements, quality.below_good, quality.below_poor) == (1, 0, 0)
    assert quality.element_volumes == pytest.approx((1e-6, 1e-6))
    assert quality.edge_lengths == pytest.approx((1e-2, 1e-2))
    assert quality.volume == pytest.approx(1e-6)
    assert quality.clearance == {}
    assert quality.notes == ()
    assert "distance" not in quality.text()


@pytest.mark.parametrize(("lean", "good", "poor"), [(0.02, 0, 0), (0.04, 1, 0), (0.06, 1, 1)])
def test_a_leaning_cube(lean: float, good: int, poor: int) -> None:
    """The determinant of unit edges is the cosine of the lean."""
    quality = cube(lean=lean).quality()
    assert quality.jacobian_min == pytest.approx(1.0 / np.hypot(1.0, lean / 1e-2))
    assert (quality.below_good, quality.below_poor) == (good, poor)
    assert quality.edge_lengths[1] == pytest.approx(np.hypot(1e-2, lean))
    assert len(quality.notes) == good
    if good:
        assert f"smallest scaled Jacobian {quality.jacobian_min:.3f}, 1 of 1 elements below 0.3" in quality.text()


@pytest.mark.parametrize("gap", [3e-3, -0.5e-3, -1.5e-3])
def test_distance_of_a_wall(gap: float) -> None:
    quality = cube(
        walls={"roof": plate(1e-2 + gap), "aside": Wall(plate(0.0).vertices + 1.0, [[0, 1, 2, 3]])}
    ).quality()
    assert quality.clearance == pytest.approx({"roof": gap})  # the tongue does not face the other one
    assert f"roof {gap * 1e3:.2f}" in quality.text()
    assert any("overlaps wall roof by 1.50 mm" in note for note in quality.notes) == (gap < -1e-3)


def test_the_built_in_speaker(reference: Speaker) -> None:
    quality = reference.quality()
    assert quality.notes == ()
    assert quality.below_good == 0
    assert quality.jacobian_min < quality.jacobian_low < quality.jacobian_median < 1.0
    assert quality.jacobian_low == np.quantile(reference.scaled_jacobians, 0.05)
    assert quality.element_volumes[0] < reference.volume / 768 < quality.element_volumes[1]
    assert tuple(quality.clearance) == tuple(reference.contact_faces)


def test_distances_agree_with_another_measure(reference: Speaker) -> None:
    """Tangent planes of samples of the wall instead of its triangles; they differ by less than the bend between."""
    for name, room in clearances(reference).items():
        heights = Front(reference.walls[name]).heights(room.points)
        assert np.nanmin(heights) == pytest.approx(room.least, abs=0.05e-3)
        assert room.distances[np.linalg.norm(room.points - room.place, axis=1).argmin()] == room.least


def test_any_speaker_has_a_report(pb: Speaker) -> None:
    quality = pb.quality()
    assert quality.jacobian_min == pytest.approx(0.007, abs=5e-4)
    assert quality.below_poor == 104
    assert quality.notes
    assert set(quality.clearance) <= set(pb.walls)
