"""Run the command line with ``python -m orbitdb``."""

from importlib.util import find_spec
from pathlib import Path

import orbitdb

if find_spec("orbitdb.cli") is None:  # in the source folder, they lie beside this package
    orbitdb.__path__.append(str(Path(__file__).parent.parent))

from orbitdb.cli.main import run

if __name__ == "__main__":
    run()
