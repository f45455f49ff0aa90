"""The paper's speaker bare: Table II and the vowels' shapes. Hyoid fixed, no contact.

Muscle forces and displacements of a published speaker, not ours to tune: limits are set where the paper's own readings
leave room (section 8 of the design), and what does not agree is listed with its number, so that a change is noticed.
With walls and a mobile hyoid: test_pb_contact.py and its neighbours.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest
from tests.blocks import FloatArray

from glossa import VOWELS, Posture, Ramp, Scene, Speaker, paper

BARE: dict[str, Any] = {"contact": False, "hyoid": "fixed"}

FORCES = pd.DataFrame(
    {row["vowel"]: {m: float(row[m]) for m in row if m != "vowel"} for row in paper.rows("table2_forces.csv")}
)
"""Table II, N: muscles x vowels."""


@pytest.fixture(scope="module")
def vowels(pb: Speaker) -> dict[str, Posture]:
    """From rest, without gravity."""
    scene = Scene(pb, gravity=None, mirror=True, **BARE)
    return {vowel: scene.equilibrate(commands) for vowel, commands in VOWELS.items()}


def test_all_vowels_converge_from_rest(vowels: dict[str, Posture], pb: Speaker) -> None:
    assert set(vowels) == {"i", "a", "u", "ə"}
    for vowel, posture in vowels.items():
        report = posture.report
        assert report is not None
        assert report.converged
        assert report.indefinite == 0
        assert report.iterations <= 10
        assert report.residual <= 1e-8 * report.force_scale
        assert report.least_jacobian > 0.3
        full = Scene(pb, gravity=None, **BARE).equilibrate(VOWELS[vowel])
        assert full.forces.to_numpy() == pytest.approx(posture.forces.to_numpy(), abs=1e-5)


SILENT_HERE = {("u", "IL"): 0.47}
"""Active in Table II (N) and silent here. The feasibility study found the same with contact and a mobile hyoid."""


@pytest.mark.parametrize("vowel", list(VOWELS))
def test_which_muscles_are_active(vowels: dict[str, Posture], vowel: str) -> None:
    ours, table = vowels[vowel].forces, FORCES[vowel]
    active = [m for m in table.index if table[m] > 0.3 and (vowel, m) not in SILENT_HERE]
    silent = [m for m in table.index if table[m] == 0.0]
    assert len(active) >= 2
    assert len(silent) >= 1
    assert {m: f for m, f in ours[active].items() if f < 0.1} == {}  # least: MH of /a/, 0.14 N
    assert {m: f for m, f in ours[silent].items() if f > 0.2} == {}  # most: HG of /i/, 0.13 N
    for (which, muscle), force in SILENT_HERE.items():
        assert FORCES.loc[muscle, which] == force
        assert vowels[which].forces[muscle] < 0.05
    # The reflex alone: no command below the rest length, yet a force.
    reflexive = [m for m in active if VOWELS[vowel][m] >= 1.0]
    if vowel == "i":
        assert reflexive == ["GGa", "Trans"]


def test_forces_of_table_2(vowels: dict[str, Posture]) -> None:
    ours = pd.DataFrame({vowel: posture.forces for vowel, posture in vowels.items()})[["i", "a", "u"]]
    table = FORCES[["i", "a", "u"]]
    counted = (table > 1.0) & ~table.index.isin(["GH"])[:, None]  # GH pulls at a hyoid that does not yield
    assert counted.to_numpy().sum() == 12
    score = (ours - table).abs()[counted].sum().sum() / table[counted].sum().sum()
    assert score < 0.35  # 0.276 seen, 0.301 with GH; the study had 0.27 for all muscles with contact and gravity
    ratio = (ours / table)[counted].stack()
    assert ratio.min() > 0.4  # GGa of /a/, 1.50 of 3.34 N
    assert ratio.max() < 1.4  # Trans of /i/, 2.02 of 1.61 N
    assert float(ours["i"]["GH"]) == pytest.approx(6.2, abs=0.3)  # Table II: 3.37; 3.6 with a mobile hyoid


def shifts(posture: Posture) -> dict[str, FloatArray]:
    """(x, z) displacement in mm of the three marked nodes."""
    moved = 1e3 * posture.displacements
    return {name: moved[posture.speaker.node_sets[name][0]][[0, 2]] for name in ("tip", "dorsum", "rear")}


SHAPES = {
    # vowel: node -> (x backward, z up) in mm of the feasibility study, with contact, gravity and a mobile hyoid
    "i": {"dorsum": (-6.5, 6.4), "rear": (-11.0, -0.3)},
    "a": {"dorsum": (3.0, -7.5), "rear": (2.5, -5.8)},
    "u": {"tip": (8.6, -4.1), "dorsum": (3.5, 5.6), "rear": (-1.8, -2.8)},
}


def test_shapes_of_the_vowels(vowels: dict[str, Posture]) -> None:
    for vowel, nodes in SHAPES.items():
        ours = shifts(vowels[vowel])
        for node, wanted in nodes.items():
            assert np.linalg.norm(ours[node] - wanted) < 2.6, (vowel, node, ours[node])  # 2.4 mm seen: tip of /u/
            large = np.abs(wanted) > 2.0
            assert (np.sign(ours[node]) == np.sign(wanted))[large].all(), (vowel, node, ours[node])
    for node, shift in shifts(vowels["ə"]).items():
        assert np.linalg.norm(shift) < 0.8, node  # the neutral vowel is the rest shape
    # Without the lower teeth the tip of /i/ sinks, as the study saw too (6.3 mm): contact decides about tips.
    assert shifts(vowels["i"])["tip"][1] == pytest.approx(-5.5, abs=0.5)
    # Front and back, high and low.
    at = {vowel: posture.node_set("dorsum")[0] for vowel, posture in vowels.items()}
    assert at["i"][0] < at["ə"][0] < at["a"][0]
    assert at["a"][2] < at["ə"][2] < min(at["i"][2], at["u"][2])
    assert vowels["i"].node_set("rear")[0, 0] < vowels["a"].node_set("rear")[0, 0] - 0.01  # wide pharynx of /i/


@pytest.mark.parametrize("muscle", ["GGa", "GGp", "Sty", "HG"])
def test_converged_means_converged(pb: Speaker, muscle: str) -> None:
    """The standard tolerance leaves nanometres, however wild the way: from rest, and from the posture of /i/."""
    scene = Scene(pb, mirror=True, **BARE)
    command = {muscle: 0.8}
    exact = scene.equilibrate(command, accuracy="reference")
    assert np.abs(exact.displacements).max() > 3e-3
    for start in (None, scene.equilibrate(VOWELS["i"])):
        found = scene.equilibrate(command, start=start)
        assert found.positions == pytest.approx(exact.positions, abs=1e-6)


# The reflex loop


@pytest.mark.slow
@pytest.mark.parametrize(("vowel", "height"), [("i", 3.1), ("u", 0.85)])
def test_cycle_of_the_delayed_reflex(pb: Speaker, vowel: str, height: float) -> None:
    """At 17 ms the loop is marginal: cycles near 25 Hz that do not vanish with the time step (2.9 mm in the study)."""
    scene = Scene(pb, mirror=True, **BARE)
    start = scene.equilibrate(dict.fromkeys(VOWELS[vowel], 1.0))
    tip = pb.node_sets["tip"][0]
    heights, periods = [], []
    for dt in (0.002, 0.001):
        movement = scene.simulate(Ramp(VOWELS[vowel]), 0.36, dt=dt, initial=start)
        t = np.arange(0.2, 0.36, 0.001)
        z = np.array([1e3 * movement.at(float(time)).positions[tip, 2] for time in t])
        heights.append(np.ptp(z))
        above = z > 0.5 * (z.max() + z.min())
        rises = t[1:][above[1:] & ~above[:-1]]
        periods.append(np.diff(rises).mean())
    assert heights == pytest.approx([height, height], rel=0.1)
    assert heights[0] == pytest.approx(heights[1], rel=0.1)
    assert all(0.030 < period < 0.045 for period in periods)
    steady = scene.simulate(Ramp(VOWELS[vowel]), 0.36, dt=0.005, initial=start, integrator="backward_euler")
    assert np.ptp(1e3 * steady.positions[steady.times > 0.2][:, tip, 2]) < 0.7 * heights[1]
