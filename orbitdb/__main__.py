"""``python -m orbitdb``: the command line."""

from orbitdb.cli.main import run

run()
