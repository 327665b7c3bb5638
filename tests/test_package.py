"""The wheel works when installed away from the sources, and the program works in their folder."""

import os
import shutil
import sys
from pathlib import Path

import pytest
from processes import run

from orbitdb import __version__

ROOT = Path(__file__).parents[1]


def test_the_citation_names_this_version():
    assert f"\nversion: {__version__}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.slow
def test_the_wheel_works_away_from_the_sources(tmp_path):
    wheels, target = tmp_path / "wheels", tmp_path / "site"
    source = tmp_path / "source"
    shutil.copytree(
        ROOT,
        source,
        ignore=shutil.ignore_patterns(".git", "build", "*.egg-info", ".venv", ".*_cache", "__pycache__"),
    )
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    built = run("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", wheels, source, command=pip)
    assert built.returncode == 0, built.stderr
    (wheel,) = wheels.glob("orbitdb-*.whl")
    assert run("install", "--no-deps", "--target", target, wheel, command=pip).returncode == 0
    for arguments in ("-m", "orbitdb", "--version"), ("-c", "from orbitdb import Catalogue"):
        assert run(*arguments, command=[sys.executable], cwd=source).returncode == 0
    for folder, installed in ("orbitdb", "orbitdb"), ("cli", "orbitdb/cli"):
        names = [path.relative_to(source / folder) for path in (source / folder).rglob("*.*")]
        assert [name for name in names if not (target / installed / name).exists()] == []
    shutil.rmtree(source)
    environment = os.environ | {"PYTHONPATH": str(target), "ORBITDB_DB": str(tmp_path / "orbits.db")}
    command = [sys.executable, str(target / "bin" / "orbitdb")]
    assert run("fill", "--p", "4", command=command, cwd=tmp_path, env=environment).returncode == 0
    result = run("table", command=command, cwd=tmp_path, env=environment)
    assert result.stdout.splitlines()[-1].split()[:4] == ["4", "32", "32", "130"]
    written = run("export", tmp_path / "data", "--dataset", command=command, cwd=tmp_path, env=environment)
    assert (written.returncode, (tmp_path / "data" / "LICENSE.txt").exists()) == (0, True)
    shown = "import orbitdb.cli; print(orbitdb.__file__, orbitdb.cli.__file__)"
    where = run(command=[sys.executable, "-P", "-c", shown], cwd=tmp_path, env=environment)
    assert [path.startswith(str(target)) for path in where.stdout.split()] == [True, True]


def test_what_a_catalogue_returns_is_public():
    import builtins
    import inspect
    import re
    import typing

    import orbitdb

    public = {*orbitdb.__all__, *dir(builtins), *dir(typing)}
    methods = inspect.getmembers(orbitdb.Catalogue, inspect.isfunction)
    for name, method in methods:
        if name[0] != "_":
            returned = str(inspect.signature(method).return_annotation)
            ours = re.findall(r"(?<![.\w])[A-Z]\w+", returned)  # those of other libraries have a dot before
            assert set(ours) <= public, (name, returned)
