"""The most memory that this process has held."""

from __future__ import annotations

import math
import sys
from pathlib import Path


def peak_memory() -> float:
    """Largest resident memory since the process began, B; NaN where the system does not tell.

    Linux counts what its parent held before it began, too, where ``getrusage`` is asked; /proc is not misled.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        lines = status.read_text(encoding="utf-8").splitlines()
        peaks = [float(line.split()[1]) * 1024.0 for line in lines if line.startswith("VmHWM:")]
        return peaks[0] if peaks else math.nan
    try:
        import resource
    except ImportError:
        return math.nan
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(largest if sys.platform == "darwin" else 1024 * largest)
