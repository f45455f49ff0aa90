"""Settings and speakers that tests share."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))  # helpers are imported as tests.blocks, however pytest was started

from glossa import Speaker  # noqa: E402

PB_FOLDER = ROOT.parent / "shared" / "reference" / "pb"

os.environ.setdefault("MPLBACKEND", "Agg")

settings.register_profile("fixed", derandomize=True, deadline=None, database=None, print_blob=True)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def reference() -> Speaker:
    return Speaker.reference()


@pytest.fixture(scope="session")
def pb() -> Speaker:
    if not PB_FOLDER.is_dir():
        pytest.skip(f"PB data not found at {PB_FOLDER}")
    return Speaker.load(PB_FOLDER)
