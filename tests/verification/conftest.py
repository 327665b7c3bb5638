"""A small catalogue at two a that several modules verify, each on its own copy."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from contents import made

from orbitdb.filling.fill import fill_geometric, fill_periods, fill_word
from orbitdb.symbols.words import parse


@pytest.fixture(scope="session")
def small_once(made_once: Callable[..., Path]) -> Path:
    def make(path: Path) -> None:
        fills = (fill_periods(path, a, periods) for a, periods in ((1.6, (5, 6)), (1.0, (6,))))
        made(path, *fills, fill_geometric(path, range(2, 4)))
        fill_word(path, parse("1^30 5^29"), 1.6)

    return made_once("small", make)


@pytest.fixture
def small(small_once: Path, tmp_path: Path) -> Path:
    """A copy of a catalogue with p = 5 and 6 at two a, pruned words and a long word."""
    return Path(shutil.copy(small_once, tmp_path / "orbits.db"))
