"""The reader of ArtiSynth Models' files: a tiny folder in the same formats, and the checkout where there is one."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from glossa.anatomy import Speaker
from glossa.errors import SpeakerFileError

NODES = [
    (1, 0.0, -0.01, 0.0), (2, 0.01, -0.01, 0.0), (3, 0.01, 0.0, 0.0), (4, 0.0, 0.0, 0.0),
    (5, 0.0, -0.01, 0.01), (6, 0.01, -0.01, 0.01), (7, 0.01, 0.0, 0.01), (8, 0.0, 0.0, 0.01),
    (9, 0.0, 0.01, 0.0), (10, 0.01, 0.01, 0.0), (11, 0.0, 0.01, 0.01), (12, 0.01, 0.01, 0.01),
    (20, 0.0, 0.0, 0.05), (21, 0.01, 0.0, 0.05), (22, 0.01, 0.01, 0.05), (23, 0.0, 0.01, 0.05),
    (30, 0.0, 0.0, -0.02), (31, 0.0, 0.0, -0.05), (40, 0.02, -0.02, 0.03), (41, 0.02, 0.02, 0.03),
]  # fmt: skip
ELEMENTS = [
    ([1, 2, 3, 4, 5, 6, 7, 8], 1),
    ([11, 12, 7, 8, 9, 10, 3, 4], 1),  # left-handed on purpose
    ([20, 21, 22, 23, 0, 0, 0, 0], 921),
    ([30, 31, 0, 0, 0, 0, 0, 0], 941),
    ([8, 5, 6, 7, 0, 0, 0, 0], 911),
    ([3, 4, 8, 7, 0, 0, 0, 0], 911),  # between the two hexahedra: not free
    ([4, 3, 2, 1, 0, 0, 0, 0], 912),  # a zone whose wall is missing
]
FIBRES = """! comment
nb_muscles = 4 ! count
FIBER(1,1,1)=1
FIBER(2,1,1)=5
FIBER(1,2,1)=4   ! the midline fibre is listed on both sides
FIBER(2,2,1)=8
NB_NODES_FIBER(1,1)=2
NB_NODES_FIBER(2,1)=2
FIBER(1,1,2)=9
FIBER(2,1,2)=11
FIBER(1,2,2)=8
FIBER(2,2,2)=4
NB_NODES_FIBER(1,2)=2
NB_NODES_FIBER(2,2)=2
FIBER(1,1,3)=1
FIBER(2,1,3)=2
FIBER(3,1,3)=40
NB_NODES_FIBER(1,3)=3
FIBER(1,1,4)=9
FIBER(2,1,4)=10
FIBER(3,1,4)=41
NB_NODES_FIBER(1,4)=3
"""
MUSCLES = """*DIM, muscleName, CHAR, nb_muscles
muscleName(1) = 'GGA_L'
muscleName(2) = 'GGA_R'
muscleName(3) = 'STY_L'
muscleName(4)= 'STY_R'
ESEL,S,ELEM,,1
CM,GGA_L,ELEM
ESEL,S,ELEM,,2
CM,GGA_R,ELEM
ESEL,S,ELEM,,1,2
CM,STY_L,ELEM
ESEL,S,ELEM,,1
ESEL,A,ELEM,,2,2,1
CM,STY_R,ELEM
"""
HYOID = """o hyoid
v 0 -0.01 -0.02
v 0.01 0.01 -0.02
v 0 0.01 -0.02
v 0 0 -0.03
f 1 2 3
f 1/1 4/4 2/2
f 2 4 3
f 3 4 1
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    lines = [f"{n:8d} {x:+.8e}     {y:+.8e}     {z:+.8e}" for n, x, y, z in NODES]
    (tmp_path / "tongueIcp.3.node").write_text("\n".join(lines) + "\n")
    rows = [
        "".join(f"{n:6d}" for n in [*corners, material, 1, 1, 1, 0, number])
        for number, (corners, material) in enumerate(ELEMENTS, start=1)
    ]
    (tmp_path / "tongueIcp.3.elem").write_text("\n".join(rows) + "\n")
    (tmp_path / "Fibers.mac").write_bytes(("! \xe9t\xe9\n" + FIBRES).encode("latin-1"))
    (tmp_path / "CreateMuscles.mac").write_text(MUSCLES)
    (tmp_path / "ICPHyoid3.obj").write_text(HYOID)
    (tmp_path / "jawAttachments.txt").write_text("0 1 8 9")
    (tmp_path / "hyoidAttachments.txt").write_text("2 3\n")
    (tmp_path / "tongueContourNodes.txt").write_text("7 6 ")
    return tmp_path


def test_reads_the_formats(folder: Path) -> None:
    speaker = Speaker.from_artisynth(folder)
    assert len(speaker.hexahedra) == 2
    assert speaker.volume == pytest.approx(2e-6)
    assert speaker.outside_points.tolist() == [12, 13] == speaker.node_sets["styloid"].tolist()
    assert len(speaker.muscles["GGa"].fibres) == 3
    assert speaker.muscles["GGa"].force_capacity == 18.0
    assert speaker.muscles["Sty"].elements.tolist() == [0, 1]
    assert speaker.node_sets["jaw"].tolist() == [0, 1, 8, 9]
    assert speaker.contours["dorsum"].tolist() == [7, 6]
    assert speaker.walls["hard_palate"].faces.tolist() == [[0, 1, 2, 3]]
    assert set(speaker.contact_faces) == {"hard_palate"}
    assert [sorted(face) for face in speaker.contact_faces["hard_palate"].tolist()] == [[4, 5, 6, 7]]
    assert speaker.hyoid is not None
    (spring,) = speaker.hyoid.springs
    assert spring.on_hyoid.tolist() == [0.0, 0.0, -0.02]
    assert spring.rest_length == pytest.approx(0.03)
    assert speaker.hyoid.mass == pytest.approx(2000 * 0.01 * 0.02 / 2 * 0.01 / 3)


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("Fibers.mac", "NB_NODES_FIBER(1,3)=3", "NB_NODES_FIBER(1,3)=4", "muscle 3, fibre 1 has 4 nodes but not all"),
        ("Fibers.mac", "FIBER(1,1,1)=1", "FIBER(1,1,1)=x", "Fibers.mac, line 4: cannot read"),
        ("Fibers.mac", "FIBER(3,1,3)=40", "FIBER(3,1,3)=99", "node 99 is used but not in the node file"),
        ("CreateMuscles.mac", "'GGA_L'", "'ABC_L'", "unknown muscle 'ABC_L'"),
        ("CreateMuscles.mac", "CM,GGA_R,ELEM", "", "muscle 'GGA_R' .* lacks elements or fibres"),
        ("CreateMuscles.mac", "ESEL,S,ELEM,,2", "ESEL,S,ELEM,,7", "element 7 is not an element of the tongue"),
        ("CreateMuscles.mac", "ESEL,A,", "ESEL,U,", "cannot read the selection"),
        ("tongueIcp.3.elem", "   921", "", "expected 14"),
        ("tongueIcp.3.node", "e", "q", "tongueIcp.3.node, line 1"),
        ("jawAttachments.txt", "0", "zero", "not a list of tongue nodes"),
    ],
)
def test_broken_files(folder: Path, file: str, old: str, new: str, message: str) -> None:
    text = (folder / file).read_text(encoding="latin-1")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="latin-1")
    with pytest.raises(SpeakerFileError, match=message):
        Speaker.from_artisynth(folder)


@pytest.mark.parametrize("file", ["Fibers.mac", "tongueIcp.3.node", "jawAttachments.txt", "CreateMuscles.mac"])
def test_missing_files(folder: Path, file: str) -> None:
    (folder / file).unlink()
    with pytest.raises(FileNotFoundError):
        Speaker.from_artisynth(folder)


def _faces(quads: np.ndarray) -> set[tuple[int, ...]]:
    return {tuple(sorted(quad)) for quad in quads.tolist()}


@pytest.mark.skipif("GLOSSA_ARTISYNTH" not in os.environ, reason="GLOSSA_ARTISYNTH names no checkout")
def test_checkout_gives_the_published_speaker(pb: Speaker) -> None:
    read = Speaker.from_artisynth(os.environ["GLOSSA_ARTISYNTH"])
    assert np.abs(read.nodes - pb.nodes).max() < 1e-5
    assert np.array_equal(np.sort(read.hexahedra, axis=1), np.sort(pb.hexahedra, axis=1))
    for name, muscle in pb.muscles.items():
        assert set(read.muscles[name].elements.tolist()) == set(muscle.elements.tolist())
        lengths = np.sort(read.fibre_rest_lengths(name))
        assert np.allclose(lengths, np.sort(pb.fibre_rest_lengths(name)), rtol=0, atol=1e-6)
    for name, nodes in pb.node_sets.items():
        assert set(read.node_sets[name].tolist()) == set(nodes.tolist())
    for name, wall in pb.walls.items():
        assert read.walls[name].faces.shape == wall.faces.shape
    for name, faces in pb.contact_faces.items():
        assert _faces(read.contact_faces[name]) == _faces(faces)
    assert read.hyoid is not None
    assert pb.hyoid is not None
    assert read.hyoid.mass == pytest.approx(pb.hyoid.mass, rel=1e-4)
