"""What happens to the sections when the tongue moves in a tube."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tract.postures import placed
from tests.tract.tubes import FLATNESS, LENGTH, TONGUE, Tube, constricted, frame, smooth_areas, tube

from glossa import AreaFunction, InputError, Posture, Speaker, Wall, area_function
from glossa.studies import rest_posture
from glossa.tract import cut_tract


@pytest.fixture(scope="module")
def built() -> Tube:
    return tube(smooth_areas, fineness=2)


def raised(built: Tube, height: float, *, groove: float = 0.0, spread: float = 0.0) -> Posture:
    """The tongue raised by ``height`` m towards the roof in its middle third.

    A midline groove 4 mm wide is raised ``groove`` m less; the tongue is ``spread`` wider there, as a fraction.
    """
    nodes = built.speaker.nodes
    s = np.linspace(*TONGUE, 400)
    line, out = frame(s)
    nearest = ((nodes[:, None, [0, 2]] - line) ** 2).sum(axis=2).argmin(axis=1)
    middle = np.clip(1.5 - np.abs(s[nearest] - np.mean(TONGUE)) / (0.12 * LENGTH), 0.0, 1.0)
    lift = middle * (height - groove * np.exp(-((nodes[:, 1] / 2e-3) ** 2)))
    return placed(
        built.speaker, np.stack([lift * out[nearest, 0], spread * middle * nodes[:, 1], lift * out[nearest, 1]], axis=1)
    )


@pytest.fixture(scope="module")
def uniform() -> Tube:
    return tube(lambda s: 3e-4 + 0.0 * s, fineness=2)


def largest_height(built: Tube) -> float:
    return max(s.sagittal_distance for s in cut_tract(rest_posture(built.speaker)) if s.bounds.get("tongue", 0.0) > 0.2)


def test_raising_the_tongue_narrows_the_sections_above_it_and_no_others() -> None:
    built = tube(smooth_areas, fineness=2, seam=0.0)
    rest, high = (cut_tract(posture) for posture in (rest_posture(built.speaker), raised(built, 2e-3)))
    bounded = np.array([s.bounds.get("tongue", 0.0) > 0.2 for s in rest])
    assert high.areas[~bounded] == pytest.approx(rest.areas[~bounded], rel=1e-9)
    assert (high.areas[bounded] <= rest.areas[bounded] * 1.001).all()
    middle = int(np.argmax(rest.areas / high.areas))
    width = 2.0 * np.sin(1.0) * FLATNESS * np.sqrt(rest.areas[middle] / (np.pi * FLATNESS))
    assert rest.areas[middle] - high.areas[middle] == pytest.approx(2e-3 * width, rel=0.03)
    assert rest[middle].sagittal_distance - high[middle].sagittal_distance == pytest.approx(2e-3, rel=0.04)


def test_a_closure_is_floored_and_flagged(built: Tube) -> None:
    posture = raised(built, largest_height(built) + 1e-3, spread=0.3)
    tract = cut_tract(posture, floor=3e-6)
    closed = [section for section in tract if section.occluded]
    assert closed
    assert all(section.area == 3e-6 and section.floored for section in closed)
    assert all(section.measured_area < 3e-6 for section in closed)
    assert area_function(posture, "a").areas.min() == 2e-6
    assert not tract[0].occluded
    assert not tract[-1].occluded
    assert tract[-1].area == pytest.approx(cut_tract(rest_posture(built.speaker))[-1].area)


def test_side_channels_along_a_midline_channel_are_told_of_but_left_out(uniform: Tube) -> None:
    """The tongue touches on two ridges: a groove between them, and air beside them along the teeth."""
    tract = cut_tract(raised(uniform, largest_height(uniform) + 0.5e-3, groove=5e-3))
    grooved = [s for s in tract if s.area_beside > 0.0]
    assert len(grooved) > 2
    for section in grooved:
        assert section.status == "ambiguous"
        assert section.contour.geom_type == "Polygon"
        assert section.area == pytest.approx(section.contour.area)
    bounds = np.array([section.contour.bounds for section in grooved])
    assert (bounds[:, 0] < 0.0).all()
    assert (bounds[:, 2] > 0.0).all()
    assert ((bounds[:, 0] > -6e-3) & (bounds[:, 2] < 6e-3)).sum() > 2


def test_with_the_midline_closed_both_sides_count(uniform: Tube) -> None:
    """As in a lateral: contact in the midline, air on both sides."""
    tract = cut_tract(raised(uniform, largest_height(uniform) + 0.5e-3))
    double = [section for section in tract if section.contour.geom_type == "MultiPolygon"]
    assert len(double) > 2
    for section in double:
        assert section.status == "ambiguous"
        assert not section.occluded
        assert section.area_beside == 0.0
        left, right = section.contour.geoms
        assert left.area == pytest.approx(right.area, rel=0.02)
        assert section.area == pytest.approx(left.area + right.area)
    assert sum(section.sagittal_distance == 0.0 for section in double) > 2


def test_a_channel_on_one_side_only_that_leads_nowhere_does_not_count(uniform: Tube) -> None:
    """A cleft beside the midline channel, open towards the larynx and closed towards the lips."""
    nodes = uniform.speaker.nodes
    tight = raised(uniform, largest_height(uniform) + 0.5e-3, groove=5e-3, spread=0.3)
    open_behind = raised(uniform, largest_height(uniform) + 0.5e-3, groove=5e-3)
    s = np.linspace(*TONGUE, 400)
    nearest = ((nodes[:, None, [0, 2]] - frame(s)[0]) ** 2).sum(axis=2).argmin(axis=1)
    behind = s[nearest] < np.mean(TONGUE)
    mixed = replace(tight, positions=np.where(behind[:, None], open_behind.positions, tight.positions))
    assert any(section.area_beside > 0.0 for section in cut_tract(open_behind))
    assert not any(section.area_beside > 0.0 for section in cut_tract(mixed))


def test_a_barrier_above_a_slit_closes_it() -> None:
    built = tube(constricted, fineness=2)
    rest = rest_posture(built.speaker)
    least = min(section.sagittal_distance for section in cut_tract(rest))
    open_, shut = (cut_tract(rest, barrier=factor * least) for factor in (0.8, 1.2))
    assert not any(section.occluded for section in open_)
    narrow = [section for section in shut if section.occluded]
    assert narrow
    assert all(section.area > 0.15e-4 for section in narrow), "what is left of a slit still has its area"


def test_the_same_posture_gives_the_same_bits(built: Tube) -> None:
    posture = raised(built, 3e-3)
    fresh = Speaker(built.speaker.nodes, built.speaker.hexahedra, walls=built.speaker.walls)
    first, again, other = (area_function(p, "i") for p in (posture, posture, replace(posture, speaker=fresh)))
    assert (first.areas == again.areas).all()
    assert (first.lengths == other.lengths).all()
    assert (first.areas == other.areas).all()


def test_a_mirror_image_has_the_same_areas(built: Tube) -> None:
    y = built.speaker.nodes[:, 1]
    sides = []
    for side in (1.0, -1.0):
        tilt = np.zeros((len(y), 3))
        tilt[:, 2] = 0.3 * np.clip(side * y, 0.0, None)
        sides.append(cut_tract(placed(built.speaker, tilt)))
    assert sides[0].areas == pytest.approx(sides[1].areas, rel=0.01)
    assert sides[0].centroids == pytest.approx(sides[1].centroids * [1.0, -1.0, 1.0], abs=0.05e-3)
    assert max(abs(section.centroid[1]) for section in sides[0]) > 0.2e-3


def test_walls_that_were_displaced_are_cut_where_they_are(built: Tube) -> None:
    rest = rest_posture(built.speaker)
    lowered = replace(rest, wall_displacements={"roof 2": np.array([0.0, 0.0, -1e-3])})
    before, after = cut_tract(rest), cut_tract(lowered)
    front = [
        k for k, s in enumerate(before) if s.bounds.get("roof 2", 0.0) > 0.4 and s.bounds.get("floor front", 0) > 0.4
    ]
    for k in front:
        assert before[k].sagittal_distance - after[k].sagittal_distance == pytest.approx(1e-3, rel=0.02)
    others = [k for k, s in enumerate(before) if "roof 2" not in s.bounds]
    assert after.areas[others] == pytest.approx(before.areas[others])


def test_lengths_follow_the_chosen_path(built: Tube) -> None:
    posture = raised(built, 4e-3)
    centroids, midline = (cut_tract(posture, path=path) for path in ("centroids", "midline"))
    assert midline.length == pytest.approx(LENGTH, rel=0.015), "smoothed: short in the bend"
    assert centroids.length == pytest.approx(
        np.linalg.norm(np.diff([s.centroid for s in centroids], axis=0), axis=1).sum()
    )
    assert centroids.length > 1.003 * midline.length


def gap_in_the_roof(built: Tube, width: float) -> Speaker:
    wall = built.speaker.walls["roof 0"]
    heights = wall.vertices[wall.triangles].mean(axis=1)[:, 2]
    kept = wall.triangles[np.abs(heights - 40e-3) > 0.5 * width]
    walls = {**built.speaker.walls, "roof 0": Wall(wall.vertices, kept)}
    return Speaker(built.speaker.nodes, built.speaker.hexahedra, walls=walls)


def test_a_gap_in_the_walls_is_reported_and_has_no_area_function(built: Tube) -> None:
    posture = rest_posture(gap_in_the_roof(built, 16e-3))
    tract = cut_tract(posture)
    missing = tract.with_status("open")
    assert missing
    for number in missing:
        assert tract[number].origin[2] == pytest.approx(40e-3, abs=9e-3)
        assert np.isnan(tract[number].sagittal_distance)
    with pytest.raises(InputError, match=rf"{len(missing)} of 45 sections are open, the first is number {missing[0]}"):
        area_function(posture, "a")


def test_a_tract_without_sections_of_its_own_is_an_area_function_all_the_same() -> None:
    assert AreaFunction.uniform(0.17, 3e-4).sections is None
