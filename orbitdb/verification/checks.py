"""The result of a check, and the blocks of classes that any process can check."""

import json
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.errors import AlteredError, DeletedError, SelectionError, WorkError
from orbitdb.orbits.orbits import NUMBERS, Orbits
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.select import Words, arrays_of
from orbitdb.store.sqlite import Connection
from orbitdb.symbols.words import from_strings
from orbitdb.text import shortened

_CLASSES = 4096
_NUMBERS = 1 << 20
"""Maximum number of entries in all p x p matrices of a block."""


@dataclass(frozen=True)
class Check:
    """Result of one check over a number of rows.

    Attributes
    ----------
    name : str
        One of `orbitdb.verification.verify.PROMISES`.
    rows, failures : int
        Number of rows checked, and number of failures.
    worst, share : float or None
        The deviation that is largest relative to what its row allows, and that ratio; above 1, the row fails.
    first : str or None
        The first failure.
    """

    name: str
    rows: int
    failures: int = 0
    worst: float | None = None
    share: float | None = None
    first: str | None = None

    def joined(self, other: "Check") -> "Check":
        """Join this result with that of the same check over other rows."""
        larger = max((self, other), key=lambda part: -1.0 if part.share is None else part.share)
        return replace(
            larger,
            rows=self.rows + other.rows,
            failures=self.failures + other.failures,
            first=self.first or other.first,
        )

    def at(self, place: str) -> "Check":
        """Return the same result; its first failure says where it is."""
        return replace(self, first=self.first and f"{self.first} {place}")

    @classmethod
    def judged(cls, name: str, labels: Sequence[str], wrong: Marks | Sequence[bool]) -> "Check":
        """Return the check of N labelled rows, given which of them are wrong."""
        marks = np.asarray(wrong)
        first = shortened(labels[int(marks.argmax())]) if marks.any() else None
        return cls(name, len(marks), int(marks.sum()), first=first)

    @classmethod
    def listed(cls, name: str, rows: int, faults: Iterable[str]) -> "Check":
        """Return the check of a number of rows, given their faults."""
        faults = list(faults)
        return cls(name, rows, len(faults), first=faults[0] if faults else None)

    @classmethod
    def single(cls, name: str, label: str, faults: Iterable[str]) -> "Check":
        """Return the check of one row, which reports the first of its faults under its label."""
        return cls.listed(name, 1, [f"{label}: {fault}" for fault in islice(faults, 1)])

    @classmethod
    def measured(cls, name: str, labels: Sequence[str], deviation: Floats, allowed: Floats) -> "Check":
        """Return the check of N labelled rows, given their deviations and the allowed ones; NaN fails.

        The arrays have shape (N,), or (k, N) if each row has k deviations; then the worst one counts.
        """
        share = shares(*np.broadcast_arrays(np.atleast_2d(deviation), allowed))
        check = cls.judged(name, labels, share.max(axis=0) > 1)
        if not share.size:
            return check
        worst = np.unravel_index(share.T.argmax(), share.T.shape)[::-1]
        return replace(check, worst=float(np.atleast_2d(deviation)[worst]), share=float(share[worst]))


def differences(counts: Mapping[str, Any], expected: Mapping[str, Any]) -> Iterator[str]:
    """Yield a fault for each count that is not the expected one."""
    for name, count in expected.items():
        if counts[name] != count:
            yield f"{name} is {counts[name]} instead of {count}"


def shares(deviation: Floats, allowed: Floats) -> Floats:
    """Return deviations divided by the allowed ones; 0 where there is no deviation, infinity for NaN."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(deviation == 0, 0.0, deviation / allowed)
    return np.where(np.isnan(share), np.inf, share)


LISTED = "IN (SELECT value FROM json_each(:ids))"
"""A condition that a column is one of the ids that `Scope.query` is given."""

Ids = dict[int, Integers]
"""Ids of classes or pruned words, in order, for each period."""


@dataclass(frozen=True)
class Scope:
    """What to check, in a catalogue at one moment.

    Attributes
    ----------
    connection : Connection
        A connection in a read transaction.
    selections, sample, restarts, seed
        As for `orbitdb.verification.verify.verify`.
    """

    connection: Connection
    selections: tuple[Selection, ...] = ()
    sample: int | None = None
    restarts: int = 0
    seed: int = 0

    def query(self, sql: str, **values: Any) -> list[Any]:
        """Return the rows of a query, given the values of its names; `LISTED` takes an array of ids."""
        bound = {
            name: json.dumps(value.tolist()) if isinstance(value, np.ndarray) else value
            for name, value in values.items()
        }
        return [tuple(row) for row in self.connection.exec_driver_sql(sql, bound)]

    def scalar(self, sql: str, **values: Any) -> Any:
        """Return the first value of the first row, or None if there is no row."""
        return next(iter(self.query(sql, **values)), (None,))[0]

    def records(self, sql: str) -> list[dict[str, Any]]:
        """Return the rows of a query as dicts, with the names of the columns."""
        return [dict(row) for row in self.connection.exec_driver_sql(sql).mappings()]

    def chooses(self, p: int) -> bool:
        """Tell whether a period is chosen at some a; if there are no selections, all periods are."""
        return not self.selections or any(selection.includes(p) for selection in self.selections)

    def ids(self, rows: str = "cycle", only: Integers | None = None) -> Ids:
        """Return the ids of rows of `cycle` or `pruned`, or only the given ones, in the chosen periods.

        Damaged periods are left out: SQLite's own check reports them.
        """
        query = f"SELECT id, p FROM {rows} WHERE typeof(p) = 'integer' ORDER BY id"
        found = np.array(self.query(query), np.int64).reshape(-1, 2)
        ids, periods = (found if only is None else found[np.isin(found[:, 0], only)]).T
        return {p: ids[periods == p] for p in np.unique(periods).tolist() if self.chooses(p)}

    def sampled(self, ids: Ids, rng: np.random.Generator) -> Ids:
        """Return a random sample of ids, or all of them if they are no more than `sample`."""
        every = np.sort(np.concatenate([np.zeros(0, np.int64), *ids.values()]))
        if self.sample is None or self.sample >= len(every):
            return ids
        drawn = rng.choice(every, self.sample, replace=False)
        return {p: of_period[np.isin(of_period, drawn)] for p, of_period in ids.items()}

    def classes(self, selection: Selection, rng: np.random.Generator) -> Ids:
        """Return the ids of the classes chosen at one a, or of a random sample of them."""
        chosen = arrays_of(self.connection, Words(selection, by_class=True), ())
        return self.sampled(self.ids(only=chosen["id"]), rng)


class Checked(NamedTuple):
    """Result of one step of a verification; a report joins the checks of all steps by name."""

    stage: str
    done: int  # classes of the stage that are checked so far
    total: int
    checks: tuple[Check, ...]


class Part(NamedTuple):
    """A part of a catalogue, with the function that checks it; otherwise like `Checked`."""

    stage: str
    find: Callable[[Scope], Iterable[Check]]
    done: int = 0
    total: int = 1

    def checked(self, scope: Scope) -> Checked:
        """Check the part; damage ends the part, and fails the check ``file``."""
        checks: list[Check] = []
        try:
            checks.extend(self.find(scope))
        except Exception as error:
            checks.append(damage(self.stage, error))
        return Checked(self.stage, self.done, self.total, tuple(checks))


def damage(stage: str, error: Exception) -> Check:
    """Return the failed check for an error that a stored value caused.

    Damage can turn any value into NULL, another type or another number, so the error can be of any kind. Only
    errors of the system, of the user's own expression, signals, and deletions are raised again.
    """
    cause = getattr(error, "orig", None) or error
    if isinstance(cause, sqlite3.OperationalError) and "decode" not in str(cause):
        raise error
    if isinstance(cause, (OSError, MemoryError, WorkError, SelectionError, DeletedError)):
        raise error
    what = cause.what if isinstance(cause, AlteredError) else f"{cause}" or type(cause).__name__
    return Check("file", 1, 1, first=shortened(f"{stage}: {' '.join(what.split())}", 200))


Finder = Callable[[Scope], Iterator[Part]]
"""A function that yields the parts of a catalogue that it checks."""


def parts_of(check: Part | Finder, scope: Scope) -> Iterator[Part]:
    """Yield the parts of a check, and damage that keeps it from finding them."""
    if isinstance(check, Part):
        yield check
        return
    try:
        yield from check(scope)
    except Exception as error:
        found = damage(check.__name__, error)
        yield Part(check.__name__, partial(_found, found))


def _found(check: Check, _: Scope) -> list[Check]:
    return [check]


def checked_apart(path: Path, part: Part, *asked: Any) -> Checked:
    """Check a part in the file as it is now, which is safe because the rows of a class never change."""
    with reading(path) as connection:
        return part.checked(Scope(connection, *asked))


class Block(NamedTuple):
    """Classes or pruned words of one period that are checked together."""

    p: int
    ids: Integers
    done: int  # number of classes or words that are checked after this block
    total: int

    def check_complete(self, rows: Sized) -> None:
        """Raise `DeletedError` if there are fewer rows than classes."""
        if len(rows) < len(self.ids):
            raise DeletedError(f"some of the classes of period {self.p}")

    def part(self, stage: str, find: Callable[["Block", Scope], Iterable[Check]]) -> Part:
        """Return the block as a part that `find` checks."""
        return Part(f"{stage}, p = {self.p}", partial(find, self), self.done, self.total)


def blocks(ids: Ids, size: int = _CLASSES) -> Iterator[Block]:
    """Cut classes into blocks of at most `size`; blocks of long words, with large Hessians, are smaller."""
    done, total = 0, sum(map(len, ids.values()))
    for p, of_period in ids.items():
        step = max(1, min(size, _NUMBERS // p**2))
        for start in range(0, len(of_period), step):
            block = of_period[start : start + step]
            done += len(block)
            yield Block(p, block, done, total)


def stored_orbits(scope: Scope, a: float, block: Block) -> tuple[Integers, Orbits]:
    """Return the ids of the classes of a block that have a row at one a, and these rows, as stored.

    Numbers and coordinates that are missing are NaN.
    """
    names = ("cycle", "status", "coordinates", "iterations", *NUMBERS)
    query = f"""SELECT word, {", ".join(names)} FROM orbit JOIN cycle ON cycle.id = orbit.cycle
        WHERE stadium = (SELECT id FROM stadium WHERE a = :a) AND cycle {LISTED} ORDER BY cycle"""
    rows = scope.query(query, a=a, ids=block.ids)
    words, *columns = zip(*rows, strict=True) if rows else [()] * (1 + len(names))
    values: dict[str, Sequence[Any]] = dict(zip(names, columns, strict=True))
    blank = np.full(block.p, np.nan, dtype="<f8").tobytes()
    coordinates = np.frombuffer(b"".join(blob or blank for blob in values["coordinates"]), dtype="<f8")
    orbits = Orbits(
        words=from_strings(words).reshape(len(rows), block.p),
        status=np.array(values["status"], dtype=str),
        coordinates=coordinates.astype(float).reshape(len(rows), block.p),
        iterations=np.array(values["iterations"], dtype=np.int64),
        **{name: np.array(values[name], dtype=float) for name in NUMBERS},
    )
    return np.array(values["cycle"], np.int64), orbits
