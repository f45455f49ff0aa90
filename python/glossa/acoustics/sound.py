"""A sound: samples and their rate, to listen to or to write."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from glossa.checks import one_of, whole_number
from glossa.errors import InputError

FORMATS = ("int16", "float32")
RATES = (8000, 192000)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Sound:
    """One channel of sound.

    Attributes:
        samples: between -1 and 1, (n,); read-only copy.
        sampling_rate: Hz.

    Raises:
        InputError: no samples, samples that are not finite or beyond ±1, or a rate out of range.
    """

    samples: NDArray[np.float64]
    sampling_rate: int

    def __init__(self, samples: ArrayLike, sampling_rate: int) -> None:
        checked = np.array(samples, dtype=np.float64)
        if checked.ndim != 1 or not checked.size:
            raise InputError(f"samples must be one row that is not empty, got shape {checked.shape}")
        if not np.isfinite(checked).all() or np.abs(checked).max() > 1.0:
            raise InputError("samples must be finite and between -1 and 1")
        checked.flags.writeable = False
        object.__setattr__(self, "samples", checked)
        object.__setattr__(self, "sampling_rate", whole_number(sampling_rate, "sampling_rate (Hz)", *RATES))

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.samples.size / self.sampling_rate

    @property
    def times(self) -> NDArray[np.float64]:
        """Time of each sample, s."""
        return np.arange(self.samples.size) / self.sampling_rate

    def save(self, path: str | Path, *, sample_format: str = "int16") -> None:
        """Writes a WAV file.

        Args:
            path: where to.
            sample_format: ``"int16"`` or ``"float32"``.

        Raises:
            InputError: the file cannot be written, or an unknown format.
        """
        from scipy.io import wavfile

        if one_of(sample_format, FORMATS, "sample_format") == "int16":
            data: NDArray[Any] = np.rint(self.samples * 32767.0).astype(np.int16)
        else:
            data = self.samples.astype(np.float32)
        try:
            wavfile.write(str(path), self.sampling_rate, data)
        except OSError as error:
            raise InputError(f"sound file {str(path)!r} cannot be written: {error}") from error

    def audio(self) -> Any:
        """A player for notebooks, ``IPython.display.Audio``.

        Raises:
            InputError: IPython is not installed.
        """
        try:
            from IPython.display import Audio
        except ImportError as error:
            raise InputError(
                "playing needs IPython: run in a notebook, or write the sound with .save('a.wav')"
            ) from error
        player: Any = Audio
        return player(self.samples, rate=self.sampling_rate, normalize=False)

    def _repr_html_(self) -> str:
        return str(self.audio()._repr_html_())

    def __repr__(self) -> str:
        return f"Sound({self.duration:.3f} s, {self.sampling_rate} Hz)"
