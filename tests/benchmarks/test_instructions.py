"""Instructions that the kernels take: `make bench` prints them, and they must not grow by a third.

Counted by ``perf stat -e instructions:u`` where processor and system let it. Virtual machines often do not: there
valgrind counts the same if ``GLOSSA_LONG=1`` asks for it, in some minutes.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import glossa
from glossa import _core

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]

REPEATS = {"residual": 400, "assembly": 200, "factorisation": 20, "equilibrium": 1}

MILLIONS = {"residual": 1.51, "assembly": 3.94}
"""Millions of instructions of one call with kernels "avx2", GCC 12 and -O3, built-in speaker, mirrored. To renew them,
copy what `make bench` prints. Factorisations are the work of another library, which differs between processors."""

SLACK = 1.3


def perf(command: list[str], report: Path) -> float | None:
    """User instructions of a command; None where they cannot be counted."""
    if shutil.which("perf") is None:
        return None
    counter = ["perf", "stat", "-x", ";", "-e", "instructions:u", "-o", str(report)]
    done = subprocess.run([*counter, *command], cwd=ROOT, env=environment(), capture_output=True, check=False)
    if done.returncode or not report.exists():
        return None
    found = re.search(r"^(\d+);[^;]*;instructions:u", report.read_text(), re.MULTILINE)
    return float(found[1]) if found else None


def valgrind(command: list[str], report: Path) -> float | None:
    if shutil.which("valgrind") is None or not os.environ.get("GLOSSA_LONG"):
        return None
    files = [f"--log-file={report}", "--cachegrind-out-file=/dev/null"]
    counter = ["valgrind", "--tool=cachegrind", "--cache-sim=no", *files]
    subprocess.run([*counter, *command], cwd=ROOT, env=environment(), capture_output=True, check=True)
    found = re.search(r"I\s+refs:\s+([\d,]+)", report.read_text())
    return float(found[1].replace(",", "")) if found else None


def environment() -> dict[str, str]:
    """One thread, the package under test, and hashes that do not change from run to run."""
    package = str(Path(glossa.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": package, "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}


def counted(job: str, repeats: int, folder: Path) -> float:
    command = [sys.executable, "-m", "tests.benchmarks.counted_job", job, str(repeats)]
    report = folder / "counter.txt"
    found = perf(command, report) or valgrind(command, report)
    if found is None:
        pytest.skip("no counter of instructions here: neither perf nor, with GLOSSA_LONG=1, valgrind")
    return found


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> float:
    """Instructions until the first call: imports, speaker, scene."""
    return counted("residual", 0, tmp_path_factory.mktemp("start"))


@pytest.mark.parametrize("job", REPEATS)
def test_instructions(start: float, tmp_path: Path, job: str) -> None:
    each = (counted(job, REPEATS[job], tmp_path) - start) / REPEATS[job] / 1e6
    print(f"\n{job}: {each:.2f} million instructions, kernels {_core.kernel_name()}")
    assert each > 0.0
    if _core.kernel_name() == "avx2" and job in MILLIONS:
        assert each < SLACK * MILLIONS[job]
