"""Fills, sweeps and births that stop anywhere and resume store the same rows as uninterrupted ones."""

import shutil
import sqlite3
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, suppress
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from contents import before_statements, is_sound, rows
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import slow_but

from orbitdb.filling import fill, sweeps
from orbitdb.filling.fill import fill_geometric, fill_periods
from orbitdb.filling.period_jobs import Step
from orbitdb.orbits.admissible import solve_admissible
from orbitdb.store.file import migrate

Work = Callable[[Path], Iterator[Step]]
WORKS: dict[str, Work] = {
    "fill": lambda path: fill_periods(path, 1.6, [4, 5, 6]),
    "fill at another a": lambda path: fill_periods(path, 1.0, [6]),
    "fill of pruned words": lambda path: fill_geometric(path, [3, 6]),
    "births": lambda path: fill.fill_births(path, [2, 3, 5]),
    "sweep": lambda path: sweeps.sweep_periods(path, 1.6, [5, 6]),
}


class Stored(dict[str, list[tuple[Any, ...]]]):
    """The rows of each table; a short repr keeps them out of the output of failed tests."""

    def __repr__(self) -> str:
        return f"<{ {table: len(found) for table, found in self.items()} }>"


ENDS = ("", "-wal")
"""A kill leaves a file and its journal."""


class Killed(BaseException):
    """Ends a process; the program never catches it."""


@pytest.fixture(scope="module", autouse=True)
def many_blocks() -> Iterator[None]:
    """Cut small periods into many blocks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(fill.METHODS, "newton", fill.Method(solve_admissible, 4))
        patch.setattr(fill, "BIRTHS_BLOCK", 32)
        patch.setattr(fill, "PRUNED_BLOCK", 1)
        patch.setattr(sweeps, "CLASSES", 4)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("resumed")


@pytest.fixture(scope="module")
def empty(folder: Path) -> Path:
    migrate(folder / "empty.db")
    return folder / "empty.db"


@pytest.fixture(scope="module")
def in_one_go(folder: Path, empty: Path) -> Callable[..., Stored]:
    """Return a function that returns the rows which uninterrupted works store in one file."""

    @cache
    def rows_of(*names: str) -> Stored:
        path = Path(shutil.copy(empty, folder / "whole.db"))
        for name in names:
            assert len(list(WORKS[name](path))) > 1
        return stored(path)

    return rows_of


def stored(path: Path) -> Stored:
    """Return every row except times and provenance."""
    with closing(sqlite3.connect(path)) as plain:
        more = {
            "change": "cycle, number, a, error, kind, bounce, joint, event, slope",
            "pruned_fill": "p, state, cursor, words",
            "birth_fill": "p, state, cursor, words, classes, births, deaths, always, least, largest",
            # without its blocks: a sweep that was merely not closed gets an extra empty one
            "sweep": "stadium, p, state, cursor, words, n_c, classes, boundary, sums",
            "sweep_block": "*",
        }
        found = {
            table: plain.execute(f"SELECT {names} FROM {table}").fetchall() for table, names in more.items()
        }
    return Stored(rows(path) | found)


def same(one: Stored, other: Stored) -> None:
    for table in other:
        assert one[table] == other[table], table


def cut(path: Path, work: Work, way: str, moment: int) -> None:
    """Stop the work between blocks or at a statement, by an exception or leaving the file as a kill does."""
    if way == "closed":
        going = work(path)
        assert isinstance(going, Generator)
        list(islice(going, moment // 8))
        going.close()
        return
    copy, told = path.with_name("killed.db"), iter(range(moment))

    def count(statement: str) -> None:
        if "BEGIN" not in statement and next(told, None) is None:
            if way == "killed":
                for end in ENDS:
                    shutil.copy(f"{path}{end}", f"{copy}{end}")
            raise Killed

    with suppress(Killed), before_statements(count):
        list(work(path))
    for end in ENDS if copy.exists() else ():
        shutil.move(f"{copy}{end}", f"{path}{end}")


WAYS = st.sampled_from(["closed", "raised", "killed"])


@pytest.mark.parametrize("name", slow_but(["fill", "births", "sweep"], WORKS))
@given(cuts=st.lists(st.tuples(WAYS, st.integers(0, 100)), min_size=1, max_size=4))
@settings(max_examples=settings().max_examples // 6)
def test_work_stopped_at_any_moment_resumes(
    empty: Path, in_one_go: Callable[..., Stored], name: str, cuts: list[tuple[str, int]]
) -> None:
    path = Path(shutil.copy(empty, empty.with_name("cut.db")))
    for way, moment in cuts:
        cut(path, WORKS[name], way, moment)
        assert is_sound(path)
    list(WORKS[name](path))
    same(stored(path), in_one_go(name))


@pytest.mark.slow
@given(order=st.permutations(sorted(WORKS)), moments=st.lists(st.integers(0, 80), min_size=6), way=WAYS)
@settings(max_examples=4)
def test_several_kinds_of_work_that_take_turns_store_the_same_rows(
    empty: Path, in_one_go: Callable[..., Stored], order: list[str], moments: list[int], way: str
) -> None:
    path = Path(shutil.copy(empty, empty.with_name("turns.db")))
    for name, moment in zip(order, moments, strict=False):
        cut(path, WORKS[name], way, moment)
    for work in WORKS.values():
        list(work(path))
    mine, whole = stored(path), in_one_go(*WORKS)
    for table in whole:  # the ids of stadiums may differ
        assert len(mine[table]) == len(whole[table]), table
    for table in ("cycle", "pruned", "change", "birth_fill"):
        assert sorted(mine[table], key=repr) == sorted(whole[table], key=repr), table
