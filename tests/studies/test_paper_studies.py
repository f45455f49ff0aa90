"""Gravity, transversalis and delay: sections V, III.B and II.C.1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block
from tests.studies.paper_runs import quick_scene

from glossa import VOWELS, InputError, MotorCommands, Movement, Ramp, Reflex, Scene, SolveError, Speaker, paper
from glossa.studies import (
    delay,
    gravity,
    gravity_at_rest,
    gravity_of_vowels,
    midsagittal_nodes,
    tracked_nodes,
    transversalis,
)
from glossa.studies.rest import rest_posture
from glossa.studies.shape_measures import midsagittal_area, muscle_stretch, widening
from glossa.studies.traces import even_times, force_traces, node_traces, peak_speeds


@pytest.fixture(scope="module")
def scene(reference: Speaker) -> Scene:
    return quick_scene(reference)


@pytest.fixture(scope="module")
def movement(scene: Scene) -> Movement:
    return scene.simulate(Ramp(VOWELS["i"]), until=0.02)


# Traces


def test_traces_are_the_movement_at_these_times(movement: Movement) -> None:
    times = even_times(0.02, 0.003)
    nodes = list(midsagittal_nodes(movement.speaker).values())
    moved, forces = node_traces(movement, nodes, times), force_traces(movement, times)
    assert np.abs(moved).max() > 1e-4
    for k, time in enumerate(times.tolist()):
        posture = movement.at(time)
        assert moved[k] == pytest.approx(posture.displacements[nodes], abs=1e-15)
        assert forces[k] == pytest.approx(posture.forces.to_numpy(), abs=1e-12)
    assert peak_speeds(movement, nodes)[0] == np.linalg.norm(movement.velocities[:, nodes[0]], axis=1).max()


def test_times_are_even_and_hold_both_ends() -> None:
    assert even_times(1.0, 0.3) == pytest.approx([0.0, 1 / 3, 2 / 3, 1.0])
    with pytest.raises(InputError, match="longer than the movement"):
        even_times(0.1, 0.2)


@pytest.mark.parametrize("times", [[-0.1], [0.03], [math.nan], [[0.0]]])
def test_times_outside_a_movement_are_refused(movement: Movement, times: Any) -> None:
    with pytest.raises(InputError, match="times must lie between"):
        node_traces(movement, [0], times)


# Gravity


@pytest.fixture(scope="module")
def at_rest(scene: Scene) -> xr.Dataset:
    return gravity_at_rest(scene, until=0.03)


def test_without_commands_gravity_decides(scene: Scene, at_rest: xr.Dataset) -> None:
    tip = tracked_nodes(scene.speaker)["tip"]
    supine = Scene(scene.speaker, **{**scene.options, "gravity": "supine"})
    posture = supine.equilibrate(None)
    assert at_rest["static_tip"].sel(control="silent", gravity="supine").values == pytest.approx(
        posture.displacements[tip], abs=1e-9
    )
    assert at_rest["static"].sel(control="silent", gravity="supine").values == pytest.approx(
        posture.displacements, abs=1e-9
    )
    reflex = supine.equilibrate(MotorCommands(dict.fromkeys(scene.speaker.muscles, 1.0)))
    assert at_rest["static_tip"].sel(control="reflex", gravity="supine").values == pytest.approx(
        reflex.displacements[tip], abs=1e-9
    )
    length = np.linalg.norm(at_rest["static_tip"], axis=2)
    assert length[0, 1] > 1.2 * length[1, 1] > 1e-3  # the reflex holds, but not all of it (section V.A)
    assert length[:, 2] == pytest.approx(0.0, abs=1e-9)
    assert float(at_rest["static_tip"].sel(control="silent", gravity="upright", axis="z")) < -1e-3
    assert float(at_rest["static_tip"].sel(control="silent", gravity="supine", axis="x")) > 1e-3


def test_movements_without_commands_begin_at_rest_and_end_at_final(at_rest: xr.Dataset) -> None:
    trace = at_rest["tip_trace"]
    assert trace.isel(time=0).values == pytest.approx(0.0, abs=1e-15)
    assert trace.isel(time=-1).values == pytest.approx(at_rest["final_tip"].values, abs=1e-12)
    assert float(at_rest["time"][-1]) == pytest.approx(0.03)
    falling = trace.sel(control="silent", gravity="upright", axis="z").values
    assert falling[-1] < -1e-4
    assert {name: at_rest[name].attrs["units"] for name in ("final", "static_tip", "time")} == {
        "final": "m",
        "static_tip": "m",
        "time": "s",
    }
    assert (at_rest["final_reason"].values == "").all()


def test_vowels_upright_and_supine(scene: Scene) -> None:
    study = gravity_of_vowels(scene, ["a"], until=0.04)
    supine = Scene(scene.speaker, **{**scene.options, "gravity": "supine"})
    forces = supine.simulate(Ramp(VOWELS["a"]), 0.04).forces
    here = study.sel(vowel="a", position="supine")
    assert here["peak_force"].values == pytest.approx(forces.max().to_numpy(), abs=1e-9)
    assert here["final_force"].values == pytest.approx(forces.iloc[-1].to_numpy(), abs=1e-9)
    assert here["static_force"].values == pytest.approx(supine.equilibrate(VOWELS["a"]).forces.to_numpy(), abs=1e-7)
    late = forces.to_numpy()  # 40 ms are less than the last 50
    assert here["force_swing"].values == pytest.approx(np.ptp(late, axis=0), abs=1e-9)
    before, after = (float(study["peak_force"].sel(vowel="a", position=p, acting="HG")) for p in ("upright", "supine"))
    assert float(study["peak_change"].sel(vowel="a", acting="HG")) == pytest.approx(100 * (after / before - 1))
    assert np.isnan(float(study["final_change"].sel(vowel="a", acting="Trans")))  # silent in /a/
    assert np.isfinite(study["final_formants"].values).all()
    assert (study["node_change"] > 0.0).all()
    assert (study["vowel_reason"].values == "").all()


def test_failed_movements_stay_with_their_reason(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise SolveError("no step today")

    monkeypatch.setattr(Scene, "simulate", fail)
    monkeypatch.setattr(Scene, "equilibrate", fail)
    told: list[str] = []
    study = gravity(scene, ["i"], until=0.02, vowel_until=0.02, progress=told.append)
    assert (study["final_reason"].values == "no step today").all()
    assert (study["static_reason"].values == "no step today").all()
    assert (study["vowel_reason"].values == "no step today").all()
    assert np.isnan(study["final_tip"].values).all()
    assert np.isnan(study["peak_change"].values).all()
    assert len(told) == 8
    assert study.attrs["study"] == "gravity"
    assert (transversalis(scene)["reason"].values == "no step today").all()
    assert (delay(scene, "i", [0.005, 0.017])["reason"].values == "no step today").all()


@pytest.mark.parametrize("vowels", [[], ["y"]])
def test_unknown_vowels_are_refused(scene: Scene, vowels: list[str]) -> None:
    with pytest.raises(InputError, match="vowels must be some of"):
        gravity_of_vowels(scene, vowels)


@pytest.mark.slow
def test_gravity_on_pb_against_section_5(pb: Speaker) -> None:
    study = gravity(Scene(pb, mirror=True))
    tip = np.linalg.norm(study["final_tip"], axis=2) * 1e3
    (silent_up, silent_back, _), (reflex_up, reflex_back, _) = tip.tolist()
    assert 0.0 < silent_up < 3.0
    assert reflex_back < silent_back  # reflexes limit the tip's rotation
    assert abs(reflex_back - 3.0) < 1.0
    assert float(study["final_tip"].sel(control="reflex", gravity="upright", axis="x")) > 0.0
    assert abs(reflex_up - 1.0) < 1.0
    change = study["static_change"].sel(acting="GGp")
    for vowel in ("i", "u"):
        assert float(change.sel(vowel=vowel)) == pytest.approx({"i": 1.0, "u": 7.0}[vowel], abs=2.5)
    assert float(change.sel(vowel="i")) < float(change.sel(vowel="u"))


# Transversalis


@pytest.fixture(scope="module")
def of_trans(scene: Scene) -> xr.Dataset:
    return transversalis(scene)


def test_the_reflex_keeps_the_tongue_narrow(scene: Scene, of_trans: xr.Dataset) -> None:
    own = scene.equilibrate(VOWELS["i"])
    reflex = of_trans.sel(condition="reflex")
    assert reflex["positions"].values == pytest.approx(own.positions, abs=1e-9)
    assert float(reflex["stretch"]) == pytest.approx(muscle_stretch(own, "Trans"))
    assert float(reflex["widening"]) == pytest.approx(widening(own))
    force = of_trans["forces"].sel(muscle="Trans").values
    assert force[1] == 0.0
    assert 0.0 < force[0] < force[2]
    silent, own_stretch, voluntary = (
        float(of_trans["stretch"].sel(condition=name)) for name in ("silent", "reflex", "voluntary")
    )
    assert silent > own_stretch > voluntary
    assert bool(of_trans["converged"].all())
    assert np.isfinite(of_trans["formants"].values).all()


def test_only_vowels_without_a_voluntary_transversalis(scene: Scene) -> None:
    with pytest.raises(InputError, match="activates Trans voluntarily"):
        transversalis(scene, "u")
    with pytest.raises(InputError, match="unknown vowel"):
        transversalis(scene, "y")
    with pytest.raises(InputError, match="below 1"):
        transversalis(scene, voluntary=1.0)


def test_statements_of_the_paper_name_what_the_study_measures() -> None:
    claims = paper.transversalis()
    assert set(claims["first"]) | set(claims["second"]) == {"reflex", "silent", "voluntary"}
    assert set(claims["sign"]) == {1, -1}


def test_measures_of_shape(reference: Speaker) -> None:
    rest = rest_posture(reference)
    assert muscle_stretch(rest, "Trans") == 1.0
    assert widening(rest) == 0.0
    area = midsagittal_area(reference, reference.nodes)
    assert 2e-3 < area < 5e-3
    assert midsagittal_area(reference, reference.nodes * [2.0, 1.0, 1.5]) == pytest.approx(3.0 * area)
    rest.positions[:, 1] *= 1.1
    surface = reference.nodes[np.unique(reference.surface_quads), 1]
    assert widening(rest) == pytest.approx(0.1 * np.ptp(surface))
    assert muscle_stretch(rest, "Trans") == pytest.approx(1.1, abs=0.01)
    with pytest.raises(InputError, match="no muscle 'XX'"):
        muscle_stretch(rest, "XX")


def test_area_of_a_block_and_none_off_the_midplane() -> None:
    body = block((2, 2, 2), (0.06, 0.04, 0.05), centred=True)
    assert midsagittal_area(body, body.nodes) == pytest.approx(0.06 * 0.05)
    aside = block((2, 1, 2), (0.06, 0.04, 0.05), centred=True)
    with pytest.raises(InputError, match="no midsagittal section"):
        midsagittal_area(aside, aside.nodes)


# Delay


def test_delays_change_the_path(scene: Scene) -> None:
    study = delay(scene, "i", [0.005, 0.017], until=0.04)
    assert study.attrs["reference_delay_s"] == 0.017
    assert study["path_change"].sel(delay=0.017).values == pytest.approx(0.0, abs=1e-15)
    assert (study["path_change"].sel(delay=0.005) > 1e-5).all()
    short = Scene(scene.speaker, **{**scene.options, "reflex": Reflex(delay=0.005)})
    movement = short.simulate(Ramp(VOWELS["i"]), 0.04)
    here = study.sel(delay=0.005)
    assert here["peak_force"].values == pytest.approx(movement.forces.max().to_numpy(), abs=1e-9)
    assert here["final_force"].values == pytest.approx(movement.forces.iloc[-1].to_numpy(), abs=1e-9)
    nodes = list(midsagittal_nodes(scene.speaker).values())
    assert here["trace"].isel(time=-1).values == pytest.approx((movement.positions[-1] - scene.speaker.nodes)[nodes])
    assert here["peak_speed"].values == pytest.approx(peak_speeds(movement, nodes))


@pytest.mark.parametrize("delays", [[0.01], [0.01, 0.01], [0.02, 0.01], [-0.01, 0.01], [0.01, math.nan], 0.01, "5,10"])
def test_delays_must_rise(scene: Scene, delays: Any) -> None:
    with pytest.raises(InputError, match="delay"):
        delay(scene, "i", delays)


def test_no_delay_without_reflex_or_vowel(reference: Speaker, scene: Scene) -> None:
    with pytest.raises(InputError, match="scene with a reflex"):
        delay(quick_scene(reference, reflex=None))
    with pytest.raises(InputError, match="unknown vowel"):
        delay(scene, "y")
