"""The result of a check, and the blocks of classes that any process can check."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from sqlalchemy import Connection

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.errors import AlteredError
from orbitdb.orbits.status import NUMBERS, Orbits
from orbitdb.store import query
from orbitdb.store.file import reading
from orbitdb.store.selection import Selection
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


class Checked(NamedTuple):
    """Result of one step of a verification; a report joins the checks of all steps by name."""

    stage: str
    done: int  # classes of the stage that are checked so far
    total: int
    checks: tuple[Check, ...]


def judged(name: str, labels: Sequence[str], wrong: Marks | Sequence[bool]) -> Check:
    """Return the check of N labelled rows, given which of them are wrong."""
    marks = np.asarray(wrong)
    first = shortened(labels[int(marks.argmax())]) if marks.any() else None
    return Check(name, len(marks), int(marks.sum()), first=first)


def listed(name: str, rows: int, faults: Iterable[str]) -> Check:
    """Return the check of a number of rows, given their faults."""
    faults = list(faults)
    return Check(name, rows, len(faults), first=faults[0] if faults else None)


def single(name: str, label: str, faults: Iterable[str]) -> Check:
    """Return the check of one row, which reports the first of its faults under its label."""
    return listed(name, 1, [f"{label}: {fault}" for fault in islice(faults, 1)])


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


def measured(name: str, labels: Sequence[str], deviation: Floats, allowed: Floats) -> Check:
    """Return the check of N labelled rows, given their deviations and the allowed ones; NaN fails.

    The arrays have shape (N,), or (k, N) if each row has k deviations, of which the worst counts.
    """
    share = shares(*np.broadcast_arrays(np.atleast_2d(deviation), allowed))
    check = judged(name, labels, share.max(axis=0) > 1)
    if not share.size:
        return check
    worst = np.unravel_index(share.T.argmax(), share.T.shape)[::-1]
    return replace(check, worst=float(np.atleast_2d(deviation)[worst]), share=float(share[worst]))


class Part(NamedTuple):
    """A part of a catalogue, with the function that checks it on a connection; otherwise like `Checked`."""

    stage: str
    find: Callable[[Connection], Iterable[Check]]
    done: int = 0
    total: int = 1

    def checked(self, connection: Connection) -> Checked:
        """Check the part; a value that cannot be read ends the part, and fails the check ``file``."""
        checks: list[Check] = []
        try:
            checks.extend(self.find(connection))
        except (AlteredError, TypeError, ValueError) as error:  # damage can make NULL of any value
            what = error.what if isinstance(error, AlteredError) else error
            checks.append(Check("file", 1, 1, first=f"{self.stage}: {what}"))
        return Checked(self.stage, self.done, self.total, tuple(checks))


def checked_apart(path: Path, part: Part) -> Checked:
    """Check a part in the file as it is now, which is safe because the rows of a class never change."""
    with reading(path) as moment:
        return part.checked(moment)


LISTED = "IN (SELECT value FROM json_each(:ids))"
"""A condition that a column is one of the ids given by `as_list`."""


def as_list(ids: Integers) -> str:
    """Return ids as the single value ``:ids`` of `LISTED`."""
    return json.dumps(ids.tolist())


Ids = dict[int, Integers]
"""Ids of classes or pruned words, in order, for each period."""


class Block(NamedTuple):
    """Classes or pruned words of one period that are checked together."""

    p: int
    ids: Integers
    done: int  # number of classes or words that are checked after this block
    total: int

    def part(self, stage: str, find: Callable[["Block", Connection], Iterable[Check]]) -> Part:
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


def is_chosen(p: int, selections: Sequence[Selection]) -> bool:
    """Tell whether a period is chosen at some a; if there are no selections, all periods are."""
    return not selections or any(selection.includes(p) for selection in selections)


def by_period(connection: Connection, table: str = "cycle", only: Integers | None = None) -> Ids:
    """Return the ids in `cycle` or `pruned`, or only the given ones, by period.

    Damaged periods are left out: SQLite's own check reports them.
    """
    query = f"SELECT id, p FROM {table} WHERE typeof(p) = 'integer' ORDER BY id"
    rows = np.array(connection.exec_driver_sql(query).fetchall(), np.int64).reshape(-1, 2)
    ids, periods = (rows if only is None else rows[np.isin(rows[:, 0], only)]).T
    return {p: ids[periods == p] for p in np.unique(periods).tolist()}


def sampled(ids: Integers, sample: int | None, rng: np.random.Generator) -> Integers:
    """Return a random sample of ids, in order, or all ids if there are no more than `sample`."""
    if sample is None or sample >= len(ids):
        return ids
    return np.sort(rng.choice(ids, sample, replace=False))


def sampled_classes(
    connection: Connection, selection: Selection, sample: int | None, rng: np.random.Generator
) -> Ids:
    """Return the ids of the chosen classes, or of a random sample of them, by period."""
    ids = query.choose(connection, selection).ids
    return by_period(connection, only=sampled(np.sort(ids[ids > 0]), sample, rng))


def stadium_id(connection: Connection, a: float) -> int | None:
    """Return the id of the stadium with a given a, or None."""
    number: int | None = connection.exec_driver_sql("SELECT id FROM stadium WHERE a = ?", (a,)).scalar()
    return number


def stored_orbits(connection: Connection, number: int, block: Block) -> tuple[Integers, Orbits]:
    """Return the ids of the classes of a block that have a row at a stadium, and these rows, as stored.

    Numbers and coordinates that are missing are NaN.
    """
    names = ("cycle", "status", "coordinates", "iterations", *NUMBERS)
    query = f"""SELECT word, {", ".join(names)} FROM orbit JOIN cycle ON cycle.id = orbit.cycle
        WHERE stadium = :stadium AND cycle {LISTED} ORDER BY cycle"""
    rows = connection.exec_driver_sql(query, {"stadium": number, "ids": as_list(block.ids)}).fetchall()
    words, *columns = zip(*rows, strict=True) if rows else [()] * (1 + len(names))
    values: dict[str, Sequence[Any]] = dict(zip(names, columns, strict=True))
    blank = np.full(block.p, np.nan, dtype="<f8").tobytes()
    places = np.frombuffer(b"".join(blob or blank for blob in values["coordinates"]), dtype="<f8")
    orbits = Orbits(
        words=from_strings(words).reshape(len(rows), block.p),
        status=np.array(values["status"], dtype=str),
        coordinates=places.astype(float).reshape(len(rows), block.p),
        iterations=np.array(values["iterations"], dtype=np.int64),
        **{name: np.array(values[name], dtype=float) for name in NUMBERS},
    )
    return np.array(values["cycle"], np.int64), orbits
