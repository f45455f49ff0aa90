from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.acoustics.tracts import TWO_TUBES

from glossa import TUBE_CONSTANTS, AreaFunction, InputError, Sound, synthesize
from glossa.acoustics import LF, synthesis
from glossa.acoustics.synthesis import _responses, _ring

A = AreaFunction(np.full(17, 0.01), np.concatenate([np.full(9, 1e-4), np.full(8, 7e-4)]))
I = AreaFunction(np.full(17, 0.01), np.concatenate([np.full(11, 8e-4), np.full(6, 1e-4)]))  # noqa: E741


def pitch(sound: Sound, begin: float, end: float) -> float:
    """f0 in Hz: the largest autocorrelation between 60 and 400 Hz, refined by a parabola."""
    part = sound.samples[(sound.times >= begin) & (sound.times < end)]
    product = np.fft.irfft(np.abs(np.fft.rfft(part, 2 * part.size)) ** 2)[: part.size]
    product /= np.arange(part.size, 0, -1)
    low, high = sound.sampling_rate // 400, sound.sampling_rate // 60
    at = low + int(np.argmax(product[low:high]))
    before, here, after = product[at - 1 : at + 2]
    return float(sound.sampling_rate / (at + 0.5 * (before - after) / (before - 2.0 * here + after)))


@pytest.mark.parametrize("source", ["lf", "rosenberg", LF(rd=2.0)])
@pytest.mark.parametrize("rate", [16000, 44100])
def test_vowel(source: Any, rate: int) -> None:
    sound = synthesize(A, 110.0, 0.4, source=source, sampling_rate=rate)
    assert sound.sampling_rate == rate
    assert sound.samples.size == round(0.4 * rate)
    assert np.abs(sound.samples).max() == pytest.approx(0.9)
    assert abs(sound.samples.mean()) < 0.01
    assert pitch(sound, 0.1, 0.3) == pytest.approx(110.0, rel=0.005)


def test_voice_sets_in_and_dies_away() -> None:
    sound = synthesize(A, 120.0, 0.5)
    level = [np.abs(sound.samples[(sound.times >= t) & (sound.times < t + 0.01)]).max() for t in (0.0, 0.02, 0.2, 0.49)]
    assert level[0] < 0.2 * level[2]
    assert level[1] < level[2]
    assert level[3] < 0.1 * level[2]
    assert abs(sound.samples[0]) < 1e-3
    assert abs(sound.samples[-1]) < 1e-4


@pytest.mark.parametrize(
    "f0",
    [
        [100.0, 150.0],
        np.linspace(100.0, 150.0, 21),
        [(0.0, 100.0), (0.6, 150.0)],
        lambda time: 100.0 + time * 50.0 / 0.6,
    ],
)
def test_pitch_follows_its_contour(f0: Any) -> None:
    sound = synthesize(A, f0, 0.6)
    for time in (0.15, 0.3, 0.45):
        assert pitch(sound, time - 0.04, time + 0.04) == pytest.approx(100.0 + time * 50.0 / 0.6, rel=0.02)


def test_spectrum_is_source_times_transfer_function() -> None:
    """Two tracts, one voice: the ratio of their harmonics is the ratio of their transfer functions."""
    sounds = [synthesize(tract, 100.0, 1.0) for tract in (A, I)]
    window = np.hanning(30000)
    spectra = [np.fft.rfft(sound.samples[7000:37000] * window) for sound in sounds]
    harmonics = np.arange(2, 45)
    bins = np.rint(harmonics * 100.0 * 30000 / 44100).astype(int)
    measured = np.abs(spectra[0][bins] / spectra[1][bins])
    exact = bins * 44100 / 30000
    expected = np.abs(A.transfer_function(exact) / I.transfer_function(exact))
    ratio = measured / expected
    assert ratio / np.median(ratio) == pytest.approx(np.ones(ratio.size), abs=0.1)
    assert np.ptp(np.log(expected)) > 3.0


def test_responses_are_interpolated_well() -> None:
    """Up to where they fade out, against the transfer function itself."""
    frequency = np.fft.rfftfreq(16384, 1.0 / 44100.0)
    for name in TUBE_CONSTANTS:
        response = _responses(I.lengths[None, :], I.areas[None, :], TUBE_CONSTANTS[name], 44100, 16384)[0]
        below = (frequency > 4.0) & (frequency < 18000.0)
        expected = I.transfer_function(frequency[below], constants=name)
        assert np.abs(response[below] / expected - 1.0).max() < 5e-5
        assert abs(response[-1]) == 0.0


def test_tract_that_stands_still_is_one_filter() -> None:
    """The frames' windows add up to 1; what is left are responses cut off after 100 ms or more."""
    still, moving = synthesize(I, 120.0, 0.3), synthesize([I, I], 120.0, 0.3, times=[0.1, 0.2])
    assert np.abs(still.samples - moving.samples).max() < 5e-4
    assert not np.array_equal(still.samples, moving.samples)


def movement(hop: float, monkeypatch: pytest.MonkeyPatch) -> NDArray[np.float64]:
    monkeypatch.setattr(synthesis, "HOP", hop)
    return synthesize([A, I], 110.0, 0.3, times=[0.1, 0.2]).samples


def test_movement_begins_and_ends_as_its_tracts(monkeypatch: pytest.MonkeyPatch) -> None:
    samples = movement(0.002, monkeypatch)
    for tract, part in ((A, slice(2000, 4000)), (I, slice(9500, 11500))):
        alone = synthesize(tract, 110.0, 0.3).samples[part]
        correlation = np.corrcoef(alone, samples[part])[0, 1]
        assert correlation > 0.995


def test_movement_has_no_clicks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above 8 kHz, where vowels are weak and clicks are not, the movement is no louder than its ends."""

    def hiss(samples: NDArray[np.float64]) -> NDArray[np.float64]:
        spectrum = np.fft.rfft(samples)
        spectrum[: int(8000 * samples.size / 44100)] = 0.0
        high = np.fft.irfft(spectrum, samples.size)
        return np.array([np.abs(high[i : i + 441]).max() for i in range(0, samples.size - 441, 441)])

    moving = movement(0.002, monkeypatch)
    ends = [synthesize(tract, 110.0, 0.3).samples for tract in (A, I)]
    assert hiss(moving)[5:-8].max() < 1.5 * max(hiss(end)[5:-8].max() for end in ends)
    broken = moving.copy()
    broken[6600:] += 0.04
    assert hiss(broken)[5:-8].max() > 1.5 * max(hiss(end)[5:-8].max() for end in ends)


def test_movement_hardly_depends_on_its_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames of 1 and 2 ms. F2 moves by 7 Hz/ms and rings for about 10 ms, by then out of phase between two frames."""
    fine, coarse = (movement(hop, monkeypatch) for hop in (0.001, 0.002))
    assert 0.001 < np.sqrt(np.mean((fine - coarse) ** 2) / np.mean(fine**2)) < 0.1


def test_seed_gives_the_same_sound() -> None:
    options: dict[str, Any] = {"jitter": 0.01, "aspiration": 0.02}
    one, two = (synthesize(A, 120.0, 0.2, seed=7, **options) for _ in range(2))
    other = synthesize(A, 120.0, 0.2, seed=8, **options)
    assert one.samples.tobytes() == two.samples.tobytes()
    assert np.abs(one.samples - other.samples).max() > 0.01


def test_aspiration_is_as_loud_as_asked() -> None:
    """Noise fills the gaps between harmonics."""
    clean, noisy = synthesize(A, 100.0, 0.5), synthesize(A, 100.0, 0.5, aspiration=0.1, seed=1)
    window = np.hanning(13230)
    levels = [np.abs(np.fft.rfft(s.samples[4410:17640] * window)) for s in (clean, noisy)]
    between = np.arange(2, 40) * 30 + 15
    assert np.median(levels[1][between]) > 30.0 * np.median(levels[0][between])


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
def test_response_is_followed_until_it_is_gone(name: str) -> None:
    seconds = _ring([A, I], TUBE_CONSTANTS[name])
    narrowest = min(tract.formants(4, constants=name).bandwidths.min() for tract in (A, I))
    assert np.exp(-np.pi * narrowest * seconds) < 1.1e-6


@pytest.mark.parametrize("name", ["a", "u"])
def test_sound_without_losses_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="rings for more than 5 s: add losses"):
        synthesize(TWO_TUBES[name], constants=TUBE_CONSTANTS["badin"].lossless())


@pytest.mark.parametrize(
    ("area", "options", "message"),
    [
        (None, {}, "area must be an AreaFunction"),
        ([], {}, "area must be an AreaFunction"),
        ([A, 3.0], {"times": [0, 1]}, "area must be an AreaFunction"),
        ([A, I], {}, "2 area functions need 2 times"),
        ([A, I], {"times": [0.2, 0.1]}, "2 rising numbers"),
        ([A, I], {"times": [0.1]}, "2 rising numbers"),
        (A, {"times": [0.1]}, "only one was given"),
        ([A, TWO_TUBES["a"]], {"times": [0, 1]}, r"one number of sections, got \[2, 17\]"),
        (A, {"duration": 0.0}, "duration"),
        (A, {"duration": 1000.0}, "duration must be from 0.02 to 60 s"),
        (A, {"f0": 0.0}, "f0 must be from 20 to 2000 Hz, got 0.0 at 0 s"),
        (A, {"f0": [120.0, np.nan]}, "f0 at 0.5 s must be finite"),
        (A, {"f0": [120.0]}, "at least two numbers"),
        (A, {"f0": "high"}, "f0 must be Hz"),
        (A, {"f0": [(0.2, 100.0), (0.1, 120.0)]}, "times in f0 must be finite and rise"),
        (A, {"f0": lambda time: -time}, "f0 must be from 20 to 2000 Hz"),
        (A, {"sampling_rate": 44100.5}, "sampling_rate"),
        (A, {"onset": -0.1}, "onset"),
        (A, {"jitter": 0.01}, "give a seed"),
        (A, {"aspiration": 0.1}, "give a seed"),
        (A, {"jitter": 0.5, "seed": 1}, "jitter is a part of the period"),
        (A, {"jitter": 0.01, "seed": -1}, "seed must be a whole number"),
        (A, {"source": "noise"}, "source must be"),
        (A, {"constants": "air"}, "constants must be one of"),
    ],
)
def test_bad_input_is_refused(area: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        synthesize(area, **options)
