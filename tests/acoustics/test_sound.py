from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import wavfile

from glossa import InputError, Sound

TONE = Sound(0.9 * np.sin(np.arange(800) * 0.1), 16000)


@pytest.mark.parametrize(("sample_format", "scale", "error"), [("int16", 32767.0, 0.5), ("float32", 1.0, 1e-7)])
def test_files_hold_the_samples(tmp_path: Path, sample_format: str, scale: float, error: float) -> None:
    TONE.save(tmp_path / "tone.wav", sample_format=sample_format)
    rate, data = wavfile.read(tmp_path / "tone.wav")
    assert rate == 16000
    assert data.dtype == sample_format
    assert np.abs(data - TONE.samples * scale).max() <= error


def test_measures() -> None:
    assert TONE.duration == 0.05
    assert TONE.times[1] == 1.0 / 16000
    assert repr(TONE) == "Sound(0.050 s, 16000 Hz)"
    with pytest.raises(ValueError, match="read-only"):
        TONE.samples[0] = 1.0


def test_notebooks_show_a_player() -> None:
    assert "<audio" in TONE._repr_html_()
    assert TONE.audio().data.startswith(b"RIFF")


def test_player_without_ipython(monkeypatch: pytest.MonkeyPatch) -> None:
    found = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name.startswith("IPython"):
            raise ImportError(name)
        return found(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match="playing needs IPython"):
        TONE.audio()


@pytest.mark.parametrize(
    ("samples", "rate", "message"),
    [
        ([], 16000, "not empty"),
        ([[0.0, 0.1]], 16000, r"got shape \(1, 2\)"),
        ([0.0, np.nan], 16000, "finite and between -1 and 1"),
        ([0.0, 1.1], 16000, "finite and between -1 and 1"),
        ([0.0, 0.1], 16, "sampling_rate"),
        ([0.0, 0.1], 16000.0, "sampling_rate"),
    ],
)
def test_bad_sounds_are_refused(samples: Any, rate: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Sound(samples, rate)


def test_bad_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"tone\.wav' cannot be written"):
        TONE.save(tmp_path / "nowhere" / "tone.wav")
    with pytest.raises(InputError, match="sample_format must be one of"):
        TONE.save(tmp_path / "tone.wav", sample_format="mp3")
