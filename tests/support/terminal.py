"""Run commands in a pseudo-terminal, and find out what its screen shows at the end."""

import json
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pexpect
import pyte
from processes import COMMAND

_ESCAPE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|[@-_])")
_ERASE = "\x1b[J"
_LEFT_STANDING = re.compile(r"\x1b\[J[^\r\x1b]+\r(?!\n|\r\x1b\[J)")
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
_MODE = re.compile(r"\x1b\[\?([0-9;]+)([hl])")
_ALTERNATE = re.compile(r"\x1b\[\?1049h.*?\x1b\[\?1049l", re.DOTALL)
_ON_AT_FIRST = {"25", "7"}
"""Initial modes of every terminal: visible cursor, wrapped lines."""


@dataclass(frozen=True)
class Session:
    """The output of a command in its terminal.

    Attributes
    ----------
    code : int or None
        Exit code; None if a signal ended it.
    written : tuple of (str, int)
        All output in parts, including escape sequences, each with the width of its window in columns.
    """

    code: int | None
    written: tuple[tuple[str, int], ...]

    @property
    def raw(self) -> str:
        """All output, including escape sequences."""
        return "".join(raw for raw, _ in self.written)

    @cached_property
    def lines(self) -> list[str]:
        """The final lines of a screen that is high enough for all of them, without empty lines at the end."""
        parts = [(_ALTERNATE.sub("", raw), columns) for raw, columns in self.written]
        # Each bar is erased cell by cell to the end of the screen, so excess height takes seconds.
        high = 24 + sum(line_count(raw, columns) for raw, columns in parts)
        screen = pyte.Screen(parts[0][1], high)
        stream = pyte.Stream(screen)
        for raw, columns in parts:
            screen.resize(high, columns)
            stream.feed(raw)
        shown = [screen.buffer[y] for y in range(max([0, *screen.buffer]) + 1)]
        lines = ["".join(line[x].data for x in range(screen.columns)).rstrip() for line in shown]
        while lines and not lines[-1]:
            lines.pop()
        return lines

    @property
    def text(self) -> str:
        """All output without escape sequences."""
        return _ESCAPE.sub("", self.raw)

    @property
    def had_bar(self) -> bool:
        """Whether a progress line was ever shown."""
        return _ERASE in self.raw

    @property
    def erased(self) -> bool:
        """Whether each progress line was erased, however long, before any other output."""
        return not _LEFT_STANDING.search(_COLOUR.sub("", self.raw))

    @property
    def restored(self) -> bool:
        """Whether cursor, screen, mouse and keyboard were restored at the end."""
        last = dict(_MODE.findall(self.raw))
        modes = all((state == "h") == (mode in _ON_AT_FIRST) for mode, state in last.items())
        return modes and self.raw.count("\x1b[>") == self.raw.count("\x1b[<u")

    @property
    def plain(self) -> bool:
        """Whether the only escape sequences colour the progress line, and erase it."""
        lines = re.sub(r"\x1b\[J[^\r]*\r", lambda line: _COLOUR.sub("", line[0]), self.raw)
        return "\x1b" not in lines.replace(_ERASE, "")


def line_count(raw: str, columns: int) -> int:
    """Return an upper bound on the number of lines that a text takes."""
    return sum(1 + sum(len(part) // columns for part in line.split("\r")) for line in raw.split("\n"))


def run_in_terminal(
    *arguments: str | Path, columns: int = 80, command: Sequence[str] = COMMAND, **variables: str
) -> Session:
    """Run a command in a pseudo-terminal until it ends."""
    child = spawn(*arguments, columns=columns, rows=24, command=command, **variables)
    child.expect(pexpect.EOF)
    return ended(child, (child.before, columns))


def spawn(
    *arguments: str | Path,
    columns: int = 80,
    rows: int = 24,
    command: Sequence[str] = COMMAND,
    **variables: str,
) -> pexpect.spawn:
    """Start a command in a pseudo-terminal; empty variables are unset."""
    kept = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "COLUMNS", "LINES")}
    wanted = {**kept, "TERM": "xterm-256color", **variables}
    return pexpect.spawn(
        command[0],
        [*command[1:], *map(str, arguments)],
        env={name: value for name, value in wanted.items() if value},
        dimensions=(rows, columns),
        encoding="utf-8",
        timeout=120,
        maxread=1 << 16,
    )


def ended(child: pexpect.spawn, *written: tuple[str, int]) -> Session:
    """Return the session of a command that has closed its terminal."""
    child.wait()  # it may still be exiting, and `close` has little patience
    child.close()
    return Session(child.exitstatus, written)


_SEVERAL = """
import fcntl, json, os, struct, sys, termios
from orbitdb.filling import fill
from orbitdb import progress
from orbitdb.cli.main import execute
progress.PATIENCE = 0.0
for name in fill.METHODS:
    fill.METHODS[name] = fill.Method(fill.METHODS[name].solve, 64)
for columns, to, arguments in json.loads(sys.argv[1]):
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
    kept = [(os.dup(number), number) for number in (1, 2)]
    for number, path in zip((1, 2), to):
        if path:
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), number)
    code = execute(arguments)
    sys.stdout.flush()
    for copy, number in kept:
        os.dup2(copy, number)
        os.close(copy)
    print(end=f"\\x1e{code}\\x1e", flush=True)
"""


@dataclass(frozen=True)
class Run:
    """A command, and where its output goes.

    Attributes
    ----------
    arguments : sequence of str
    columns : int
        Width of the window.
    out, err : Path or None
        Files for stdout and stderr instead of the terminal.
    """

    arguments: Sequence[str]
    columns: int = 80
    out: Path | None = None
    err: Path | None = None


def run_several_in_terminal(runs: Sequence[Run], **variables: str) -> list[Session]:
    """Run commands in turn in one process in a pseudo-terminal.

    Periods are cut into small blocks, and progress lines appear at once.
    """
    asked = [
        [run.columns, [path and str(path) for path in (run.out, run.err)], list(run.arguments)]
        for run in runs
    ]
    several = [sys.executable, "-P", "-c", _SEVERAL]
    child = spawn(json.dumps(asked), columns=80, rows=24, command=several, **variables)
    child.expect(pexpect.EOF)
    assert ended(child).code == 0, child.before
    parts = child.before.split("\x1e")[:-1]
    return [
        Session(int(code), ((raw, run.columns),))
        for run, raw, code in zip(runs, parts[::2], parts[1::2], strict=True)
    ]
