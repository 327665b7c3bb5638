"""A catalogue to draw, and axes to draw on."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from contents import made

from orbitdb import Catalogue, Stadium
from orbitdb.entropy_bounds.bounds import search
from orbitdb.filling.fill import fill_births
from orbitdb.plots import over_a, style
from orbitdb.store.storing import keep_bounds, keep_reference
from orbitdb.store.writer import Writer
from orbitdb.trajectories.ensemble import Reference

TRAJECTORY = Reference(1.6, 0.8871, 0.0002, 0.3754, 0.0003, 2.3634, 0.0004, 12_345, 67, 89)


@pytest.fixture(scope="session")
def known(varied, made_once) -> Catalogue:
    """The varied catalogue with births, averages over trajectories, and bounds at two half lengths."""

    def make(path: Path) -> None:
        shutil.copy(varied, path)
        made(path, fill_births(path, range(2, 7)))
        writer = Writer(path, {})
        keep_reference(writer, TRAJECTORY)
        for a in (1.6, 3.0):
            for level in search(Stadium(a), 3):
                keep_bounds(writer, level)
        writer.close()

    return Catalogue(made_once("drawn", make), 1.6)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


@pytest.fixture
def ax():
    with style.figure(6.4, 4.2) as made:
        yield made.add_subplot()


@pytest.fixture
def few_places(monkeypatch) -> None:
    """Draw curves over a with only a few points, because each point takes as long as an orbit."""
    monkeypatch.setattr(over_a, "PLACES", 12)
    monkeypatch.setattr(over_a, "PLACES_OF_BOUNDS", 12)
