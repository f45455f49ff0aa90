"""Tracts of known area function, cut back from their pieces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.tract.tubes import LENGTH, TONGUE, Array, Tube, constricted, frame, smooth_areas, tube

from glossa import AreaFunction, Speaker, Wall, area_function
from glossa.studies import rest_posture
from glossa.tract import Tract, cut_tract


def errors(built: Tube, cut: Tract) -> Array:
    """Relative errors of the areas."""
    return cut.areas / built.truth(np.array([section.origin for section in cut])) - 1.0


def cut(built: Tube, walls: dict[str, Wall] | None = None) -> Tract:
    speaker = built.speaker
    if walls is not None:
        speaker = Speaker(speaker.nodes, speaker.hexahedra, walls=walls)
    return cut_tract(rest_posture(speaker))


@pytest.mark.parametrize("areas", [smooth_areas, constricted])
def test_areas_are_found_within_two_percent(areas: Callable[[Array], Array]) -> None:
    built = tube(areas, fineness=2)
    found = cut(built)
    wrong = errors(built, found)
    assert np.abs(wrong).max() < 0.02
    assert np.abs(wrong).mean() < 0.003
    assert {section.status for section in found} == {"closed"}
    assert not any(section.floored or section.occluded or section.clamped for section in found)
    assert found.length == pytest.approx(LENGTH, rel=0.005)


def test_a_constriction_of_a_fifth_of_a_square_centimetre_is_found_within_three_percent() -> None:
    built = tube(constricted, fineness=2)
    found = cut_tract(rest_posture(built.speaker), planes=150)
    wrong = errors(built, found)
    narrow = found.areas < 0.3e-4
    assert narrow.sum() > 3
    assert found.areas.min() == pytest.approx(0.2e-4, rel=0.03)
    assert np.abs(wrong[narrow]).max() < 0.03


def test_areas_converge_as_the_meshes_are_refined() -> None:
    worst, mean = [], []
    for fineness in (1, 2, 3):
        built = tube(constricted, fineness=fineness, seam=0.1e-3)
        wrong = np.abs(errors(built, cut(built)))
        worst.append(wrong.max())
        mean.append(wrong.mean())
    assert worst[0] > 3.0 * worst[1] > 3.0 * worst[2]
    assert mean[0] > 3.0 * mean[1] > 3.0 * mean[2]
    assert mean[2] < 0.0015


@pytest.mark.parametrize("seam", [0.0, 0.4e-3, 1e-3, 2e-3])
def test_seams_between_the_pieces_do_not_matter(seam: float) -> None:
    built = tube(smooth_areas, fineness=2, seam=seam)
    found = cut(built)
    assert np.abs(errors(built, found)).max() < 0.015
    under_tongue = [section.bridged for section in found if "tongue" in section.bounds]
    assert any(under_tongue) == (seam > 0.0)


def test_bounding_structures_are_named() -> None:
    built = tube(smooth_areas, fineness=2)
    line = frame(np.array(TONGUE))[0]
    for section in cut(built):
        x, z = section.origin[[0, 2]]
        before_tongue, behind_tongue = z < line[0, 1] - 4e-3 and x > line[0, 0] - 4e-3, x < line[1, 0] - 4e-3
        lower = {name for name in section.bounds if not name.startswith("roof")}
        if before_tongue:
            assert lower == {"floor rear"}
        elif behind_tongue:
            assert lower == {"floor front"}
        elif "tongue" in lower:
            assert lower == {"tongue", "side left", "side right"}
        assert sum(section.bounds.values()) == pytest.approx(1.0, abs=0.08)
        assert section.bounds[max(section.bounds, key=lambda name: section.bounds[name])] > 0.4


@pytest.mark.parametrize("change", ["turned", "one wall", "bottom"])
def test_what_the_walls_are_called_and_which_way_they_face_does_not_matter(change: str) -> None:
    built = tube(smooth_areas, fineness=2)
    walls = dict(built.speaker.walls)
    if change == "turned":
        walls = {name: Wall(wall.vertices, wall.faces[:, ::-1]) for name, wall in walls.items()}
    elif change == "one wall":
        first = np.cumsum([0] + [len(wall.vertices) for wall in walls.values()])
        faces = [wall.faces + start for wall, start in zip(walls.values(), first[:-1], strict=True)]
        walls = {"wall": Wall(np.concatenate([wall.vertices for wall in walls.values()]), np.concatenate(faces))}
    else:
        angle = np.linspace(0.0, 2.0 * np.pi, 25)
        centre, height = np.array([120e-3, 0.0, 20e-3]), np.sqrt(smooth_areas(np.zeros(1))[0] / (np.pi * 1.6))
        rim = centre + height * np.stack([np.cos(angle), 1.6 * np.sin(angle), 0.0 * angle], axis=1)
        fan = np.array([[0, k + 1, k + 2] for k in range(24)])
        walls["bottom"] = Wall(np.concatenate([centre[None], rim]), fan)
    found = cut(built, walls)
    closed_end = 1 if change == "bottom" else 0  # the first plane touches the bottom
    assert np.abs(errors(built, found))[closed_end:].max() < 0.01
    assert found.length == pytest.approx(LENGTH, rel=0.005)


def test_the_area_function_runs_from_glottis_to_lips() -> None:
    built = tube(smooth_areas, fineness=2)
    area = area_function(rest_posture(built.speaker), (0.01, 1.5e-4), planes=60)
    assert isinstance(area, AreaFunction)
    assert area.lengths.size == 61
    assert (area.lengths[-1], area.areas[-1]) == (0.01, 1.5e-4)
    assert area.length == pytest.approx(LENGTH + 0.01, rel=0.005)
    places = area.positions[1:-2]
    assert area.areas[1:-2] == pytest.approx(built.areas(places), rel=0.02)
    assert area.sections[0].origin[2] < area.sections[-1].origin[2]
    exact = AreaFunction(
        np.append(np.full(400, LENGTH / 400), 0.01),
        np.append(built.areas((np.arange(400) + 0.5) * LENGTH / 400), 1.5e-4),
    )
    assert area.formants(4).frequencies == pytest.approx(exact.formants(4).frequencies, rel=0.006)


def test_more_planes_sample_the_same_tract() -> None:
    built = tube(smooth_areas, fineness=2)
    posture = rest_posture(built.speaker)
    volumes = [cut_tract(posture, planes=n, path="midline") for n in (30, 60, 120)]
    assert [t.areas @ t.lengths for t in volumes] == pytest.approx(
        [volumes[-1].areas @ volumes[-1].lengths] * 3, rel=0.005
    )
