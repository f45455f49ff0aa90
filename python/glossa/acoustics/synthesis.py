"""Vowels to listen to: a voice source filtered by the transfer function of the tract.

The source is the derivative of the glottal flow, so that the filtered signal is the pressure in front of the lips but
for a constant. A tract that changes is filtered in frames of the source that fade into each other (Hann windows, their
sum is 1), each with the response of its own moment, rung out in full: a sample of the source is answered by a mean of
the neighbouring responses, so the sound changes as smoothly as the areas; where they stand still the result is that of
one filter.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.fft import irfft, rfft, rfftfreq
from numpy.typing import ArrayLike, NDArray

from glossa.acoustics.area_function import AreaFunction
from glossa.acoustics.constants import TubeConstants, tube_constants
from glossa.acoustics.formants import formants
from glossa.acoustics.sound import RATES, Sound
from glossa.acoustics.source import Source, voice_source
from glossa.acoustics.spectrum import STILL
from glossa.acoustics.transmission_line import flow_ratio
from glossa.checks import finite_number, not_negative_number, positive_number, real_array, whole_number
from glossa.errors import InputError

Real = NDArray[np.float64]
Contour = float | ArrayLike | Callable[[float], float]

PEAK = 0.9
OVERSAMPLING = 4
HOP = 0.002
"""s between frames of a changing tract."""
LEAD = 0.005
"""s by which a response, limited in band, begins before its cause."""
LONGEST = 60.0
F0_RANGE = (20.0, 2000.0)
RING = (0.1, 5.0)
"""s for which a response is followed: until its narrowest resonance has decayed by 120 dB, within these limits."""


def synthesize(
    area: AreaFunction | Sequence[AreaFunction],
    f0: Contour = 120.0,
    duration: float = 0.5,
    *,
    times: ArrayLike | None = None,
    constants: str | TubeConstants = "badin",
    sampling_rate: int = 44100,
    source: str | Source = "lf",
    onset: float = 0.04,
    offset: float = 0.08,
    jitter: float = 0.0,
    aspiration: float = 0.0,
    seed: int | None = None,
) -> Sound:
    """A vowel, or the sound of a tract that changes.

    Args:
        area: one area function, or several of the same number of sections with their ``times``.
        f0: Hz: a number; values spread evenly over the duration; pairs (time in s, Hz); or a function of time.
        duration: s.
        times: s, rising, one for each area function; between them areas and lengths are interpolated (logarithms of
            areas), before and after them the first and last hold.
        constants: name of a set in :data:`glossa.acoustics.TUBE_CONSTANTS`, or the set.
        sampling_rate: Hz.
        source: ``"lf"``, ``"rosenberg"``, or an object ``LF(...)`` or ``Rosenberg(...)``.
        onset: s in which the voice sets in, from soft to full.
        offset: s in which it dies away.
        jitter: standard deviation of the period as a part of it; needs a seed.
        aspiration: level of noise at the glottis relative to the voice (rms); needs a seed.
        seed: of the random numbers.

    Returns:
        Sound with a peak of 0.9.

    Raises:
        InputError: bad arguments; constants without losses, whose sound would never end.
    """
    chosen, shape = tube_constants(constants), voice_source(source)
    rate = whole_number(sampling_rate, "sampling_rate (Hz)", *RATES)
    length = positive_number(duration, "duration (s)")
    if not 0.02 <= length <= LONGEST:
        raise InputError(f"duration must be from 0.02 to {LONGEST:g} s, got {length:g}")
    fades = (not_negative_number(onset, "onset (s)"), not_negative_number(offset, "offset (s)"))
    random = _random(jitter, aspiration, seed)
    tracts, moments = _tracts(area, times)
    pulses = _pulses(f0, length, float(jitter), random)
    voice = _voice(shape, pulses, length, fades, rate)
    if aspiration:
        assert random is not None
        voice = voice + _breath(voice, float(aspiration), fades, rate, random)
    samples = _filtered(voice, rate, tracts, moments, chosen)[: round(length * rate)]
    fade = min(samples.size, max(1, round(0.01 * rate)))
    samples[-fade:] *= 0.5 * (1.0 + np.cos(np.pi * (np.arange(fade) + 1.0) / fade))
    peak = np.abs(samples).max()
    if not peak > 0.0:
        raise InputError(f"onset {onset!r} s and offset {offset!r} s leave nothing of a sound of {length:g} s")
    return Sound(PEAK * samples / peak, rate)


def _random(jitter: float, aspiration: float, seed: int | None) -> np.random.Generator | None:
    not_negative_number(aspiration, "aspiration")
    if not_negative_number(jitter, "jitter") > 0.1:
        raise InputError(f"jitter is a part of the period, at most 0.1, got {jitter!r}")
    if not jitter and not aspiration:
        return None
    if seed is None:
        raise InputError(
            "jitter and aspiration are random: give a seed, a whole number, so that the sound can be had again"
        )
    return np.random.default_rng(whole_number(seed, "seed", 0, 2**63 - 1))


def _tracts(area: Any, times: ArrayLike | None) -> tuple[list[AreaFunction], Real]:
    """The area functions and their times."""
    if isinstance(area, AreaFunction):
        if times is not None:
            raise InputError("times belong to several area functions; only one was given")
        return [area], np.zeros(1)
    tracts = list(area) if isinstance(area, Sequence) else []
    if not tracts or not all(isinstance(tract, AreaFunction) for tract in tracts):
        raise InputError(f"area must be an AreaFunction, or a sequence of them with times, got {type(area).__name__}")
    if times is None:
        raise InputError(f"{len(tracts)} area functions need {len(tracts)} times (s)")
    moments = real_array(times, "times must be numbers (s)")
    if moments.shape != (len(tracts),) or not np.isfinite(moments).all() or (np.diff(moments) <= 0.0).any():
        raise InputError(f"times must be {len(tracts)} rising numbers (s), one for each area function")
    counts = sorted({tract.areas.size for tract in tracts})
    if len(counts) > 1:
        raise InputError(f"area functions of a movement must have one number of sections, got {counts}")
    return tracts, moments


def _contour(f0: Any, duration: float) -> Callable[[float], float]:
    """f0 in Hz as a function of time."""
    if callable(f0):
        return lambda time: _hertz(f0(time), time)
    values = real_array(f0, "f0 must be Hz: a number, numbers, pairs (s, Hz) or a function of time")
    if values.ndim == 0:
        steady = _hertz(float(values), 0.0)
        return lambda _: steady
    if values.ndim == 1 and values.size >= 2:
        knots = np.linspace(0.0, duration, values.size)
    elif values.ndim == 2 and values.shape[1] == 2 and len(values):
        knots, values = values[:, 0], values[:, 1]
        if not np.isfinite(knots).all() or (np.diff(knots) <= 0.0).any():
            raise InputError("times in f0 must be finite and rise")
    else:
        raise InputError(
            f"f0 must be a number, at least two numbers, pairs (s, Hz) or a function, got shape {values.shape}"
        )
    for knot, value in zip(knots, values, strict=True):
        _hertz(float(value), float(knot))
    return lambda time: float(np.interp(time, knots, values))


def _hertz(value: Any, time: float) -> float:
    low, high = F0_RANGE
    if not low <= finite_number(value, f"f0 at {time:g} s") <= high:
        raise InputError(f"f0 must be from {low:g} to {high:g} Hz, got {value!r} at {time:g} s")
    return float(value)


def _pulses(f0: Contour, duration: float, jitter: float, random: np.random.Generator | None) -> Real:
    """Beginnings of the pulses, s, one more than there are pulses; each period is that of f0 at its middle."""
    contour = _contour(f0, duration)
    begins = [0.0]
    while begins[-1] < duration:
        period = 1.0 / contour(begins[-1])
        period = 1.0 / contour(min(begins[-1] + 0.5 * period, duration))
        if jitter and random is not None:
            period *= 1.0 + jitter * float(np.clip(random.standard_normal(), -3.0, 3.0))
        begins.append(begins[-1] + period)
    return np.array(begins)


def _loudness(time: Real | float, duration: float, fades: tuple[float, float]) -> Real:
    """Amplitude from 0 to 1: raised cosines at the beginning and at the end."""
    onset, offset = (max(fade, 1e-9) for fade in fades)
    rising = np.clip(np.asarray(time) / onset, 0.0, 1.0)
    falling = np.clip((duration - np.asarray(time)) / offset, 0.0, 1.0)
    result: Real = 0.25 * (1.0 - np.cos(np.pi * rising)) * (1.0 - np.cos(np.pi * falling))
    return result


def _voice(shape: Source, begins: Real, duration: float, fades: tuple[float, float], rate: int) -> Real:
    """Flow derivative; pulses are sampled finer and then limited in band, so that their corners do not alias."""
    fine = rate * OVERSAMPLING
    count = int(np.ceil(begins[-1] * rate)) + round(LEAD * rate)
    signal = np.zeros(count * OVERSAMPLING)
    for begin, end in itertools.pairwise(begins.tolist()):
        middle = 0.5 * (begin + end)
        level = float(_loudness(max(middle, 0.0), duration, fades))
        first, last = int(np.ceil(begin * fine)), int(np.ceil(end * fine))
        phase = (np.arange(first, last) / fine - begin) / (end - begin)
        signal[first:last] = level * shape.pulse(phase, 1.0 - level)
    limited = rfft(signal)[: count // 2 + 1] / OVERSAMPLING
    return np.asarray(irfft(limited, count)[: round(duration * rate)])


def _breath(voice: Real, level: float, fades: tuple[float, float], rate: int, random: np.random.Generator) -> Real:
    """Noise as loud as ``level`` times the voice, stronger where the voice is."""
    noise = random.standard_normal(voice.size)
    noise *= _loudness(np.arange(voice.size) / rate, voice.size / rate, fades)
    scale: float = np.sqrt(np.mean(voice**2) / np.mean(noise**2))
    return level * scale * noise


def _filtered(voice: Real, rate: int, tracts: list[AreaFunction], moments: Real, constants: TubeConstants) -> Real:
    """The voice through the tract, frame by frame; one frame where the tract stands still."""
    hop = round(HOP * rate)
    ring = round(_ring(tracts, constants) * rate)
    if len(tracts) == 1:
        lengths, areas = tracts[0].lengths[None, :], tracts[0].areas[None, :]
        size = _power_of_two(voice.size + ring)
        response = _responses(lengths, areas, constants, rate, size)
        return np.asarray(irfft(rfft(voice, size) * response[0], size)[: voice.size])
    frames = int(np.ceil(voice.size / hop)) + 1
    lengths, areas = _at_times(tracts, moments, np.arange(frames) * hop / rate)
    window = 0.5 - 0.5 * np.cos(np.pi * np.arange(2 * hop) / hop)
    padded = np.concatenate([np.zeros(hop), voice, np.zeros(2 * hop)])
    lead = round(LEAD * rate)
    size = _power_of_two(2 * hop + ring + lead)
    output = np.zeros(lead + padded.size + size)
    group = max(1, 2_000_000 // size)
    for start in range(0, frames, group):
        rows = range(start, min(start + group, frames))
        response = _responses(lengths[rows.start : rows.stop], areas[rows.start : rows.stop], constants, rate, size)
        pieces = np.stack([padded[row * hop : (row + 2) * hop] * window for row in rows])
        answered = np.roll(irfft(rfft(pieces, size, axis=1) * response, size, axis=1), lead, axis=1)
        for row, answer in zip(rows, answered, strict=True):
            output[row * hop : row * hop + size] += answer
    return output[lead + hop : lead + hop + voice.size]


def _power_of_two(size: int) -> int:
    return 1 << (size - 1).bit_length()


def _ring(tracts: list[AreaFunction], constants: TubeConstants) -> float:
    """Seconds until the narrowest resonance has decayed by 120 dB.

    Raises:
        InputError: it takes too long, as there are nearly no losses.
    """
    shortest, longest = RING
    poles = np.concatenate([tract.poles for tract in formants(tracts, 4, constants=constants)])
    if not poles.size:
        return longest
    narrowest = float(2.0 * poles.imag.min())
    wanted = float(np.log(1e6)) / (np.pi * max(narrowest, 1e-9))
    if wanted > longest:
        raise InputError(
            f"constants {constants.name!r} give a resonance of {max(narrowest, 0.0):.2g} Hz bandwidth, which rings for "
            f"more than {longest:g} s: add losses, a yielding wall or radiation"
        )
    return max(wanted, shortest)


def _at_times(tracts: list[AreaFunction], moments: Real, wanted: Real) -> tuple[Real, Real]:
    """Lengths and areas (frames, k) at the times wanted."""
    held = np.clip(wanted, moments[0], moments[-1])
    right = (
        np.clip(np.searchsorted(moments, held), 1, len(moments) - 1) if len(moments) > 1 else np.zeros(held.size, int)
    )
    left = np.maximum(right - 1, 0)
    part = np.zeros(held.size) if len(moments) == 1 else (held - moments[left]) / (moments[right] - moments[left])
    lengths = np.stack([tract.lengths for tract in tracts])
    areas = np.log(np.stack([tract.areas for tract in tracts]))
    weight = part[:, None]
    return (
        lengths[left] * (1.0 - weight) + lengths[right] * weight,
        np.exp(areas[left] * (1.0 - weight) + areas[right] * weight),
    )


def _responses(lengths: Real, areas: Real, constants: TubeConstants, rate: int, size: int) -> NDArray[np.complex128]:
    """1/D on the frequencies of a Fourier transform, (frames, size // 2 + 1).

    D varies with c/2L (about 1 kHz) and, below 200 Hz, with the wall: it is computed on a grid of 1, 4 and 20 Hz and
    interpolated by cubic splines. The highest 15 % fade out, as an edge at the Nyquist frequency would ring on and on.
    """
    from scipy.interpolate import CubicSpline

    top = 0.5 * rate
    grid = np.concatenate(
        [[STILL, 0.1, 0.5], np.arange(1.0, 40.0), np.arange(40.0, 300.0, 4.0), np.arange(300.0, top + 40.0, 20.0)]
    )
    omega = np.broadcast_to(2.0 * np.pi * grid + 0.0j, (len(areas), grid.size))
    ratio = flow_ratio(omega, lengths, areas, constants)
    wanted = np.maximum(rfftfreq(size, 1.0 / rate), STILL)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.clip((wanted / top - 0.85) / 0.15, 0.0, 1.0))
    result: NDArray[np.complex128] = fade / CubicSpline(grid, ratio, axis=1)(wanted)
    return result
