"""The command line: ``glossa …``. Exit codes: 0 done, 1 a solve failed, 2 wrong input, 130 interrupted."""

from __future__ import annotations

import io
import logging
import sys
from collections.abc import Sequence

import typer

from glossa.cli import output
from glossa.cli.commands import app
from glossa.cli.options import with_picture_names

_USAGE_FAULT: type[Exception] = typer.BadParameter.__mro__[1]
"""What typer raises for wrong options; its own module differs between versions of typer."""


class _Warnings(logging.Handler):
    """Warnings about the anatomy, one line each on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one."""
        output.say(f"warning: {record.getMessage()}")


_WARNINGS = _Warnings(logging.WARNING)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Args:
        arguments: without the program's name; None takes those of the process.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # ə where there is no UTF-8; JSON stays valid
    logging.getLogger("glossa").addHandler(logging.NullHandler())
    logging.getLogger("glossa.anatomy").addHandler(_WARNINGS)
    given = with_picture_names(sys.argv[1:] if arguments is None else arguments)
    try:
        outcome = app(given, prog_name="glossa", standalone_mode=False)
    except _USAGE_FAULT as fault:
        message = fault.format_message() if hasattr(fault, "format_message") else str(fault)
        context = getattr(fault, "ctx", None)
        command = context.command_path if context is not None else "glossa"
        sys.stderr.write(f"glossa: {message} ({command} --help explains)\n")
        return 2
    except (typer.Abort, KeyboardInterrupt):
        sys.stderr.write("glossa: interrupted\n")
        return 130
    return outcome if isinstance(outcome, int) else 0


__all__ = ["app", "main"]
