"""Run the examples of README.md and of the pages here, and compare them with what stands there.

    python docs/console.py            tells which examples differ from what comes out
    python docs/console.py --write    puts what comes out into the pages; --write FILE for one page

An example is a block ``console`` with lines that begin with ``$``, or a block ``python``, whose output
is the block ``text`` behind it. Those of a page run one after the other in a folder of their own, which
holds the catalogue of ``orbitdb fill --p 11`` unless the page begins with a fill. A comment before a
block says what is particular about it:

    <!-- not run: why -->    it is shown only
    <!-- slow -->            it is run where there is time
    <!-- varies -->          its numbers are times, or drawn at random: the words must agree

A ``text`` block is taken as output only directly behind a ``python`` block.
"""

import argparse
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
FIRST_FILL = "orbitdb fill --p 11"
"""What makes the catalogue that the pages ask."""

HOME = "/home/you"
"""Stands in the pages for the folder that the examples run in."""

_EXAMPLES = ("console", "python", "bash", "sh")
_FENCE = re.compile(r"```(\S*)")
_COMMENT = re.compile(r"<!-- (not run: .+|slow|varies) -->")
_SHELL = re.compile(r"[|<>&;`$*~#]")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
_TOKEN = re.compile(rf"{_NUMBER.pattern}|[^\s,]+")
_ASIDE = (
    (re.compile(r"\d[\d.e+-]* (?:s|ms|µs|minutes|hours|days)\b"), "TIME"),
    (re.compile(r"\d[\d.e+-]* (?:bytes|kB|MB|GB|TB)\b"), "SIZE"),
    (re.compile(r"\borbitdb \d+\.\d+\S*"), "orbitdb VERSION"),
)
_SMALL = 1e-9
"""Below lie residuals and error bounds, of which the last bits of the machine decide."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes
    ----------
    start, end : int
        Its lines without the fences are ``lines[start:end]`` of the page.
    """

    language: str
    start: int
    end: int
    mark: str

    def text(self, lines: list[str]) -> str:
        """Return what stands in it."""
        return "\n".join(lines[self.start : self.end])


@dataclass(frozen=True)
class Example:
    """A command or a piece of Python, and what the page says that comes out.

    Attributes
    ----------
    start, end : int
        The output as lines of the page.
    line : int
        Of the command, counted from 1.
    """

    language: str
    source: str
    shown: str
    start: int
    end: int
    line: int
    mark: str

    def holds(self, output: str) -> bool:
        """Tell whether the page shows this output, all that may vary aside."""
        return same(self.shown, output, numbers=self.mark != "varies")


def blocks(lines: list[str]) -> list[Block]:
    """Find the fenced blocks of a page, with the mark that stands before each."""
    found: list[Block] = []
    mark, n = "", 0
    while n < len(lines):
        if comment := _COMMENT.fullmatch(lines[n].strip()):
            mark = comment[1]
        elif fence := _FENCE.match(lines[n]):
            end = next(k for k in range(n + 1, len(lines)) if lines[k].rstrip() == "```")
            found.append(Block(fence[1], n + 1, end, mark))
            mark, n = "", end
        elif lines[n].strip():
            mark = ""
        n += 1
    return found


def examples(page: Path) -> list[Example]:
    """Return what is to be run of a page.

    Raises
    ------
    ValueError
        If an example can neither be run nor says why not.
    """
    lines = page.read_text(encoding="utf-8").splitlines()
    found: list[Example] = []
    parts = blocks(lines)
    for block, behind in zip_longest(parts, parts[1:]):
        if block.language not in _EXAMPLES or block.mark.startswith("not run"):
            continue
        if block.language == "python":
            found.append(_python(block, behind, lines))
        elif block.language == "console" and lines[block.start].startswith("$ "):
            found += _commands(block, lines)
        else:
            raise ValueError(f"{page.name}:{block.start}: mark this block as not run, and say why")
    return found


def _python(block: Block, behind: Block | None, lines: list[str]) -> Example:
    start = end = block.end
    if behind is not None and behind.language == "text" and not any(lines[block.end + 1 : behind.start - 1]):
        start, end = behind.start, behind.end
    shown = "\n".join(lines[start:end])
    return Example("python", block.text(lines), shown, start, end, block.start + 1, block.mark)


def _commands(block: Block, lines: list[str]) -> Iterator[Example]:
    starts = [n for n in range(block.start, block.end) if lines[n].startswith("$ ")]
    for start, end in zip(starts, [*starts[1:], block.end], strict=True):
        behind = start + 1
        while lines[behind - 1].endswith("\\"):
            behind += 1
        source = "\n".join([lines[start][2:], *lines[start + 1 : behind]])
        shown = "\n".join(lines[behind:end]).rstrip()
        yield Example("console", source, shown, behind, end, start + 1, block.mark)


def same(shown: str, output: str, numbers: bool = True) -> bool:
    """Tell whether two outputs agree: words exactly, numbers to their last digits or within their errors."""
    mine, other = _tokens(shown), _tokens(output)
    if len(mine) != len(other):
        return False
    for n, (one, two) in enumerate(zip(mine, other, strict=True)):
        if one == two:
            continue
        if not (_NUMBER.fullmatch(one) and _NUMBER.fullmatch(two)):
            return False
        if numbers and not _near(one, two, _error(mine, n) + _error(other, n)):
            return False
    return True


def _tokens(text: str) -> list[str]:
    for pattern, name in _ASIDE:
        text = pattern.sub(name, text)
    return _TOKEN.findall(text)


def _error(tokens: list[str], n: int) -> float:
    """Return the error that is given behind a number, or 0."""
    given = tokens[n + 1 : n + 3]
    return float(given[1]) if len(given) == 2 and given[0] == "+-" and _NUMBER.fullmatch(given[1]) else 0.0


def _near(one: str, two: str, error: float) -> bool:
    x, y = float(one), float(two)
    if not any(mark in one for mark in ".e"):
        return False
    if max(abs(x), abs(y)) < _SMALL:
        return True
    mantissa, _, power = one.partition("e")
    last = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    return abs(x - y) <= max(2.5 * last, 5e-15 * abs(x), 3 * error)


class Session:
    """Where the examples of one page run: a folder, and the names that its Python has defined."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.names: dict[str, Any] = {"__name__": "__main__"}

    def run(self, example: Example) -> str:
        """Run an example; return what a terminal shows of it."""
        if example.language == "python":
            output = self._here(lambda: exec(compile(example.source, "<page>", "exec"), self.names))
        else:
            output = self.command(example.source)
        lines = output.replace(str(self.folder), HOME).splitlines()
        return "\n".join(line.rstrip() for line in lines).rstrip()

    def command(self, line: str) -> str:
        """Run a line of the shell: in this process if it is nothing but a command of orbitdb."""
        from orbitdb.cli.main import _run

        line = line.replace("\\\n", " ")
        unquoted = re.sub(r"'[^']*'|\"[^\"$`]*\"", "", line)
        if line.startswith("orbitdb ") and not _SHELL.search(unquoted):
            words = shlex.split(line)[1:]
            return self._here(lambda: _run(words))
        where = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        result = subprocess.run(
            ["bash", "-c", line], cwd=self.folder, env={**os.environ, **_SETTING, **where}, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        return result.stdout

    def _here(self, work: Any) -> str:
        screen = io.StringIO()
        with _settings(_SETTING), chdir(self.folder), redirect_stdout(screen), redirect_stderr(screen):
            work()
        return screen.getvalue()


_SETTING = {"ORBITDB_DB": "orbits.db", "COLUMNS": "80", "PYTHONSAFEPATH": "1"}


@contextmanager
def _settings(values: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def begin(wanted: list[Example], folder: Path, catalogue: Path) -> Session:
    """Return a session in an empty folder, with a copy of the catalogue unless the page fills its own."""
    first = next((example.source for example in wanted if example.language == "console"), "")
    if not first.startswith("orbitdb fill"):
        shutil.copy(catalogue, folder / "orbits.db")
    return Session(folder)


def first_catalogue(folder: Path) -> Path:
    """Make the catalogue that pages without a fill of their own ask; return its path."""
    Session(folder).command(FIRST_FILL)
    return folder / "orbits.db"


def rewrite(page: Path, outputs: list[tuple[Example, str]]) -> None:
    """Put outputs in the place of those that do not hold."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for example, output in reversed(outputs):
        if example.holds(output):
            continue
        follows = example.language == "console" and lines[example.end].startswith("$ ")
        lines[example.start : example.end] = [*output.splitlines(), *([""] if follows else [])]
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> int:
    """Run all examples; return 1 if some differ and are not rewritten."""
    parser = argparse.ArgumentParser(description="Run the examples of the pages.")
    parser.add_argument("--write", action="store_true", help="put the real output into the pages")
    parser.add_argument("pages", nargs="*", type=Path, default=PAGES)
    given = parser.parse_args()
    differing = 0
    with tempfile.TemporaryDirectory() as temporary:
        top = Path(temporary).resolve()
        made = top / "first"
        made.mkdir()
        catalogue = first_catalogue(made)
        for page in given.pages:
            wanted = examples(page)
            folder = top / page.stem
            folder.mkdir()
            session = begin(wanted, folder, catalogue)
            outputs = [(example, session.run(example)) for example in wanted]
            for example, output in outputs:
                if not example.holds(output):
                    differing += 1
                    print(f"{page.name}:{example.line}: {example.source}\n{output}\n")
            if given.write:
                rewrite(page, outputs)
    print(f"{differing} examples differed" + (" and are rewritten" if given.write else ""))
    return int(bool(differing) and not given.write)


if __name__ == "__main__":
    sys.exit(main())
