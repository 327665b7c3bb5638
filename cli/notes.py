"""Notes, questions and progress on stderr."""

import logging
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path

import typer

from orbitdb.cli.advice import completed
from orbitdb.errors import InputError
from orbitdb.progress import Tell, aside, nobody, shown
from orbitdb.text import format_float, joined, line

_quiet = False
"""Whether --quiet was given."""


def be_quiet(quiet: bool) -> None:
    """Leave out notes and progress from now on, or show them."""
    global _quiet
    _quiet = quiet


def is_quiet() -> bool:
    """Return whether --quiet was given, so that no work need be done for notes alone."""
    return _quiet


def note(message: str, *, always: bool = False) -> None:
    """Write a message as one line to stderr, if possible; with --quiet, only if it is to be seen `always`."""
    if _quiet and not always:
        return
    _noted.append(message)
    with aside(), suppress(OSError):
        print(line(completed(message)), file=sys.stderr)


_noted: list[str] = []
"""The notes of this command."""

_headings: list[Sequence[str]] = []
"""The columns of each table for people that this command has written."""

_on_a: list[tuple[float, str | None]] = []
"""Each a that this command has taken, with the note on it if it is a default."""


def takes_a(a: float, said: str | None = None) -> None:
    """Let `last_notes` name the a that a command takes; `said` is the note on a default."""
    _on_a.append((a, said))


def writes_table(columns: Sequence[str]) -> None:
    """Let `last_notes` know the columns of a table for people that a command writes."""
    _headings.append(columns)


@contextmanager
def last_notes() -> Iterator[None]:
    """Write which a was taken after the block of a command, unless it fails.

    The note on a default is written also with --quiet. Any other a is named only if a table for people has
    been written, and neither a column of it nor a note names the a.
    """
    for of_last in (_noted, _headings, _on_a):
        of_last.clear()
    try:
        yield
    except typer.Exit:
        raise
    except Exception:
        _on_a.clear()
        raise
    finally:
        for a, said in dict.fromkeys(_on_a):
            text = f"a = {format_float(a)}"
            in_notes = re.compile(rf"\b{re.escape(text)}(?!\.?\d)")
            named = any("a" in names for names in _headings) or any(map(in_notes.search, _noted))
            if said is not None:
                note(said, always=True)
            elif _headings and not named:
                note(text)


def notes(messages: Iterable[str]) -> None:
    """Write messages as notes; those that say the same of many values of a become one."""
    for message in joined(messages):
        note(message)


def not_shown(count: int, total: int, remedy: bool = True) -> str:
    """Return the end of a note on rows: how many of all are shown, and how to see them all; '' if all are."""
    if count >= total:
        return ""
    return f"; {count} shown{f', --limit {total} shows all' if remedy else ''}"


def confirm(deed: str, undone: str) -> None:
    """Ask on a terminal whether to do something, such as "delete 3 words"; end the command if not.

    Raises
    ------
    InputError
        If stdin is no terminal; --yes would answer.
    """
    if not sys.stdin.isatty():
        raise InputError(f"this would {deed}: confirm with --yes")
    if not typer.confirm(f"{deed[0].upper()}{deed[1:]}?", err=True):
        note(undone)
        raise typer.Exit(1)


class _Notes(logging.Handler):
    """Writes what the library logs as notes."""

    def emit(self, record: logging.LogRecord) -> None:
        note(record.getMessage())


def show_warnings() -> None:
    """Show as notes what the library logs, such as that it waits for another process."""
    logger = logging.getLogger("orbitdb")
    logger.handlers, logger.propagate = [_Notes(logging.WARNING)], False


def progress(
    text: str, to_stdout: bool = False, expected: float | None = None
) -> AbstractContextManager[Tell]:
    """Show the progress of long work on a terminal, and nothing elsewhere (`orbitdb.progress.shown`).

    No line is shown while rows go to stdout (`to_stdout`), unless stdout is a file.
    """
    watched = (
        not _quiet and sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"
    )  # it must erase lines
    if not watched or (to_stdout and not Path("/dev/stdout").is_file()):
        return nullcontext(nobody)
    return shown(text, expected)
