"""Contact maps, palatograms, and walls, hyoid and contact in other pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb

from glossa import InputError, Posture
from glossa.figures import contact_map, electropalatogram, midsagittal, midsagittal_panels
from glossa.figures.contact import LOOKS, ROOF, face_states
from glossa.figures.midsagittal import NEAR_MIDLINE
from glossa.figures.style import VOWEL_COLOURS
from glossa.palatogram import palatogram
from glossa.studies import rest_posture
from glossa.surroundings import hyoid_of, springs_of, walls_of


def test_states_are_those_of_the_contact_points(postures: dict[str, Posture]) -> None:
    posture = postures["i"]
    assert posture.contact is not None
    states = face_states(posture, ROOF)
    speaker = posture.speaker
    named = {tuple(sorted(face)) for wall in ROOF for face in speaker.contact_faces[wall].tolist()}
    may = np.array([tuple(sorted(quad)) in named for quad in speaker.surface_quads.tolist()])
    assert (states[~may] == -1).all()
    assert (states[may] >= 0).sum() > 100
    centres = posture.positions[speaker.surface_quads].mean(axis=1)
    pressed = posture.contact.points[posture.contact.touching & (posture.contact.wall < len(ROOF))]
    away = np.linalg.norm(centres[:, None] - pressed, axis=2).min(axis=1)
    assert (states == 0).sum() > 10
    assert away[states == 0].max() < 5e-3  # half a face
    assert away[states == 2].min() > 1e-3
    assert (face_states(posture, ["mandible"]) == 0).sum() > 0
    assert not (face_states(postures["a"], ["hard_palate"]) == 0).any()


def test_map_has_the_front_at_the_top_and_the_walls_over_it(postures: dict[str, Posture]) -> None:
    figure = contact_map(postures)
    assert [axes.get_title() for axes in figure.axes] == ["/i/", "/a/"]
    for axes in figure.axes:
        bottom, top = axes.get_ylim()
        assert bottom > top
        assert {c.get_gid() for c in axes.collections} >= {"tongue", *(f"wall:{name}" for name in ROOF)}
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == list(LOOKS)
    (tongue,) = (c for c in figure.axes[0].collections if c.get_gid() == "tongue")
    red = to_rgb(LOOKS["touching"])
    hues = np.asarray(tongue.get_facecolor())[:, :3]
    shaded = hues / np.maximum(hues[:, :1], 1e-9)
    assert (np.abs(shaded - np.array(red) / red[0]).max(axis=1) < 1e-6).sum() > 50


def test_map_refuses_what_it_cannot_show(postures: dict[str, Posture]) -> None:
    with pytest.raises(InputError, match="needs postures with contact"):
        contact_map(rest_posture(postures["i"].speaker))
    with pytest.raises(InputError, match="no wall 'roof'"):
        contact_map(postures["i"], walls=["roof"])
    with pytest.raises(InputError, match="at least one posture"):
        contact_map({})


def test_palatogram_fills_what_is_touched(postures: dict[str, Posture]) -> None:
    figure = electropalatogram(postures)
    for axes, (name, posture) in zip(figure.axes, postures.items(), strict=True):
        (squares,) = (c for c in axes.collections if isinstance(c, PolyCollection))
        filled = (np.asarray(squares.get_facecolor())[:, :3] == to_rgb(VOWEL_COLOURS[name])).all(axis=1)
        assert filled.tolist() == palatogram(posture).on.tolist()
        assert f"{palatogram(posture).percent:.0f} %" in axes.get_xlabel()
        bottom, top = axes.get_ylim()
        assert bottom > top
    assert palatogram(postures["i"]).on.any()


def test_points_under_pressure_near_the_midline_are_marked(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures["i"]).axes
    (dots,) = (c for c in axes.collections if isinstance(c, PathCollection) and c.get_gid() == "touching")
    contact = postures["i"].contact
    assert contact is not None
    shown = contact.touching & (np.abs(contact.points[:, 1]) < NEAR_MIDLINE)
    assert shown.any()
    assert np.asarray(dots.get_offsets()) == pytest.approx(contact.points[shown][:, [0, 2]] * 1e3)


def test_hyoid_is_drawn_where_it_is(postures: dict[str, Posture]) -> None:
    (axes,) = midsagittal(postures["i"]).axes
    (bone,) = (line for line in axes.lines if line.get_gid() == "wall:hyoid bone")
    (rest,) = (patch for patch in axes.patches if patch.get_gid() == "hyoid")
    pose = postures["i"].hyoid
    assert pose is not None
    assert abs(pose.displacement[0]) > 1e-3
    # A motion in the midplane moves the cut of a bone as it moves the bone.
    before = np.asarray(rest.get_path().vertices) / 1e3
    after = pose.moved(np.column_stack([before[:, 0], np.zeros(len(before)), before[:, 1]]))[:, [0, 2]] * 1e3
    drawn = np.asarray(bone.get_xydata())
    assert np.linalg.norm(drawn[:, None] - after, axis=2).min(axis=1).max() < 1e-9
    several = midsagittal(postures).axes[0]
    assert len([patch for patch in several.patches if patch.get_gid() == "hyoid"]) == 2
    (unmoved,) = (line for line in several.lines if line.get_gid() == "wall:hyoid bone")
    drawn = np.asarray(unmoved.get_xydata())
    assert np.linalg.norm(drawn[:, None] - before * 1e3, axis=2).min(axis=1).max() < 1e-9


def test_springs_on_request(postures: dict[str, Posture]) -> None:
    posture = postures["i"]
    assert not [line for line in midsagittal(posture).axes[0].lines if line.get_gid() == "spring"]
    (axes,) = midsagittal(posture, springs=True).axes
    lines = [line for line in axes.lines if line.get_gid() == "spring"]
    ends = springs_of(posture)
    assert len(lines) == len(ends) == 12
    low, high = axes.get_xlim()
    assert low < ends[:, :, 0].min() * 1e3 < ends[:, :, 0].max() * 1e3 < high
    hyoid, pose = posture.speaker.hyoid, posture.hyoid
    assert hyoid is not None
    assert pose is not None
    assert ends[0, 0] == pytest.approx(pose.moved(hyoid.springs[0].on_hyoid))
    assert ends[0, 1] == pytest.approx(hyoid.springs[0].fixed)


def test_walls_are_drawn_where_they_were_displaced_to(postures: dict[str, Posture]) -> None:
    posture, shift = postures["i"], np.array([0.0, 0.0, 5e-3])
    raised = replace(posture, wall_displacements={"hard_palate": shift})
    walls = walls_of(raised)
    assert walls["hard_palate"].vertices == pytest.approx(posture.speaker.walls["hard_palate"].vertices + shift)
    assert walls["mandible"] is posture.speaker.walls["mandible"]
    tops = []
    for shown in (posture, raised):
        (axes,) = midsagittal_panels({"x": shown}).axes
        (line,) = (line for line in axes.lines if line.get_gid() == "wall:hard_palate")
        tops.append(np.asarray(line.get_xydata())[:, 1].max())
    assert tops[1] - tops[0] == pytest.approx(5.0)
    both = midsagittal({"low": posture, "high": raised}).axes[0]
    assert len([line for line in both.lines if line.get_gid() == "wall:hard_palate"]) == 2
    assert len([line for line in both.lines if line.get_gid() == "wall:mandible"]) == 1


def test_bones_at_rest_and_speakers_without(postures: dict[str, Posture]) -> None:
    speaker = postures["i"].speaker
    assert speaker.hyoid is not None
    assert hyoid_of(rest_posture(speaker)) is speaker.hyoid.surface
    from tests.blocks import block

    bare = rest_posture(block((1, 1, 1)))
    assert hyoid_of(bare) is None
    assert springs_of(bare).shape == (0, 2, 3)
