"""What is executed, branches included, in all processes and threads of the tests: a figure for each wing.

``python tests/mutation/coverage_by_wing.py`` runs the default tests; what follows goes to pytest, say
``-m "not fuzz"`` for all that CI runs. ``--missing`` lists the lines, and the branches, that nobody takes.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tree import Tree

ROOT = Path(__file__).parents[2]
_COUNTED = ("num_statements", "covered_lines", "num_branches", "covered_branches")


def measured(pytest_arguments: Sequence[str]) -> dict[str, dict]:
    """Run tests, and return what coverage.py tells of each file."""
    with tempfile.TemporaryDirectory(prefix="coverage-") as folder:
        report = Path(folder) / "report.json"
        variables = os.environ | {"COVERAGE_FILE": str(Path(folder) / "data")}

        def coverage(*arguments: str, **options) -> int:
            command = [sys.executable, "-m", "coverage", *arguments]
            return subprocess.run(command, cwd=ROOT, env=variables, stdout=sys.stderr, **options).returncode

        tree = Tree(ROOT)
        sources = ",".join(str(ROOT / folder) for folder in (tree.package, *tree.moved.values()))
        failed = coverage("run", f"--source={sources}", "-m", "pytest", *pytest_arguments)
        coverage("combine", "--quiet", check=True)
        coverage("json", "--quiet", "-o", str(report), check=True)
        if failed:
            print("some tests failed: what they would have executed is missing", file=sys.stderr)
        files = json.loads(report.read_text())["files"]
        return {Path(path).resolve().relative_to(ROOT).as_posix(): told for path, told in files.items()}


def table(wings: dict[str, list[str]], files: dict[str, dict]) -> list[str]:
    """Return a line for each wing: statements and branches, and how many of both are taken."""
    lines = [f"{'wing':14}{'statements':>11}{'missed':>8}{'branches':>10}{'missed':>8}{'taken':>8}"]
    everything = [path for paths in wings.values() for path in paths]
    for wing, paths in [*wings.items(), ("all", everything)]:
        told = [files[path]["summary"] for path in paths if path in files]
        statements, run, branches, taken = (sum(each.get(name, 0) for each in told) for name in _COUNTED)
        part = (run + taken) / max(statements + branches, 1)
        numbers = (statements, statements - run, branches, branches - taken)
        lines.append(f"{wing:14}{numbers[0]:>11}{numbers[1]:>8}{numbers[2]:>10}{numbers[3]:>8}{part:>8.1%}")
    return lines


def missing(files: dict[str, dict]) -> list[str]:
    """Return what is never executed, file by file; a branch as the lines that it goes from and to."""
    lines = []
    for path, told in sorted(files.items()):
        never = [f"{path}:{number}" for number in told["missing_lines"]]
        skipped = {abs(number) for number in told["missing_lines"]}
        for start, end in told.get("missing_branches", []):
            if start not in skipped and abs(end) not in skipped:
                never.append(f"{path}:{start} -> {'the end' if end < 0 else end}")
        lines += never
    return lines


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--missing", action="store_true", help="list what nobody takes, too")
    options, arguments = parser.parse_known_args()
    files = measured(arguments)
    told = table(Tree(ROOT).wings(), files)
    print("\n".join([*told, *(["", *missing(files)] if options.missing else [])]))


if __name__ == "__main__":
    main()
