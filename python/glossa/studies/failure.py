"""Why a run of a study has no result."""

from __future__ import annotations

from glossa.errors import SolveError


def reason_of(error: SolveError) -> str:
    """The message without what only the exception holds (".posture is the last good state ...")."""
    return str(error).split("; .", 1)[0]
