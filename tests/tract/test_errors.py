"""What the area function refuses, and how it says so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from glossa import LIPS, VOWELS, InputError, Lips, Speaker, Wall, area_function, paper
from glossa.studies import rest_posture
from glossa.tract import cut_tract


def without(speaker: Speaker, *names: str) -> Speaker:
    walls = {name: wall for name, wall in speaker.walls.items() if name not in names}
    return with_walls(speaker, walls)


def with_walls(speaker: Speaker, walls: Mapping[str, Wall]) -> Speaker:
    return Speaker(speaker.nodes, speaker.hexahedra, muscles=speaker.muscles, walls=walls)


def test_lips_of_the_paper() -> None:
    assert set(LIPS) == set(VOWELS)
    assert LIPS["u"].area == pytest.approx(0.3e-4)
    assert LIPS["u"].length == pytest.approx(1.5e-2)
    table = paper.formants_simulated()
    for vowel, lips in LIPS.items():
        assert lips.area * 1e4 == pytest.approx(float(table["lip_area_cm2"][vowel]))
        assert lips.length * 1e2 == pytest.approx(float(table["lip_protrusion_cm"][vowel]))


def test_lips_may_be_a_name_a_pair_or_lips(reference: Speaker) -> None:
    posture = rest_posture(reference)
    named, pair, given = (area_function(posture, lips) for lips in ("u", (0.015, 0.3e-4), Lips(0.015, 0.3e-4)))
    assert named.areas == pytest.approx(pair.areas)
    assert (pair.areas == given.areas).all()


@pytest.mark.parametrize(
    ("lips", "message"),
    [
        (None, "lips are missing.*name of a vowel"),
        ("y", "no lips known for 'y'; Table IV has i, ə, u, a"),
        ((0.01, -1e-4), r"lip area \(m²\) must be positive"),
        ((0.0, 1e-4), r"lip length \(m\) must be positive"),
        ((float("nan"), 1e-4), r"lip length \(m\) must be finite"),
        ((0.01, float("nan")), r"lip area \(m²\) must be finite"),
        ((0.8, 1.5e-4), "lip length must be in m"),
        ((0.008, 1.5), "lip area must be in m²"),
        ((0.01,), "lips must be the name of a vowel, a pair"),
        (3, "lips must be the name of a vowel, a pair"),
        (("a", "b"), "lip length .* must be a number"),
    ],
)
def test_bad_lips(reference: Speaker, lips: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        area_function(rest_posture(reference), lips)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"planes": 3}, "planes must be a whole number from 8"),
        ({"planes": 45.0}, "planes must be a whole number"),
        ({"lateral_end": "molar"}, "lateral_end must be one of 'outer', 'crest', 'lingual'"),
        ({"path": "straight"}, "path must be one of 'centroids', 'midline'"),
        ({"barrier": 0.0}, r"barrier \(m\) must be positive"),
        ({"floor": -1e-6}, r"floor \(m²\) must be positive"),
        ({"floor": float("nan")}, r"floor \(m²\) must be finite"),
        ({"divisions": 0}, "divisions must be a whole number from 1"),
    ],
)
def test_bad_options(reference: Speaker, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        cut_tract(rest_posture(reference), **options)


def test_what_is_no_posture(reference: Speaker) -> None:
    with pytest.raises(InputError, match="posture must be a Posture"):
        area_function(reference, "a")  # type: ignore[arg-type]


def test_a_speaker_without_walls(reference: Speaker) -> None:
    with pytest.raises(InputError, match="needs walls around the tongue, and this speaker has none"):
        cut_tract(rest_posture(without(reference, *reference.walls)))


@pytest.mark.parametrize(
    ("missing", "message"),
    [
        (("hard_palate",), "no wall stands above the middle of the tongue.*hard palate is missing"),
        (("soft_palate", "pharynx", "larynx"), "the rear wall of the pharynx is missing"),
        (("pharynx",), "sections are open"),
        (("soft_palate",), "sections are open"),
    ],
)
def test_walls_that_are_missing(reference: Speaker, missing: tuple[str, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        area_function(rest_posture(without(reference, *missing)), "a")


def test_a_rear_wall_that_ends_before_the_front_wall(reference: Speaker) -> None:
    larynx = reference.walls["larynx"]
    centres = larynx.vertices[larynx.triangles].mean(axis=1)
    rear = (larynx.vertices[larynx.triangles][..., 0].min(axis=1) > 128.5e-3) | (centres[:, 0] > 127e-3)
    walls = {**reference.walls, "larynx": Wall(larynx.vertices, larynx.triangles[~rear])}
    with pytest.raises(InputError, match="rear wall of the larynx is missing"):
        cut_tract(rest_posture(with_walls(reference, walls)))


def test_a_tongue_that_nothing_cuts(reference: Speaker) -> None:
    away = reference.nodes + np.array([0.0, 0.1, 0.0])
    aside = Speaker(away, reference.hexahedra, muscles=reference.muscles, walls=reference.walls)
    with pytest.raises(InputError, match="does not cut the tongue"):
        cut_tract(rest_posture(aside))
