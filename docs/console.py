"""Run the examples of README.md and of the pages here, and compare them with what stands there.

    python docs/console.py            tells which examples differ from what comes out
    python docs/console.py --write    puts what comes out into the pages; --write FILE for one page

An example is a block ``console`` with lines that begin with ``$``, or a block ``python``, whose output
is the block ``text`` behind it. Those of a page run one after the other in a folder of their own, with
the catalogue of ``orbitdb fill --p 11`` in the data folder, unless the page begins with a fill. A comment
before a block says what is particular about it:

    <!-- not run: why -->    it is shown only
    <!-- slow -->            it is run where there is time
    <!-- varies -->          its numbers are drawn at random: the words must agree
    <!-- times -->           its numbers that are not whole are times: the others must agree, too

A ``text`` block is taken as output only directly behind a ``python`` block. That of a notebook's cell stands
in a comment ``<!-- shows``.
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
from pathlib import Path
from typing import Any

from pages import PAGES, Example, examples

FIRST_FILL = "orbitdb fill --p 11"
"""What makes the catalogue that the pages ask."""

HOME = "/home/you"
"""Stands in the pages for the folder that the examples run in."""

CATALOGUE = Path(".local/share/orbitdb/orbits.db")
"""Where the catalogue lies in that folder: not beside what the examples write."""

_SHELL = re.compile(r"[|<>&;`$*~#]")


class Session:
    """Where the examples of one page run: a folder, and the names that its Python has defined."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.setting = {"ORBITDB_DB": str(folder / CATALOGUE), **_SETTING}
        (folder / CATALOGUE).parent.mkdir(parents=True, exist_ok=True)
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
        from orbitdb.cli.main import execute

        line = line.replace("\\\n", " ")
        unquoted = re.sub(r"'[^']*'|\"[^\"$`]*\"", "", line)
        if line.startswith("orbitdb ") and not _SHELL.search(unquoted):
            words = shlex.split(line)[1:]
            return self._here(lambda: execute(words))
        where = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        result = subprocess.run(
            ["bash", "-c", line], cwd=self.folder, env={**os.environ, **self.setting, **where}, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        return result.stdout

    def _here(self, work: Any) -> str:
        screen = io.StringIO()
        with _settings(self.setting), chdir(self.folder), redirect_stdout(screen), redirect_stderr(screen):
            work()
        return screen.getvalue()


_SETTING = {"COLUMNS": "80", "PYTHONSAFEPATH": "1"}


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
        lay(catalogue, folder)
    return Session(folder)


def lay(catalogue: Path, folder: Path) -> None:
    """Copy a catalogue to where the examples in a folder find it."""
    (folder / CATALOGUE).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(catalogue, folder / CATALOGUE)


def first_catalogue(folder: Path) -> Path:
    """Make the catalogue that pages without a fill of their own ask; return its path."""
    Session(folder).command(FIRST_FILL)
    return folder / CATALOGUE


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
