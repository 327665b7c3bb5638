"""Run the examples in README.md and on the pages here, and compare their output with the output shown.

    python docs/console.py            lists the examples whose output differs
    python docs/console.py --write    writes the actual output into the pages; --write FILE for one page

An example is a ``console`` block whose commands begin with ``$``, or a ``python`` block, whose output is the
``text`` block that follows it. The examples of a page run one after another in a folder of their own. The
data folder contains the catalogue of ``orbitdb fill --p 11``, unless the page begins with a fill. A comment
before a block marks special cases:

    <!-- not run: why -->    the example is only shown
    <!-- varies -->          numbers in the output are random: only the words must agree
    <!-- times -->           numbers that are not integers are times: everything else must agree

A ``text`` block counts as output only if it directly follows a ``python`` block. The output of a notebook
cell is in a comment ``<!-- shows``.
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
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any
from unittest.mock import patch

from pages import PAGES, Example, examples

FIRST_FILL = "orbitdb fill --p 11"
"""The command that makes the catalogue for the examples."""

HOME = "/home/you"
"""The name that the pages show instead of the folder in which the examples run."""

CATALOGUE = Path(".local/share/orbitdb/orbits.db")
"""The path of the catalogue in that folder, away from the files that the examples write."""

_SHELL = re.compile(r"[|<>&;`$*~#]")


class Session:
    """The state in which the examples of a page run: a folder, and the names defined by its Python code."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.setting = {"ORBITDB_DB": str(folder / CATALOGUE), "COLUMNS": "80", "PYTHONSAFEPATH": "1"}
        (folder / CATALOGUE).parent.mkdir(parents=True, exist_ok=True)
        self.names: dict[str, Any] = {"__name__": "__main__"}

    def run(self, example: Example) -> str:
        """Run an example; return its output as a terminal shows it."""
        if example.language == "python":
            output = self._here(lambda: exec(compile(example.source, "<page>", "exec"), self.names))
        else:
            output = self.command(example.source)
        lines = output.replace(str(self.folder), HOME).splitlines()
        return "\n".join(line.rstrip() for line in lines).rstrip()

    def command(self, line: str) -> str:
        """Run a shell command and return its output; a plain orbitdb command runs in this process."""
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
        setting = patch.dict(os.environ, self.setting)
        with setting, chdir(self.folder), redirect_stdout(screen), redirect_stderr(screen):
            work()
        return screen.getvalue()


def begin(wanted: list[Example], folder: Path, catalogue: Path) -> Session:
    """Return a session in an empty folder, with a copy of the catalogue unless the page fills its own."""
    first = next((example.source for example in wanted if example.language == "console"), "")
    if not first.startswith("orbitdb fill"):
        lay(catalogue, folder)
    return Session(folder)


def lay(catalogue: Path, folder: Path) -> None:
    """Copy a catalogue to the place where examples that run in a folder look for it."""
    (folder / CATALOGUE).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(catalogue, folder / CATALOGUE)


def first_catalogue(folder: Path) -> Path:
    """Make the catalogue for pages that do not begin with a fill; return its path."""
    Session(folder).command(FIRST_FILL)
    return folder / CATALOGUE


def rewrite(page: Path, outputs: list[tuple[Example, str]]) -> None:
    """Replace the outputs on a page that differ from the actual ones."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for example, output in reversed(outputs):
        if example.holds(output):
            continue
        follows = example.language == "console" and lines[example.end].startswith("$ ")
        lines[example.start : example.end] = [*output.splitlines(), *([""] if follows else [])]
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> int:
    """Run all examples; return 1 if outputs differ and are not rewritten."""
    parser = argparse.ArgumentParser(description="Run the examples on the pages.")
    parser.add_argument("--write", action="store_true", help="write the actual output into the pages")
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
    print(f"{differing} examples differ" + (" and have been rewritten" if given.write else ""))
    return int(bool(differing) and not given.write)


if __name__ == "__main__":
    sys.exit(main())
