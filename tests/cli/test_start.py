"""What a command imports before it works; no files left open and no warnings, with -W error -X dev."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from processes import run

import orbitdb

ROOMS = [
    "numpy", "sqlalchemy", "alembic", "scipy", "flint", "textual", "matplotlib", "asyncio", "multiprocessing",
    "orbitdb.averages", "orbitdb.averages.sum_rules", "orbitdb.entropy_bounds.bounds", "orbitdb.filling",
    "orbitdb.orbits.births", "orbitdb.orbits.newton", "orbitdb.plots.style",
    "orbitdb.cli.commands.bench",
]  # fmt: skip
"""Modules that take 0.01 to 0.1 s to import."""

LIGHTEST_FIRST = {
    "--help": "orbitdb.cli.commands.bench",
    "columns": "",
    "query 1232131 -c code,length": "asyncio numpy sqlalchemy",
    "query 1232131": "orbitdb.orbits.births orbitdb.orbits.newton",
    "table": "orbitdb.averages orbitdb.averages.sum_rules orbitdb.entropy_bounds.bounds",
    "query --p 3": "",
    "lyapunov": "",
    "births --p 2": "orbitdb.filling",
    "fill --p 2 --db new.db": "",
}
"""Commands with the slow modules each may import beyond those of the earlier ones."""

SCRIPT = """
import sys
from orbitdb.cli.main import execute
rooms, *lines = sys.argv[1:]
known = set()
for line in lines:
    execute(line.split())
    loaded = {room for room in rooms.split() if room in sys.modules}
    print("loads", *sorted(loaded - known))
    known |= loaded
"""


def python(code: str, *arguments: str, **options) -> list[str]:
    done = run(*arguments, command=[sys.executable, "-P", "-c", code], **options)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.slow
def test_a_command_imports_only_what_it_needs(filled, monkeypatch):
    monkeypatch.setenv("ORBITDB_DB", str(filled))
    told = python(SCRIPT, " ".join(ROOMS), *LIGHTEST_FIRST, cwd=filled.parent)
    loaded = [line.split()[1:] for line in told if line.split()[:1] == ["loads"]]
    assert dict(zip(LIGHTEST_FIRST, loaded, strict=True)) == {
        line: sorted(rooms.split()) for line, rooms in LIGHTEST_FIRST.items()
    }


def test_no_garbage_collection_runs_during_a_short_command():
    code = "import atexit, gc, sys\nfrom orbitdb.cli.main import run\ncollections = []\n"
    code += "gc.callbacks.append(lambda phase, info: collections.append(phase))\n"
    code += "atexit.register(lambda: print(len(collections), flush=True))\nrun()"
    assert python(code, "columns")[-1] == "0"


STRICT = [sys.executable, "-W", "error", "-X", "dev", "-P", "-c"]
_CHAIN = """
import shlex, sys
from orbitdb.cli.main import execute
for line in sys.stdin:
    if execute(shlex.split(line)):
        sys.exit(line)
"""
CHAIN = [*STRICT, _CHAIN]
READING = """
query --p 2-5 --order length --limit 3
query --code 1232131
query --where 'p > 3' --limit 3 --json
table
info
entropy
lyapunov
lyapunov --cut 9
export {folder}/x.csv
export {folder}/x.parquet
export {folder}/x.json
export {folder}/x.jsonl
"""
WRITING = """
fill --p 4 --db {folder}/new.db
fill --p 3 --geometric --db {folder}/new.db
fill --p 3 --a 0.7 --method relaxation --db {folder}/new.db
fill --code 1232131 --db {folder}/new.db
simulate --bounces 1000 --db {folder}/new.db
verify --db {folder}/new.db
verify --prove --db {folder}/new.db
migrate --db {folder}/new.db
"""
DRAWING = """
plot orbit --code 13 -o {folder}/x.svg
plot lyapunov -o {folder}/x.png
plot sheet --p 4 -o {folder}/x.pdf
plot phase-space --p 2-4 -o {folder}/x.png --force
"""
LIBRARY = """
import sys
from orbitdb import Catalogue, solve_word
catalogue = Catalogue(sys.argv[1])
assert catalogue["13"] == solve_word("13", 1.6) and "13" in catalogue
rows = iter(catalogue)
next(rows)
del catalogue, rows
Catalogue(sys.argv[1]).select(p=3)
"""


@pytest.mark.slow
@pytest.mark.parametrize("lines", [READING, WRITING, DRAWING], ids=["reading", "writing", "drawing"])
def test_commands_neither_warn_nor_leave_files_open(filled, tmp_path, lines, monkeypatch):
    monkeypatch.setenv("ORBITDB_DB", str(filled))
    done = run(command=CHAIN, input=lines.format(folder=tmp_path).strip())
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    assert "Exception" not in done.stderr


RUN = "from orbitdb.cli.main import run; run()"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "arguments", "end"),
    [(RUN, "table --db", 0), (RUN, "query --where lenght>3 --db", 2), (LIBRARY, "", 0)],
)
def test_a_process_ends_cleanly(filled, code, arguments, end):
    """The library's catalogue is dropped without being closed."""
    done = run(*arguments.split(), filled, command=[*STRICT, code])
    assert done.returncode == end
    assert "Warning" not in done.stderr
    assert "Exception" not in done.stderr


AS_A_MODULE = """
import runpy, sys
sys.meta_path = [finder for finder in sys.meta_path if "Editable" not in repr(finder)]
sys.path.insert(0, "")
runpy.run_module("orbitdb", run_name="__main__", alter_sys=True)
"""


@pytest.mark.slow
def test_the_source_folder_runs_without_installation(tmp_path):
    root = Path(orbitdb.__file__).parents[1]
    command = [sys.executable, "-c", AS_A_MODULE, "migrate", "--db", str(tmp_path / "new.db")]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("created, schema")) == (0, 1), done.stderr


def test_help_describes_the_command_even_without_docstrings():
    usual, bare = (python(f"from orbitdb.cli.main import run; run() # {level}", "sql", "--help",
                          env={**os.environ, "PYTHONOPTIMIZE": level}) for level in ("0", "2"))  # fmt: skip
    assert bare == usual
    assert "  Run one SELECT statement on the catalogue, over all values of a." in bare
