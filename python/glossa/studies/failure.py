"""Why a run of a study has no result."""

from __future__ import annotations


def reason_of(error: BaseException) -> str:
    """The message without what only Python code can reach in the exception (".posture is the last good state ...")."""
    return str(error).split("; .", 1)[0]
