"""No command and no use of the library leaves a file open or warns: all is run with -W error -X dev."""

import sys

import pytest
from processes import run

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
export {folder}/x.npz
export {folder}/x.jsonl
"""
WRITING = """
fill --p 4 --db {folder}/new.db
fill --p 3 --geometric --db {folder}/new.db
fill --p 3 --a 0.7 --method relaxation --db {folder}/new.db
fill --code 1232131 --db {folder}/new.db
simulate --bounces 1000 --db {folder}/new.db
verify --db {folder}/new.db
verify --rigorous --db {folder}/new.db
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
from orbitdb import Catalogue, Selection, solve_word
catalogue = Catalogue(sys.argv[1])
assert catalogue["13"] == solve_word("13", 1.6) and "13" in catalogue
rows = iter(catalogue)
next(rows)
with Catalogue(sys.argv[1]).at_one_moment() as still:
    kept = still.rows(Selection())
    next(kept)
del catalogue, rows
Catalogue(sys.argv[1]).select(p=3)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "lines",
    [
        pytest.param(READING, id="reading"),
        pytest.param(WRITING, id="writing"),
        pytest.param(DRAWING, id="drawing"),
    ],
)
def test_commands_neither_warn_nor_leave_files_open(filled, tmp_path, lines, monkeypatch):
    monkeypatch.setenv("ORBITDB_DB", str(filled))
    done = run(command=CHAIN, input=lines.format(folder=tmp_path).strip())
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    assert "Exception" not in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("arguments", "code"), [(["table"], 0), (["query", "--where", "lenght > 3"], 2)])
def test_the_process_of_a_command_ends_clean(filled, arguments, code):
    command = [*STRICT, "from orbitdb.cli.main import run; run()"]
    done = run(*arguments, "--db", filled, command=command)
    assert done.returncode == code
    assert "Warning" not in done.stderr
    assert "Exception" not in done.stderr


@pytest.mark.slow
def test_the_library_may_drop_a_catalogue_without_close(filled):
    done = run(filled, command=[*STRICT, LIBRARY])
    assert (done.returncode, done.stderr) == (0, "")
