"""The machine on which a study of times has run."""

from __future__ import annotations

import os
import platform
from pathlib import Path

import numpy as np

from glossa import _core


def machine() -> dict[str, str | int | float]:
    """Attributes of a Dataset that holds times: processor, cores, kernels, system, versions, threads of BLAS, load.

    ``load`` is the number of processes that ran in the last five minutes, on the mean; more of them than cores make
    times by the clock longer than they need be. NaN where the system does not tell.
    """
    return {
        "processor": processor(),
        "cores": os.cpu_count() or 1,
        "kernel": _core.kernel_name(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python_version": platform.python_version(),
        "numpy_version": np.__version__,
        "glossa_version": _core.__version__,
        "load": round(os.getloadavg()[1], 2) if hasattr(os, "getloadavg") else float("nan"),
        "omp_num_threads": os.environ.get("OMP_NUM_THREADS", "not set"),
    }


def processor() -> str:
    """Model name of the processor, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"
