"""CPU time of a job."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable


def cpu_seconds(job: Callable[[], object], repeats: int = 9) -> float:
    """Median CPU time of a job."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        job()
        times.append(time.process_time() - begin)
    return statistics.median(times)
