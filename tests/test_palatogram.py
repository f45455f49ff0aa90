"""Where the electrodes lie and what switches them on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glossa import VOWELS, InputError, Posture, Scene, Speaker, Wall
from glossa.anatomy.plane_cut import plane_cut
from glossa.contact import Contact
from glossa.palatogram import REACH, ROWS, Palatogram, palate_electrodes, palatogram
from glossa.studies import rest_posture

DOWN = np.array([0.0, 0.0, -1.0])


def vault(width: float = 20e-3, height: float = 15e-3, steps: int = 40) -> Wall:
    """A parabolic vault over 50 mm of palate that rises from its front edge over 20 mm; normals downwards."""
    x, v = np.meshgrid(np.linspace(0.0, 50e-3, steps + 1), np.linspace(-1.0, 1.0, steps + 1), indexing="ij")
    rise = np.minimum(x / 20e-3, 1.0)
    vertices = np.stack([x, width * v, height * rise * (1.0 - v**2)], axis=-1).reshape(-1, 3)
    number = np.arange((steps + 1) ** 2).reshape(steps + 1, steps + 1)
    faces = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1)
    return Wall(vertices, faces.reshape(-1, 4))


def touching(electrodes: np.ndarray, gaps: np.ndarray, wall: Wall) -> Posture:
    """A posture of a cube whose contact points lie at ``electrodes``, with ``gaps``."""
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    count = len(electrodes)
    contact = Contact(
        walls=("hard_palate",),
        wall=np.zeros(count, np.int32),
        points=np.array(electrodes),
        areas=np.full(count, 1e-6),
        gaps=gaps,
        pressures=np.zeros(count),
        directions=np.tile([0.0, 0.0, -1.0], (count, 1)),
        drags=np.zeros((count, 3)),
        held=np.zeros(0, np.int32),
        spacing=2.5e-3,
    )
    speaker = Speaker(corners * 0.01 - [0.0, 0.0, 0.02], [list(range(8))], walls={"hard_palate": wall})
    return replace(rest_posture(speaker), contact=contact)


@pytest.fixture(scope="module")
def postures() -> dict[str, Posture]:
    scene = Scene(Speaker.reference(), mirror=True)
    return {name: scene.equilibrate(VOWELS[name]) for name in ("i", "u", "a")}


def test_electrodes_lie_on_the_wall_in_rows_of_six_and_eight() -> None:
    electrodes = palate_electrodes(vault())
    assert electrodes.shape == (sum(ROWS), 3) == (62, 3)
    x, y, z = electrodes.T
    rows = np.split(x, np.cumsum(ROWS)[:-1])
    assert all(np.ptp(row) == 0.0 for row in rows)
    stations = np.array([row[0] for row in rows])
    # Where the midline is level, rows are as far apart as the layout says: the rear ones twice as far as the others.
    assert np.diff(stations[-4:]) == pytest.approx(np.full(3, np.diff(stations[-4:])[0]), rel=1e-3)
    assert np.diff(stations[-2:])[0] == pytest.approx((0.050 - stations[-1]) * 2.0, rel=1e-3)
    exact = 15e-3 * np.minimum(x / 20e-3, 1.0) * (1.0 - (y / 20e-3) ** 2)
    assert z == pytest.approx(exact, abs=5e-5)  # the mesh's facets: 1 mm wide on a curvature of 75 1/m, h^2 k / 8


def test_electrodes_are_symmetric_even_and_above_the_teeth() -> None:
    electrodes = palate_electrodes(vault())
    last = electrodes[-8:]
    assert last[:, 1] == pytest.approx(-last[::-1, 1], abs=1e-12)
    # Facets are straight and electrodes evenly spaced along them; chords over a corner are a little shorter.
    gaps = np.linalg.norm(np.diff(last, axis=0), axis=1)
    assert np.ptp(gaps) < 0.01 * gaps.mean()
    assert last[0, 2] == pytest.approx(0.4 * 15e-3, abs=1e-9)
    assert electrodes[0, 0] == pytest.approx(0.4 * 20e-3, abs=2e-4)  # the first row: as high above the edge in front


@pytest.mark.parametrize("name", ["reference", "pb"])
def test_electrodes_of_speakers_lie_on_their_palates(name: str, request: pytest.FixtureRequest) -> None:
    wall = request.getfixturevalue(name).walls["hard_palate"]
    electrodes = palate_electrodes(wall)
    for row in np.split(electrodes, np.cumsum(ROWS)[:-1]):
        (line,) = plane_cut(wall, 0, float(row[0, 0]))
        start, step = line[:-1], np.diff(line, axis=0)
        share = np.einsum("ekd,kd->ek", row[:, None, 1:] - start, step) / np.sum(step**2, axis=1)
        nearest = start + np.clip(share, 0.0, 1.0)[:, :, None] * step
        assert np.linalg.norm(row[:, None, 1:] - nearest, axis=2).min(axis=1).max() < 1e-9
    assert 25e-3 < np.ptp(electrodes[:, 1]) < 45e-3
    assert 30e-3 < np.ptp(electrodes[:, 0]) < 55e-3


def test_an_electrode_is_on_where_the_nearest_point_is_within_the_film() -> None:
    wall = vault()
    electrodes = palate_electrodes(wall)
    gaps = np.where(np.arange(62) % 3 == 0, 1e-4, 2e-3)
    gram = palatogram(touching(electrodes + DOWN * 1e-4, gaps, wall))
    assert gram.on.tolist() == (np.arange(62) % 3 == 0).tolist()
    assert gram.percent == pytest.approx(100.0 * 21 / 62)
    assert palatogram(touching(electrodes, gaps, wall), film=3e-3).on.all()
    assert not palatogram(touching(electrodes + DOWN * REACH * 1.01, np.zeros(62), wall)).on.any()
    with pytest.raises(InputError, match="film must be positive"):
        palatogram(touching(electrodes, gaps, wall), film=0.0)


def test_electrodes_move_with_their_wall() -> None:
    wall, shift = vault(), np.array([0.0, 0.0, 3e-3])
    posture = touching(palate_electrodes(wall), np.zeros(62), wall)
    assert palatogram(posture).on.all()
    moved = palatogram(replace(posture, wall_displacements={"hard_palate": shift}))
    assert moved.electrodes == pytest.approx(palate_electrodes(wall) + shift)
    assert not moved.on.any()


def test_rows_and_text() -> None:
    on = np.zeros(62, dtype=bool)
    on[[0, 13]] = True  # front left, and second row right
    gram = Palatogram(electrodes=np.zeros((62, 3)), on=on)
    assert gram.rows.shape == (8, 8)
    assert np.argwhere(np.ma.getmaskarray(gram.rows)).tolist() == [[0, 0], [0, 7]]
    assert np.argwhere(gram.rows.filled(False)).tolist() == [[0, 1], [1, 7]]
    assert str(gram).splitlines()[:2] == ["  # . . . . .", ". . . . . . . #"]
    assert len(str(gram).splitlines()) == 8
    assert repr(gram) == "Palatogram(2 of 62 electrodes on)"


def test_vowels_touch_as_section_iii_says(postures: dict[str, Posture]) -> None:
    """/i/: both borders, a groove between them; /u/: the rear; /a/: nothing of the palate."""
    rows = {name: palatogram(posture).rows.filled(False) for name, posture in postures.items()}
    for row in rows["i"][3:]:
        assert row[:2].any()
        assert not row[3:5].any()
    assert all(np.array_equal(pattern, pattern[:, ::-1]) for pattern in rows.values())
    assert rows["u"][5:].any()
    assert not rows["u"][:4].any()
    assert not rows["a"].any()


def test_without_contact_palate_or_vault() -> None:
    speaker = Speaker.reference()
    with pytest.raises(InputError, match="needs a posture with contact"):
        palatogram(rest_posture(speaker))
    with pytest.raises(InputError, match="needs the wall 'roof'; this speaker has hard_palate"):
        palatogram(rest_posture(speaker), "roof")
    wall = vault()
    flat = Wall(wall.vertices * [1.0, 1.0, 0.0], wall.faces)
    with pytest.raises(InputError, match="no palatogram on wall 'hard_palate': it does not rise"):
        palatogram(touching(np.zeros((1, 3)), np.zeros(1), flat))
    gutter = Wall(np.column_stack([wall.vertices[:, :2], wall.vertices[:, 0]]), wall.faces)
    with pytest.raises(InputError, match="it is flat across at x ="):
        palate_electrodes(gutter)
    with pytest.raises(InputError, match="does not meet the midplane"):
        palate_electrodes(Wall(wall.vertices + np.array([0.0, 0.1, 0.0]), wall.faces))
