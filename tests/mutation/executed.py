"""Which tests execute which lines, in all their processes and threads, and what each test takes."""

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from coverage import Coverage, CoverageData
from mutants import Mutant
from recording import TARGET
from tree import Tree, ended

_CONFIGURATION = """
[run]
data_file = {folder}/data
source = {sources}
parallel = true
concurrency = multiprocessing, thread
patch = _exit
context = ${{PYTEST_CURRENT_TEST-}}
disable_warnings = no-data-collected, module-not-imported, module-not-measured, already-imported
"""
_AN_HOUR = 3600.0


@dataclass
class Executed:
    """What is known of the tests of a tree.

    Attributes
    ----------
    files : dict
        The content, as a hash, of every file that it depends on.
    tests : dict
        Of each test that passes: seconds, and the fixtures that it shares.
    lines : dict
        Of each file and line: the tests and fixtures that execute it.
    """

    files: dict[str, str] = field(default_factory=dict)
    tests: dict[str, dict] = field(default_factory=dict)
    lines: dict[str, dict[str, list[str]]] = field(default_factory=dict)

    def tests_of(self, mutant: Mutant, sources: dict[str, str]) -> list[str]:
        """Return the tests that execute a mutant: of its own wing first, then the quicker ones."""
        labels = self._labels(mutant.path, range(mutant.first, mutant.last + 1))
        if mutant.names:
            labels |= self._of_names(mutant.names, sources)
            labels |= self._labels(mutant.path, range(1, 1 << 20))
        chosen = [
            name
            for name, told in self.tests.items()
            if name in labels or not labels.isdisjoint(told["shared"])
        ]
        parts = mutant.path.split("/")
        own = tuple({f"tests/{part}/" for part in parts[: 2 if len(parts) > 2 else 1]})
        return sorted(chosen, key=lambda name: (not name.startswith(own), self.tests[name]["seconds"]))

    def _labels(self, path: str, numbers: Iterable[int]) -> set[str]:
        known = self.lines.get(path, {})
        if len(numbers) > len(known):
            numbers = map(int, known)
        return {label for number in numbers for label in known.get(str(number), ())}

    def _of_names(self, names: Iterable[str], sources: dict[str, str]) -> set[str]:
        """Return who executes a line that says one of the names."""
        pattern = re.compile("|".join(rf"\b{re.escape(name)}\b" for name in names))
        found: set[str] = set()
        for path, source in sources.items():
            numbers = [k for k, line in enumerate(source.splitlines(), 1) if pattern.search(line)]
            found |= self._labels(path, numbers)
        return found


def executed(tree: Tree, folder: Path, jobs: int, marked: str | None = None) -> Executed:
    """Return which tests execute what, from a file if nothing has changed since it was written.

    `marked` says which tests, as pytest's ``-m`` does; else the default ones. Each choice has its own file.
    """
    name = "executed" + re.sub(r"\W+", "-", f" {marked}" if marked is not None else "")
    target, files = folder / f"{name}.json", _hashes(tree)
    if target.exists():
        known = Executed(**json.loads(target.read_text()))
        if known.files == files:
            return known
    known = Executed(files)
    _run(tree, known, ["tests", *([] if marked is None else ["-m", marked])], jobs)
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(asdict(known)))
    return known


def _hashes(tree: Tree) -> dict[str, str]:
    paths = [path for wing in tree.wings().values() for path in wing]
    tests = [path.relative_to(tree.root).as_posix() for path in sorted((tree.root / "tests").rglob("*.py"))]
    paths += [path for path in tests if not path.startswith("tests/mutation/")]
    return {path: hashlib.sha256((tree.root / path).read_bytes()).hexdigest() for path in paths}


def _run(tree: Tree, known: Executed, which: list[str], jobs: int) -> None:
    """Run tests, and add what they execute."""
    with tempfile.TemporaryDirectory(prefix="map-") as name:
        folder = Path(name)
        copy = tree.copy(folder / "tree")
        (folder / "data-of").mkdir()
        tops = [copy.package, *copy.moved.values()]
        configuration = folder / "coveragerc"
        configuration.write_text(
            _CONFIGURATION.format(
                folder=folder / "data-of", sources=", ".join(str(copy.root / top) for top in tops)
            )
        )
        variables = {
            "COVERAGE_PROCESS_START": str(configuration),
            "ORBITDB_RECORD_OF": copy.package,
            TARGET: str(folder / "tests.json"),
        }
        _check_that_processes_are_followed(variables)
        running = copy.start_tests(["-p", "recording", "-n", str(jobs), *which], folder / "log", variables)
        code = ended(running, copy, _AN_HOUR)
        if code not in (0, 1) or not (folder / "tests.json").exists():
            raise SystemExit((folder / "log").read_text())
        told = json.loads((folder / "tests.json").read_text())
        data = _combined(configuration)
        known.tests |= {test: each for test, each in told.items() if each["passed"]}
        _add_lines(known, copy, data)


def _check_that_processes_are_followed(variables: Mapping[str, str]) -> None:
    """Tell before all tests have run for nothing."""
    started = [sys.executable, "-c", "import sys; sys.exit('coverage' not in sys.modules)"]
    if subprocess.run(started, env=os.environ | variables, check=False).returncode:
        raise SystemExit("nothing would be measured: coverage's own .pth file must be in this environment")


def _combined(configuration: Path) -> CoverageData:
    os.environ.pop("COVERAGE_PROCESS_START", None)
    of_all = Coverage(config_file=str(configuration))
    of_all.combine()
    return of_all.get_data()


def _add_lines(known: Executed, copy: Tree, data: CoverageData) -> None:
    for measured in data.measured_files():
        lines = known.lines.setdefault(Path(measured).relative_to(copy.root).as_posix(), {})
        for number, contexts in data.contexts_by_lineno(measured).items():
            labels = {_test(context) for context in contexts} - {""}
            lines[str(number)] = sorted(labels)


def _test(context: str) -> str:
    """Return the test of a context; another process says the part of the test that started it, too."""
    name, _, part = context.rpartition(" (")
    return name if part in ("setup)", "call)", "teardown)") else context
