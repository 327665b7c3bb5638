"""Catalogues that several modules verify, each on its own copy."""

import shutil
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import pytest
from alterations import EVERYTHING, LEVELS, make
from contents import made

from orbitdb.filling import sweeps
from orbitdb.filling.fill import fill_geometric, fill_periods, fill_words
from orbitdb.symbols.words import parse


@pytest.fixture(scope="session")
def small_once(made_once: Callable[..., Path]) -> Path:
    def make(path: Path) -> None:
        fills = (fill_periods(path, a, periods) for a, periods in ((1.6, (5, 6)), (1.0, (6,))))
        made(path, *fills, fill_geometric(path, range(2, 4)))
        fill_words(path, [parse("1^30 5^29")], 1.6)

    return made_once("small", make)


@pytest.fixture
def small(small_once: Path, tmp_path: Path) -> Path:
    """A copy of a catalogue with p = 5 and 6 at two a, pruned words and a long word."""
    return Path(shutil.copy(small_once, tmp_path / "orbits.db"))


@pytest.fixture(scope="session")
def files(made_once: Callable[..., Path]) -> dict[str, Path]:
    """Sound files that together have rows in every table."""

    def make_whole(path: Path) -> None:
        make(path, EVERYTHING)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sweeps, "CLASSES", 8)
            going = sweeps.sweep_periods(path, 0.5, [7])
            list(islice(going, 2))
            going.close()

    return {
        "whole": made_once("everything", make_whole),
        "levels": made_once("levels-alone", lambda path: make(path, LEVELS)),
    }
