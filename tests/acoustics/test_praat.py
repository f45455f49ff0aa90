"""The program Praat (Boersma & Weenink; Debian package ``praat``), run beside ours: same spectra, same vowels."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.acoustics.tracts import rough, vowels

from glossa import TUBE_CONSTANTS, AreaFunction, synthesize

PROGRAM = shutil.which("praat")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="the program praat is not installed")

SPECTRUM = """form Spectrum of a vocal tract
  sentence tract
  sentence table
endform
Read from file: tract$
To Spectrum: 8193, 8192, 0, "yes", "yes"
To Matrix
Save as headerless spreadsheet file: table$
"""

MEASURE = """form Formants of a sound
  sentence sound
  real ceiling
endform
Read from file: sound$
To Formant (burg): 0, 5, ceiling, 0.025, 50
for i to 3
  value = Get quantile: i, 0.15, 0.35, "hertz", 0.5
  appendInfo: fixed$ (value, 3), " "
endfor
"""


def praat(folder: Path, script: str, *arguments: object) -> str:
    path = folder / "script.praat"
    path.write_text(script, encoding="utf-8")
    command = [str(PROGRAM), "--run", str(path), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def write_tract(path: Path, areas: NDArray[np.float64], section: float) -> None:
    """Praat's text format of a VocalTract."""
    rows = [f"        z [1] [{i}] = {area!r}" for i, area in enumerate(areas.tolist(), 1)]
    head = [
        'File type = "ooTextFile"',
        'Object class = "VocalTract"',
        "",
        "xmin = 0",
        f"xmax = {areas.size * section!r}",
        f"nx = {areas.size}",
        f"dx = {section!r}",
        f"x1 = {section / 2!r}",
        "ymin = 1",
        "ymax = 1",
        "ny = 1",
        "dy = 1",
        "y1 = 1",
        "z [] []:",
        "    z [1]:",
    ]
    path.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")


@pytest.mark.parametrize("seed", range(4))
def test_spectra_of_random_tracts_are_the_same(tmp_path: Path, seed: int) -> None:
    """Praat's spectrum is the complex conjugate of ours times 0.02, at 1e-4 Hz above each whole number of Hz."""
    areas = rough(20 + seed, 1, 32 + 3 * seed, least=2e-5)[1][0]
    write_tract(tmp_path / "t.VocalTract", areas, 0.005)
    praat(tmp_path, SPECTRUM, tmp_path / "t.VocalTract", tmp_path / "t.txt")
    real, imaginary = np.loadtxt(tmp_path / "t.txt")
    frequency = np.arange(real.size) + 1e-4
    tract = AreaFunction(np.full(areas.size, 0.005), areas)
    ours = tract.transfer_function(frequency[1:], constants="praat")
    theirs = (real - 1j * imaginary)[1:] / 0.02
    assert np.abs(ours / theirs - 1.0).max() < 1e-6
    level = np.log(np.hypot(real, imaginary))
    tops = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:]))[:4] + 1
    before, here, after = level[tops - 1], level[tops], level[tops + 1]
    peaks = frequency[tops] + 0.5 * (before - after) / (before - 2.0 * here + after)
    assert np.abs(tract.formants(4, constants="praat", method="peaks").frequencies - peaks).max() < 0.05


@pytest.mark.parametrize("f0", [100.0, 120.0, (130.0, 105.0)], ids=str)
@pytest.mark.parametrize("vowel", ["a", "i", "u", "e", "uniform"])
def test_vowels_are_measured_back(tmp_path: Path, vowel: str, f0: float | tuple[float, float]) -> None:
    """Burg's method with five formants up to their mean spacing; harmonics 100 Hz apart leave F1 uncertain."""
    tract = (vowels() | {"uniform": AreaFunction.uniform(0.17, 3e-4)})[vowel]
    synthesize(tract, f0, 0.5).save(tmp_path / "v.wav")
    ceiling = 5.0 * TUBE_CONSTANTS["badin"].sound_speed / (2.0 * tract.length)
    measured = np.array(praat(tmp_path, MEASURE, tmp_path / "v.wav", ceiling).split(), dtype=float)
    ratio = measured / tract.formants(3).frequencies
    assert abs(ratio[0] - 1.0) < 0.15
    assert np.abs(ratio[1:] - 1.0).max() < 0.05
