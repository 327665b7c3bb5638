"""A filled catalogue, and the command line as a function."""

from dataclasses import dataclass

import pytest

HIGHEST = 6


@dataclass(frozen=True)
class Done:
    """What a command left: its exit code and what it wrote."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session")
def filled(tmp_path_factory):
    """A catalogue of all sequences to p = 6 at a = 1.6 and 1, one of p = 12, and those pruned at p = 3."""
    from orbitdb import survey
    from orbitdb.store.catalogue import Catalogue

    path = tmp_path_factory.mktemp("catalogue") / "orbits.db"
    Catalogue.create(path)
    for a in (1.6, 1.0):
        for _ in survey.fill(path, a, range(2, HIGHEST + 1)):
            pass
    for _ in survey.fill_geometric(path, [3]):
        pass
    survey.fill_word(path, "013311133313", 1.6)
    return path


@pytest.fixture
def run(capsys):
    """Run the command line in this process."""
    from orbitdb.cli.main import _run

    def run(*arguments):
        code = _run(list(arguments))
        written = capsys.readouterr()
        return Done(code, written.out, written.err)

    return run
