"""``python -m orbitdb``: the command line."""

from orbitdb.cli.main import run

if __name__ == "__main__":
    run()
