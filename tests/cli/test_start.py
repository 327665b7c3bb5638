"""What a command loads before it does its work, and what it leaves undone."""

import subprocess
import sys

import pytest

ROOMS = [
    "numpy", "sqlalchemy", "alembic", "scipy", "flint", "textual", "matplotlib", "asyncio", "multiprocessing",
    "orbitdb.averages", "orbitdb.averages.sum_rules", "orbitdb.entropy.bounds", "orbitdb.filling",
    "orbitdb.orbits.births", "orbitdb.orbits.newton", "orbitdb.plots",
    "orbitdb.cli.commands.maintenance.bench",
]  # fmt: skip
"""What takes a hundredth of a second to load, or ten times as long."""

LIGHTEST_FIRST = {
    "fill --help": "",
    "columns": "",
    "query 1232131 -c code,length": "numpy",
    "query 1232131": "orbitdb.orbits.births orbitdb.orbits.newton",
    "table": "sqlalchemy asyncio orbitdb.averages orbitdb.averages.sum_rules",
    "query --p 3": "",
    "lyapunov": "",
    "births --p 2": "multiprocessing orbitdb.filling",
    "fill --p 2 --db new.db": "",
    "--help": "orbitdb.cli.commands.maintenance.bench",
}
"""Commands, each with what it loads that those before it have not."""

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
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, *arguments], capture_output=True, text=True, check=True, **options
    )
    return done.stdout.splitlines()


@pytest.mark.slow
def test_a_command_loads_what_it_needs(filled, monkeypatch):
    monkeypatch.setenv("ORBITDB_DB", str(filled))
    told = python(SCRIPT, " ".join(ROOMS), *LIGHTEST_FIRST, cwd=filled.parent)
    loaded = [line.split()[1:] for line in told if line.split()[:1] == ["loads"]]
    assert dict(zip(LIGHTEST_FIRST, loaded, strict=True)) == {
        line: sorted(rooms.split()) for line, rooms in LIGHTEST_FIRST.items()
    }


@pytest.mark.parametrize(
    ("typed", "meant"), [("colums", "columns"), ("--versio", "--version"), ("table --colour", "--help")]
)
def test_a_slip_is_told_with_what_may_be_meant(cli, typed, meant):
    """Of all commands, though none of them is loaded yet."""
    assert cli(*typed.split()).says(2, typed.split()[-1], meant)


def test_nothing_is_collected_while_a_short_command_runs():
    code = "import gc, sys\nfrom orbitdb.cli.main import run\ntold = []\n"
    code += "gc.callbacks.append(lambda phase, info: told.append(phase))\n"
    code += "try: run()\nfinally: gc.collect(); print(len(told), gc.get_freeze_count() > 1000)"
    assert python(code, "columns")[-1] == "2 True"  # the start and the stop of the last line's
