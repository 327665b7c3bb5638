"""Copies of the tree in which tests run, so that what they import, in every process, is the copy."""

import compileall
import contextlib
import os
import py_compile
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

HERE = Path(__file__).parent
_LEFT_OUT = shutil.ignore_patterns(
    ".git",
    ".venv",
    ".hypothesis",
    ".*_cache",
    ".mutation",
    "__pycache__",
    "build",
    "dist",
    "site",
    "*.egg-info",
)
_running: set[Path] = set()
_MARK = "ORBITDB_TESTS_IN"
"""In the environment of every process of tests, says which copy they are in."""
_OF_THE_OUTER_RUN = ("PYTEST_", "COVERAGE_", "COV_CORE_")


@dataclass(frozen=True)
class Tree:
    """The sources of a package, with its tests.

    Attributes
    ----------
    root : Path
        The folder of ``pyproject.toml``.
    """

    root: Path

    @cached_property
    def _setuptools(self) -> dict:
        return tomllib.loads((self.root / "pyproject.toml").read_text())["tool"]["setuptools"]

    @property
    def package(self) -> str:
        """The name of the package."""
        return self._setuptools["packages"][0].partition(".")[0]

    @property
    def moved(self) -> dict[Path, str]:
        """Where subpackages are imported from, and the folders that they stand in."""
        folders = self._setuptools.get("package-dir", {})
        return {
            Path(*name.split(".")): folder
            for name, folder in folders.items()
            if Path(*name.split(".")) != Path(folder)
        }

    def wings(self) -> dict[str, list[str]]:
        """Return the files of each wing; modules beside the wings are those of the package itself."""
        found: dict[str, list[str]] = {}
        for folder in (self.package, *self.moved.values()):
            for path in sorted((self.root / folder).rglob("*.py")):
                parts = path.relative_to(self.root).parts
                wing = parts[1] if folder == self.package and len(parts) > 2 else folder
                found.setdefault(wing, []).append("/".join(parts))
        return dict(sorted(found.items()))

    def copy(self, to: Path) -> "Tree":
        """Copy all to a new folder, with subpackages where they are imported from."""
        shutil.copytree(self.root, to, ignore=_LEFT_OUT)
        for name, folder in self.moved.items():
            (to / name).symlink_to(to / folder, target_is_directory=True)
        checked = (
            py_compile.PycInvalidationMode.CHECKED_HASH
        )  # an altered file is seen, whatever its date says
        compileall.compile_dir(to / self.package, quiet=2, invalidation_mode=checked)
        return Tree(to)

    def start_tests(
        self, arguments: Sequence[str], output: Path, variables: Mapping[str, str] | None = None
    ) -> subprocess.Popen:
        """Start pytest; no other tree is imported, and no bytecode is written."""
        kept = {name: text for name, text in os.environ.items() if not name.startswith(_OF_THE_OUTER_RUN)}
        mine = {"PYTHONPATH": os.pathsep.join([str(self.root), str(HERE)]), _MARK: str(self.root)}
        with output.open("w") as file:
            return subprocess.Popen(
                [sys.executable, "-P", "-m", "pytest", "-p", "no:cacheprovider", *arguments],
                cwd=self.root,
                env=kept | mine | {"PYTHONDONTWRITEBYTECODE": "1"} | dict(variables or {}),
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C reaches the one who ends them
            )


def ended(process: subprocess.Popen, copy: Tree, seconds: float) -> int | None:
    """Return the exit code of tests in a copy; None if they take longer. All that they started is ended."""
    _running.add(copy.root)
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        return None
    finally:
        _running.discard(copy.root)
        _end_those_of(copy.root)
        process.wait()


def end_all() -> None:
    """End all tests that run, in whatever thread somebody waits for them."""
    for root in list(_running):
        _end_those_of(root)


def _end_those_of(root: Path) -> None:
    """Kill all processes of tests in a copy, those in sessions of their own, too."""
    mark = f"{_MARK}={root}\0".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if mark in (folder / "environ").read_bytes():
                os.kill(int(folder.name), signal.SIGKILL)
