"""The progress line of a command."""

import os
import stat
import sys
from contextlib import AbstractContextManager, nullcontext
from typing import TextIO

from orbitdb.progress import Tell, nobody, shown


def progress(
    text: str, to_stdout: bool = False, expected: float | None = None
) -> AbstractContextManager[Tell]:
    """Show the progress of long work on a terminal, and nothing elsewhere (`orbitdb.progress.shown`).

    No line is shown while rows go to stdout (`to_stdout`), if stdout is a terminal or a pipe.
    """
    watched = sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"  # it must erase lines
    if not watched or (to_stdout and _seen(sys.stdout)):
        return nullcontext(nobody)
    return shown(text, expected)


def _seen(stream: TextIO) -> bool:
    """Tell whether output to a stream may be visible at once, because it is a terminal or a pipe."""
    if stream.isatty():
        return True
    try:
        return stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode)
    except (OSError, ValueError):  # not a file
        return False
