"""Mutation testing: alter the code in one place at a time, and report mistakes that no test notices.

``python tests/mutation/mutate.py billiard store --sample 20 --seed 1`` tries twenty mutants in each of two
wings, or in every wing if none is named. A first run of all tests records which lines they execute. Then the
tests that execute an altered line run in a copy of the tree: those of its wing first, one case of each test
before the others, fast ones before slow ones. ``--at FILE:LINE`` repeats a line; ``--tests "not fuzz"`` uses
all tests that CI runs. A sample has equally many mistakes of each kind, so that rare ones are tried, too.
"""

import argparse
import ast
import compileall
import contextlib
import json
import os
import py_compile
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any

from mutants import Mutant, differs, mutants
from recording import FOLDER

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TOPS = ("orbitdb", "cli", "migrations")
START, AN_HOUR = 60.0, 3600.0
_MARK = "ORBITDB_TESTS_IN"
"""Environment variable of every test process, with the path of its copy."""


class Copy:
    """A copy of the tree in which tests run, and the lines they execute there."""

    def __init__(self, folder: Path, marked: str) -> None:
        self.root = folder / "tree"
        left_out = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "site", "*.egg-info")
        shutil.copytree(ROOT, self.root, ignore=left_out)
        for top in TOPS[1:]:
            (self.root / "orbitdb" / top).symlink_to(self.root / top, target_is_directory=True)
        seen = py_compile.PycInvalidationMode.CHECKED_HASH  # whatever the dates say
        compileall.compile_dir(self.root / "orbitdb", quiet=2, invalidation_mode=seen)
        paths = [path for top in TOPS for path in sorted((self.root / top).rglob("*.py"))]
        real = {path.resolve() for path in paths}
        self.sources = {path.relative_to(self.root).as_posix(): path.read_text() for path in sorted(real)}
        self.made = [each for text in self.sources.values() for each in _made(text)]
        self.tests: dict[str, Any] = {}
        self.lines: dict[str, dict[int, set[str]]] = {path: {} for path in self.sources}
        self._record(folder / "recorded", marked)

    def _record(self, folder: Path, marked: str) -> None:
        """Run all tests and record what they execute; ignore tests that fail without a mistake."""
        folder.mkdir()
        asked = ["-p", "recording", "-n", "2", "--tb=no", "-rfE", *(["-m", marked] if marked else [])]
        _, log = self.run([*asked, "tests"], AN_HOUR, **{FOLDER: str(folder)})
        for part in folder.glob("*.json"):
            told = json.loads(part.read_text())
            self.tests |= told["tests"]
            for file, lines in told["lines"].items():
                known = self.lines[Path(file).relative_to(self.root.resolve()).as_posix()]
                for number, labels in lines.items():
                    known.setdefault(int(number), set()).update(labels)
        for name in re.findall(r"(?m)^(?:FAILED|ERROR) (.+?)(?: - .*)?$", log):
            print(f"fails without a mistake: {name}", flush=True)
            self.tests.pop(name, None)

    def run(self, arguments: Sequence[str], limit: float, **variables: str) -> tuple[int | None, str]:
        """Run pytest; return its exit code, or None after a timeout, and its output."""
        kept = {name: text for name, text in os.environ.items() if not name.startswith("PYTEST_")}
        mine = {"PYTHONPATH": os.pathsep.join([str(self.root), str(HERE)]), _MARK: str(self.root)}
        log = self.root.with_name("log")
        with log.open("w") as file:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "pytest", "-p", "no:cacheprovider", *arguments],
                cwd=self.root, env=kept | mine | {"PYTHONDONTWRITEBYTECODE": "1"} | variables,
                stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
            try:
                code = process.wait(limit)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                self._end_all()
                process.wait()
        return code, log.read_text(errors="replace")

    def _end_all(self) -> None:
        """Kill all test processes, including those in their own sessions."""
        mark = f"{_MARK}={self.root}\0".encode()
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if mark in (folder / "environ").read_bytes():
                    os.kill(int(folder.name), signal.SIGKILL)

    def tests_of(self, mutant: Mutant, most: float) -> list[str]:
        """Return the tests that execute a mutant, or else its wing's: up to `most` seconds, at least one."""
        labels = self._labels(mutant.path, lambda number, _: mutant.first <= number <= mutant.last)
        if mutant.names:
            named = re.compile("|".join(rf"\b{re.escape(name)}\b" for name in self._made_of(mutant.names)))
            for path in self.sources:
                labels |= self._labels(path, lambda _, line: bool(named.search(line)))
            files = {name.partition("::")[0] for name in self.tests}
            naming = {file for file in files if named.search((self.root / file).read_text())}
            labels |= {name for name in self.tests if name.partition("::")[0] in naming}
        own = f"tests/{wing_of(mutant.path)}/"
        known = [name for name, test in self.tests.items() if name in labels or labels & {*test["shared"]}]
        known = known or [name for name in self.tests if name.startswith(own)]  # executed only at import
        cost = {name: self.tests[name]["seconds"] for name in sorted(known)}
        first = {name.partition("[")[0]: name for name in sorted(cost, key=cost.__getitem__, reverse=True)}
        others = cost.keys() - first.values()  # slower cases of the same tests
        kept: list[str] = []
        spent = 0.0
        for name in sorted(cost, key=lambda n: (not n.startswith(own), n in others, cost[n])):
            spent += cost[name]
            if kept and spent > most:
                break
            kept.append(name)
        return kept

    def _made_of(self, names: Sequence[str]) -> set[str]:
        """Return names, and all names outside functions whose values depend on them."""
        found, parts = set(names), set[str]()
        while found != parts:
            parts = set(found)
            found |= {made for made, of in self.made if of & parts}
        return found

    def _labels(self, path: str, wanted: Callable[[int, str], bool]) -> set[str]:
        lines = enumerate(self.sources[path].splitlines(), 1)
        found = (self.lines[path].get(number, set()) for number, line in lines if wanted(number, line))
        return set().union(*found)

    def outcome(self, mutant: Mutant, options: argparse.Namespace) -> tuple[str, str]:
        """Try a mutant; return whether it was noticed, and by which test."""
        tests = self.tests_of(mutant, options.most)
        if not tests:
            return "never executed", ""
        listed, file = self.root.with_name("tests.txt"), self.root / mutant.path
        listed.write_text("\n".join(tests))
        limit = START + options.patience * sum(self.tests[name]["seconds"] for name in tests)
        file.write_text(mutant.applied(self.sources[mutant.path]))
        try:
            code, log = self.run(
                ["-n", "0", "-q", "-x", "-m", "", "--tb=no", "-rfE", "--hypothesis-seed=1", f"@{listed}"],
                limit,
            )
        finally:
            file.write_text(self.sources[mutant.path])
        failed = re.search(r"(?m)^(?:FAILED|ERROR) (\S+)", log)
        told = {None: "timed out", 0: f"survived {len(tests)} tests"}.get(code, "killed")
        return told, failed[1] if failed else ""


def _made(source: str) -> Iterator[tuple[str, set[str]]]:
    """Yield the names that a module binds, with the names in their values or in the heads of functions."""
    for each in ast.parse(source).body:
        match each:
            case ast.FunctionDef():
                bound, made_of = {each.name}, _names(each.args)
            case ast.Assign():
                bound, made_of = set().union(*map(_names, each.targets)), _names(each.value)
            case ast.AnnAssign(value=ast.expr() as value):
                bound, made_of = _names(each.target), _names(value)
            case _:
                continue
        yield from ((name, made_of) for name in bound)


def _names(node: ast.AST) -> set[str]:
    inner = (getattr(part, "id", getattr(part, "attr", None)) for part in ast.walk(node))
    return {name for name in inner if isinstance(name, str)}


def wing_of(path: str) -> str:
    """Return the wing of a file; modules outside the wings belong to the package itself."""
    top, *rest = path.split("/")
    return rest[0] if top == "orbitdb" and len(rest) > 1 else top


def sample(
    paths: Sequence[str], sources: dict[str, str], size: int | None, seed: int, at: Sequence[str] = ()
) -> Iterator[Mutant]:
    """Yield some or all mutants of files, kinds in turn. Changes elsewhere do not affect the choice."""
    kinds: dict[str, list[Mutant]] = {}
    for path in paths:
        for mutant in mutants(path, sources[path]):
            if not at or f"{path}:{line_of(mutant, sources[path])}" in at:
                kinds.setdefault(mutant.kind, []).append(mutant)
    for alike in kinds.values():
        alike.sort(key=lambda mutant: mutant.rank(sources[mutant.path], seed))
    in_turn = (mutant for row in zip_longest(*kinds.values()) for mutant in row if mutant is not None)
    return islice((mutant for mutant in in_turn if differs(mutant, sources[mutant.path])), size)


def line_of(mutant: Mutant, source: str) -> int:
    """Return the line number of a mistake."""
    return source.encode()[: mutant.start].count(b"\n") + 1


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse the options."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("wings", nargs="*", metavar="WING", help="such as store or cli; default: all")
    add("--sample", type=int, metavar="N", help="mutants per wing; default: all")
    add("--seed", type=int, default=1, help="seed of the sample, which is reproducible")
    add(
        "--at", action="append", default=[], metavar="FILE:LINE", help="only mutants of this line; repeatable"
    )
    add(
        "--tests",
        default="",
        metavar="EXPR",
        help="pytest's -m, such as 'not fuzz' for the tests of CI",
    )
    add("--most", type=float, default=60.0, metavar="S", help="seconds of tests per mutant")
    add("--patience", type=float, default=6.0, metavar="X", help="timeout as a multiple of the tests' time")
    return parser.parse_args(arguments)


def main() -> None:
    """Run the command."""
    options = parse()
    with tempfile.TemporaryDirectory(prefix="m-", ignore_cleanup_errors=True) as folder:
        copy = Copy(Path(folder), options.tests)
        for wing in options.wings or sorted({*map(wing_of, copy.sources)}):
            paths = [path for path in copy.sources if wing_of(path) == wing]
            tried = noticed = 0
            for mutant in sample(paths, copy.sources, options.sample, options.seed, options.at):
                told, by = copy.outcome(mutant, options)
                tried, noticed = tried + 1, noticed + (told in ("killed", "timed out"))
                place = f"{mutant.path}:{line_of(mutant, copy.sources[mutant.path])} ({mutant.kind})"
                before, after = mutant.shown(copy.sources[mutant.path])
                print(
                    f"{told}: {place} {by}" if by else f"{told}: {place}\n  - {before}\n  + {after}",
                    flush=True,
                )
            print(f"{wing}: {noticed} of {tried} noticed", flush=True)


if __name__ == "__main__":
    main()
