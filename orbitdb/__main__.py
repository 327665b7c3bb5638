"""Run the command line with ``python -m orbitdb``."""

from orbitdb.cli.main import run

if __name__ == "__main__":
    run()
