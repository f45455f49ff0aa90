"""Equilibria of the built-in speaker at one resolution, for a process of its own, whose memory can be told."""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import dataclass, field

from glossa import VOWELS, Scene, SolveError, Speaker


@dataclass(kw_only=True)
class FineMesh:
    """What a resolution takes, with every effect, mirrored.

    Attributes:
        hexahedra: of the whole tongue.
        making: CPU seconds for making speaker and scene.
        solves: by vowel: CPU seconds from rest, Newton iterations, factorisations; a reason where there is no solution.
        memory: largest resident memory of the process, bytes.
    """

    resolution: int
    hexahedra: int
    making: float
    solves: dict[str, tuple[float, int, int, str]] = field(default_factory=dict)
    memory: int = 0


def solve_vowels(resolution: int) -> FineMesh:
    """The four vowels from rest, mirrored, once each."""
    begin = time.process_time()
    speaker = Speaker.reference(resolution)
    scene = Scene(speaker, mirror=True)
    making = time.process_time() - begin
    result = FineMesh(resolution=resolution, hexahedra=len(speaker.hexahedra), making=making)
    for vowel, commands in VOWELS.items():
        begin, reason = time.process_time(), ""
        try:
            report = scene.equilibrate(commands).report
        except SolveError as error:
            report, reason = error.report, str(error)
        assert report is not None
        seconds = time.process_time() - begin
        result.solves[vowel] = (seconds, report.iterations, report.factorisations, reason)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    result.memory = peak if sys.platform == "darwin" else 1024 * peak
    return result
