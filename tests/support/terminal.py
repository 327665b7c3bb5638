"""A real terminal: commands run in a pseudo-terminal, and what its screen shows at the end."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pexpect
import pyte
from processes import COMMAND

_ESCAPE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|[@-_])")


@dataclass(frozen=True)
class Session:
    """What a command has written to its terminal.

    Attributes
    ----------
    code : int
        Exit code.
    raw : str
        All that was written, escape sequences included.
    lines : list of str
        What is still to be seen at the end, the scrolled part included, without empty lines at the end.
    cursor_hidden : bool
        Whether it left the terminal without a cursor.
    """

    code: int
    raw: str
    lines: list[str]
    cursor_hidden: bool

    @property
    def text(self) -> str:
        """All that was written, without the escape sequences."""
        return _ESCAPE.sub("", self.raw)


def run_in_terminal(
    *arguments: str | Path,
    columns: int = 80,
    rows: int = 24,
    command: Sequence[str] = COMMAND,
    **variables: str,
) -> Session:
    """Run a command in a pseudo-terminal to its end."""
    child = spawn(*arguments, columns=columns, rows=rows, command=command, **variables)
    child.expect(pexpect.EOF)
    return ended(child, child.before, columns, rows)


def spawn(
    *arguments: str | Path,
    columns: int = 80,
    rows: int = 24,
    command: Sequence[str] = COMMAND,
    **variables: str,
) -> pexpect.spawn:
    """Start a command in a pseudo-terminal."""
    kept = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "COLUMNS", "LINES")}
    return pexpect.spawn(
        command[0],
        [*command[1:], *map(str, arguments)],
        env={**kept, "TERM": "xterm-256color", **variables},
        dimensions=(rows, columns),
        encoding="utf-8",
        timeout=120,
    )


def ended(child: pexpect.spawn, raw: str, columns: int = 80, rows: int = 24) -> Session:
    """Return what a command that has closed its terminal has left on it."""
    child.close()
    screen = pyte.HistoryScreen(columns, rows, history=10_000)
    pyte.Stream(screen).feed(raw)
    scrolled = ["".join(line[x].data for x in range(columns)) for line in screen.history.top]
    lines = [line.rstrip() for line in [*scrolled, *screen.display]]
    while lines and not lines[-1]:
        lines.pop()
    return Session(child.exitstatus, raw, lines, screen.cursor.hidden)
