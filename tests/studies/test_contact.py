"""Tables of contact and hyoid, and the cost of effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glossa import VOWELS, InputError, Ramp, Scene, Speaker
from glossa.studies import contact_over_time, contact_table, effect_costs
from glossa.studies.costs import FAR, far_walls


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(Speaker.reference(), mirror=True)


def test_table_has_area_force_and_hyoid(scene: Scene) -> None:
    posture = scene.equilibrate(VOWELS["i"])
    assert posture.contact is not None
    assert posture.hyoid is not None
    assert posture.report is not None
    failed = replace(posture, report=replace(posture.report, converged=False))
    table = contact_table({"i": posture, "failed": failed})
    assert dict(table.sizes) == {"posture": 2, "wall": len(scene.speaker.walls), "axis": 3}
    row = table.sel(posture="i")
    assert float(row["area"].sel(wall="mandible")) == pytest.approx(posture.contact.touched_areas["mandible"] * 1e6)
    assert float(row["area"].sel(wall="hard_palate")) > 50.0
    assert row["force"].sel(wall="mandible").values == pytest.approx(posture.contact.forces.loc["mandible"].to_numpy())
    assert row["hyoid_displacement"].values == pytest.approx(posture.hyoid.displacement * 1e3)
    assert all(bool(table[name].sel(posture="failed").isnull().all()) for name in table)
    assert {name: table[name].attrs["units"] for name in table} == {
        "area": "mm2",
        "force": "N",
        "hyoid_displacement": "mm",
    }


def test_table_of_a_movement(scene: Scene) -> None:
    movement = scene.simulate(Ramp(VOWELS["u"]), 0.02, accuracy="draft")
    table = contact_over_time(movement)
    assert table["time"].values.tolist() == movement.times.tolist()
    end = movement.at(float(movement.times[-1]))
    assert end.contact is not None
    assert end.hyoid is not None
    assert float(table["area"].isel(time=-1).sum()) == pytest.approx(float(end.contact.touched_areas.sum()) * 1e6)
    assert table["hyoid_displacement"].isel(time=-1).values == pytest.approx(end.hyoid.displacement * 1e3)
    assert float(table["area"].isel(time=0).sum()) == 0.0
    assert float(table["area"].max()) > 0.0


def test_scenes_without_contact_and_hyoid_have_no_numbers() -> None:
    bare = Scene(Speaker.reference(), mirror=True, contact=False, hyoid="fixed")
    table = contact_table({"rest": bare.equilibrate()})
    assert bool(table.to_array().isnull().all())
    with pytest.raises(InputError, match="at least one posture"):
        contact_table({})


def test_walls_out_of_reach_change_nothing() -> None:
    speaker = far_walls(Speaker.reference())
    assert list(speaker.walls) == list(Speaker.reference().walls)
    body = speaker.nodes[np.unique(speaker.hexahedra)]
    for wall in speaker.walls.values():
        assert (wall.vertices.min(axis=0) <= body.min(axis=0) - 0.05 + 1e-12).all()
        assert (wall.vertices.max(axis=0) >= body.max(axis=0) + 0.05 - 1e-12).all()
    far = Scene(speaker, mirror=True, friction=0.0).equilibrate(VOWELS["i"])
    bare = Scene(speaker, mirror=True, contact=False).equilibrate(VOWELS["i"])
    assert far.contact is not None
    assert not far.contact.touching.any()
    assert far.contact.gaps.min() > 5e-3  # distances are known up to some millimetres, and not less beyond
    assert far.positions == pytest.approx(bare.positions, abs=1e-7)  # both solved to 1e-8 of the force scale


def test_costs_count_the_same_work_without_touch() -> None:
    costs = effect_costs(Speaker.reference(), "u", 0.006, repetitions=2)
    assert costs["scene"].values.tolist()[1] == FAR
    assert bool((costs["seconds"] > 0.0).all())
    for name in ("factorisations", "residuals", "stages"):
        assert int(costs[name].sel(scene=FAR)) == int(costs[name].sel(scene="tissue and muscles")) > 0
    assert float(costs["contact_seconds"].sel(scene="tissue and muscles")) == 0.0
    assert float(costs["contact_seconds"].sel(scene=FAR)) > 0.0
    assert float(costs["tip_change_end"].sel(effect="gravity")) > 1e-3
    assert bool((costs["tip_change_largest"] >= costs["tip_change_end"]).all())


def test_costs_need_walls_and_a_vowel() -> None:
    with pytest.raises(InputError, match="unknown vowel 'y'"):
        effect_costs(Speaker.reference(), "y")
    speaker = Speaker.reference()
    bare = Speaker(speaker.nodes, speaker.hexahedra, muscles=speaker.muscles, node_sets=speaker.node_sets)
    with pytest.raises(InputError, match="no walls"):
        effect_costs(bare)
