"""Movements in several steps end as the spectrum of the delayed loop says: in rest, or in a cycle."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from tests.blocks import block

from glossa import VOWELS, InputError, MotorCommands, Movement, Reflex, Scene, Speaker
from glossa.studies.stability_schedules import RandomRamp, agreement, cycle, movements_in_steps, random_ramps

TARGET = RandomRamp("short", MotorCommands({"axial": 0.9}), 0.03)


def blocks(delay: float) -> Scene:
    body = block((3, 2, 2), (0.06, 0.03, 0.03), muscles={"axial": 20.0})
    return Scene(body, fixed=["left"], reflex=Reflex(delay=delay))


@pytest.fixture(scope="module")
def resting() -> xr.Dataset:
    return movements_in_steps(blocks(0.007), [TARGET], (0.0005, 0.001, 0.002))


@pytest.fixture(scope="module")
def cycling() -> xr.Dataset:
    return movements_in_steps(blocks(0.017), [TARGET], (0.0005, 0.001, 0.002))


def test_where_no_root_grows_all_steps_come_to_rest(resting: xr.Dataset) -> None:
    assert float(resting["growth"].item()) < 0.0
    assert bool(agreement(resting)["stable"].item())
    assert float(agreement(resting)["farthest"].item()) < 1e-6
    assert float(agreement(resting)["apart"].item()) < 1e-6
    assert float(resting["apart"].isel(ramp=0, step=0)) == 0.0
    assert float(resting["other_equilibrium"].item()) < 1e-8
    assert np.isnan(agreement(resting)["swing_change"].item())


def test_where_a_root_grows_steps_agree_on_the_cycle(cycling: xr.Dataset) -> None:
    assert float(cycling["growth"].item()) > 0.0
    assert float(cycling["swing"].min()) > 1e-4
    assert float(agreement(cycling)["swing_change"].item()) < 0.05
    assert float(agreement(cycling)["frequency_change"].item()) < 0.05
    # A cycle is not the small movement that the root describes, but near it in frequency.
    assert float(cycling["frequency"].isel(step=0, ramp=0)) == pytest.approx(
        float(cycling["root_frequency"].item()), rel=0.15
    )
    assert cycling["muscle"].item() == "axial"


def test_random_ramps_repeat() -> None:
    some, more = random_ramps(3, 5), random_ramps(6, 5)
    assert more[:3] == some
    assert [ramp.vowel for ramp in some] == list(VOWELS)[:3]
    for ramp in more:
        own = VOWELS[ramp.vowel]
        shares = np.array([ramp.target[name] / own[name] for name in own])
        assert np.abs(shares - 1.0).max() <= 0.1
        assert np.ptp(shares) > 0.01
        assert 0.02 <= ramp.duration <= 0.1
    assert random_ramps(3, 6) != some


@pytest.mark.parametrize(("frequency", "growth"), [(26.3, 0.0), (61.7, -2.0)])
def test_cycle_is_measured(frequency: float, growth: float) -> None:
    """A node on a line at an angle, with a slow drift across its movement."""
    scene = blocks(0.017)
    still = scene.simulate(None, 0.01, dt=0.005)
    times = np.arange(0.0, 1.0005, 0.001)
    wave, speed = np.exp(growth * (times - 1.0)), 2.0 * math.pi * frequency
    line = np.array([0.6, 0.0, 0.8])
    positions = np.repeat(scene.speaker.nodes[None], len(times), axis=0).copy()
    velocities = np.zeros_like(positions)
    positions[:, 5] += 1e-3 * (wave * np.sin(speed * times))[:, None] * line
    velocities[:, 5] = 1e-3 * (wave * (speed * np.cos(speed * times) + growth * np.sin(speed * times)))[:, None] * line
    fields = {name: getattr(still, name) for name in ("speaker", "report")}
    movement = Movement(
        times=times,
        positions=positions,
        velocities=velocities,
        activations=np.zeros((len(times), 9)),
        fibre_forces=np.zeros((len(times), 9)),
        **fields,
    )
    swing, found = cycle(movement, 5)
    assert found == pytest.approx(frequency, rel=0.01)
    first, second = (math.exp(-growth * (0.25 - k / frequency)) for k in (0.25, 0.75))  # the first two extremes
    assert swing == pytest.approx(1e-3 * (first + second), rel=0.03)
    still_swing, still_frequency = cycle(movement, 6)
    assert still_swing == 0.0
    assert math.isnan(still_frequency)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"steps": (0.002, 0.001)}, "steps"),
        ({"ramps": []}, "there must be a ramp"),
        ({"until": 0.2}, "until must be longer"),
    ],
)
def test_bad_input_is_refused(arguments: dict[str, object], message: str) -> None:
    given: dict[str, object] = {"ramps": [TARGET], "steps": (0.001,), "until": 1.0} | arguments
    with pytest.raises(InputError, match=message):
        movements_in_steps(blocks(0.017), **given)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="count"):
        random_ramps(0, 1)
    with pytest.raises(InputError, match="needs a vowel"):
        random_ramps(1, 1, [])


@pytest.mark.slow
def test_speaker_ends_as_the_spectrum_says(reference: Speaker) -> None:
    """Two of the ramps, one of which comes to rest; the others are in data/results."""
    ramps = random_ramps(20, 8)
    scene = Scene(reference, mirror=True, friction=0.0)
    study = movements_in_steps(scene, [ramps[0], ramps[18]], (0.001, 0.002), integrator="SDIRK2")
    found = agreement(study)
    assert found["stable"].values.tolist() == [False, True]
    assert float(found["farthest"][1]) < 1e-5
    assert float(found["swing_change"][0]) < 0.05
    assert float(found["frequency_change"][0]) < 0.05
