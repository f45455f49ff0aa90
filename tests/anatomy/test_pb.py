"""The PB speaker from its folder: published facts (shared/reference/pb/README.md)."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from glossa.anatomy import Speaker
from glossa.anatomy.muscle_topology import capacity_shares
from glossa.errors import SpeakerFileError

PB_FOLDER = Path(__file__).resolve().parents[2].parent / "shared" / "reference" / "pb"


def test_published_facts(pb: Speaker) -> None:
    assert (len(pb.nodes), len(pb.hexahedra)) == (948, 740)
    assert pb.volume * 1e6 == pytest.approx(102.29, abs=0.005)
    assert pb.scaled_jacobians.min() == pytest.approx(0.007, abs=0.0005)
    assert len(pb.surface_quads) == 368
    assert len(pb.midsagittal_nodes) == 120
    assert pb.outside_points.tolist() == [946, 947] == pb.node_sets["styloid"].tolist()
    assert (len(pb.node_sets["jaw"]), len(pb.node_sets["hyoid"])) == (59, 33)
    assert len(pb.contours["dorsum"]) == 27
    assert set(pb.walls) == {"hard_palate", "soft_palate", "mandible"}


def test_fibres_as_published(pb: Speaker) -> None:
    data = json.loads((PB_FOLDER / "pb_tongue.json").read_text())
    counts = {"GGa": 9, "GGm": 6, "GGp": 18, "Sty": 18, "HG": 20, "Vert": 54, "Trans": 102, "IL": 8, "SL": 22}
    assert {name: len(m.fibres) for name, m in pb.muscles.items()} == counts | {"GH": 10, "MH": 28}
    for name, entry in data["muscles"].items():
        assert np.allclose(pb.fibre_rest_lengths(name), entry["rest_length_m"], rtol=0, atol=1e-12)
        assert pb.muscles[name].fibres_per_element is None
        shares = capacity_shares(pb.nodes, pb.hexahedra, pb.muscles[name])
        assert shares.sum() == pytest.approx(1.0, abs=1e-12)
        assert (shares > 0).all()


def test_surface_as_published(pb: Speaker) -> None:
    data = json.loads((PB_FOLDER / "pb_tongue.json").read_text())
    published = {tuple(sorted(quad)) for quad in data["surface_quads"]}
    assert {tuple(sorted(quad)) for quad in pb.surface_quads.tolist()} == published


def test_contact_faces_as_published(pb: Speaker, tmp_path: Path) -> None:
    data = json.loads((PB_FOLDER / "pb_tongue.json").read_text())
    assert {name: len(faces) for name, faces in pb.contact_faces.items()} == {
        "hard_palate": 44,
        "soft_palate": 36,
        "mandible": 152,
    }
    for name, faces in pb.contact_faces.items():
        published = data["contact_surface_quads"]["tongue_contact_" + name.replace("_", "")]
        assert [sorted(face) for face in faces.tolist()] == [sorted(data["surface_quads"][k]) for k in published]
    for file in PB_FOLDER.glob("*.obj"):
        shutil.copyfile(file, tmp_path / file.name)
    zones = data.pop("contact_surface_quads")
    (tmp_path / "pb_tongue.json").write_text(json.dumps(data))
    assert dict(Speaker.load(tmp_path).contact_faces) == {}
    data["contact_surface_quads"] = zones | {"tongue_contact_mandible": [0, 368]}
    (tmp_path / "pb_tongue.json").write_text(json.dumps(data))
    with pytest.raises(SpeakerFileError, match="tongue_contact_mandible names face 368 of 368 surface_quads"):
        Speaker.load(tmp_path)


def test_hyoid(pb: Speaker) -> None:
    assert pb.hyoid is not None
    assert pb.hyoid.surface is not None
    assert pb.hyoid.mass == pytest.approx(3.4027e-6 * 2000, rel=1e-4)
    assert len(pb.hyoid.springs) == 12
    for spring in pb.hyoid.springs:
        to_bone = np.linalg.norm(pb.hyoid.surface.vertices - spring.on_hyoid, axis=1).min()
        assert to_bone < 1e-3
        assert spring.stiffness == 220.0
        assert np.linalg.norm(spring.fixed - spring.on_hyoid) == pytest.approx(spring.rest_length, rel=1e-9)


@pytest.mark.usefixtures("pb")
def test_broken_folder(tmp_path: Path) -> None:
    for file in PB_FOLDER.glob("*.obj"):
        shutil.copyfile(file, tmp_path / file.name)
    text = (PB_FOLDER / "pb_tongue.json").read_text()
    (tmp_path / "pb_tongue.json").write_text(text[: len(text) // 2])
    with pytest.raises(SpeakerFileError, match="not a complete JSON file"):
        Speaker.load(tmp_path)
    (tmp_path / "pb_tongue.json").write_text(json.dumps({"nodes": []}))
    with pytest.raises(SpeakerFileError, match="missing or malformed entry"):
        Speaker.load(tmp_path)
    (tmp_path / "pb_tongue.json").write_text(text)
    (tmp_path / "hyoid.obj").write_text("v 0 0 0\nf 1 2 x\n")
    with pytest.raises(SpeakerFileError, match=r"hyoid\.obj, line 2"):
        Speaker.load(tmp_path)
    (tmp_path / "hyoid.obj").write_text("hello\n")
    with pytest.raises(SpeakerFileError, match="no faces"):
        Speaker.load(tmp_path)
