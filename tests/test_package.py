"""The wheel: installed away from the sources, it does the main job."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from orbitdb import __version__

ROOT = Path(__file__).parents[1]


def test_the_citation_is_of_this_version():
    assert f"\nversion: {__version__}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.slow
def test_the_wheel_works_away_from_the_sources(tmp_path):
    wheels, target = tmp_path / "wheels", tmp_path / "site"
    source = tmp_path / "source"
    shutil.copytree(
        ROOT, source, ignore=shutil.ignore_patterns(".git", "build", "*.egg-info", ".venv", ".*_cache")
    )
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    subprocess.run(
        [
            *pip,
            "wheel",
            "--quiet",
            "--no-deps",
            "--no-build-isolation",
            "--wheel-dir",
            str(wheels),
            str(source),
        ],
        check=True,
        capture_output=True,
    )
    (wheel,) = wheels.glob("orbitdb-*.whl")
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--target", str(target), str(wheel)], check=True)
    shutil.rmtree(source)
    environment = os.environ | {"PYTHONPATH": str(target), "ORBITDB_DB": str(tmp_path / "orbits.db")}
    command = target / "bin" / "orbitdb"
    for arguments in (["fill", "--p", "4"], ["table"]):
        result = subprocess.run(
            [sys.executable, str(command), *arguments],
            check=True, cwd=tmp_path, env=environment, capture_output=True, text=True,
        )  # fmt: skip
    assert result.stdout.splitlines()[-1].split()[:4] == ["4", "32", "32", "130"]
    where = subprocess.run(
        [sys.executable, "-P", "-c", "import orbitdb.cli; print(orbitdb.__file__, orbitdb.cli.__file__)"],
        check=True, cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    assert all(path.startswith(str(target)) for path in where.stdout.split())
    assert (target / "orbitdb" / "py.typed").exists()
