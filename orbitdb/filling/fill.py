"""Fill a catalogue with the orbits of periods or single words at a given a, with births, or pruned words.

A period is cut into blocks, which any process can enumerate and solve. The result of a block depends only on
its input, not on where or in which order blocks are solved. How a period that was stopped is continued, is in
`orbitdb.filling.period_jobs`.
"""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import thread_time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Integers
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.filling.estimate import check_room, need, need_of_pruned
from orbitdb.filling.period_jobs import PeriodJob, Step, resume, run_steps
from orbitdb.filling.workers import HERE, Task, Workers, at_work, number_of
from orbitdb.orbits.admissible import solve_admissible, solve_periods
from orbitdb.orbits.births import find_changes
from orbitdb.orbits.orbit import Orbit, pruned_words
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.relaxation import relax
from orbitdb.orbits.status import Status
from orbitdb.period_ranges import LEAST_PERIOD
from orbitdb.progress import Tell, nobody
from orbitdb.store import storing, tables
from orbitdb.store.cursors import Cursor, OvertakenError, open_cursor
from orbitdb.store.file import reading
from orbitdb.store.lookup import find_words
from orbitdb.store.periods import (
    count_births,
    counts_when_done,
    pruned_up_to,
    read_birth_fills,
    status_counts,
    words_up_to,
)
from orbitdb.store.writer import Writer
from orbitdb.symbols.enumeration import Span, all_least_words, class_spans, primitive_spans, primitive_words
from orbitdb.symbols.pruning import FAMILY, RULES, count_admissible, count_pruned, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import SIZES, SymmetryClass, class_of, joined_words
from orbitdb.symbols.words import (
    from_strings,
    key,
    keys,
    pack,
    parse_primitive,
    read_words,
    to_strings,
    unpack,
)

if TYPE_CHECKING:
    from orbitdb.store.sqlite import Connection


@dataclass(frozen=True)
class Method:
    """A solver ``(words, stadium)`` for words of one period, shape (N, p).

    `words` is the number of words that it solves in about half a second, the size of a block.
    """

    solve: Callable[..., Orbits]
    words: int


_WORDS_A_CLASS = 4
"""Assumed words per class. Most classes have 8, but most spans have fewer classes than estimated."""

_BLOCKS_A_JOB = 3
_SMALLEST = 4
"""Ratio of the largest block to the smallest; smaller blocks would take more time per word."""

METHODS = {
    "newton": Method(partial(solve_admissible, every=False), 1 << 16),
    "relaxation": Method(relax, 1 << 8),
}


@dataclass(frozen=True, eq=False)
class SolvedBlock:
    """The N classes of a span, in the order of their representatives, and their orbits or changes.

    The words are those of each class (`joined_words`), or None if they are already stored. `enumerating` and
    `solving` are processor times in seconds.
    """

    span: Span
    codes: Integers
    stabiliser: NDArray[np.uint8]
    words: list[str] | None
    solution: Any
    enumerating: float
    solving: float
    arithmetic: str


def solve_block(solve: Callable[[NDArray[np.uint8]], Any], stored: bool, span: Span) -> SolvedBlock:
    """Find the classes whose representatives, shape (N, p), lie in a span, and solve these.

    If the classes are already stored, their words are left out.
    """
    clock = [thread_time()]
    codes, stabiliser = all_least_words(span)
    words = None if stored else joined_words(codes, stabiliser, span.p)
    clock.append(thread_time())
    solution = solve(unpack(codes, span.p))
    clock.append(thread_time())
    enumerating, solving = np.diff(clock).tolist()
    return SolvedBlock(span, codes, stabiliser, words, solution, enumerating, solving, arithmetic())


def cut_into_spans(p: int, after: int, words: int, jobs: int) -> Iterator[Span]:
    """Cut the part of a period after a packed word into spans of about `words` words, in order.

    With several jobs, the spans of a small period are smaller, so that no job runs out of work early.
    """
    if jobs > 1:
        words = min(words, max(count_admissible(p) // (_BLOCKS_A_JOB * jobs), words // _SMALLEST))
    return class_spans(p, max(words // _WORDS_A_CLASS, 1), after)


def cut_into_blocks(
    a: float, method: str, p: int, after: int = -1, jobs: int = 1, stored: bool = False
) -> Iterator[Task[SolvedBlock]]:
    """Cut the part of a period after a packed word into blocks, in order."""
    solve = partial(METHODS[method].solve, stadium=Stadium(a))
    spans = cut_into_spans(p, after, METHODS[method].words, jobs)
    return (partial(solve_block, solve, stored, span) for span in spans)


def fill(
    path: Path,
    a: float,
    periods: Sequence[int],
    jobs: int | None = None,
    workers: Workers | None = None,
    geometric: bool = False,
    method: str = "newton",
    tell: Tell = nobody,
) -> None:
    """Fill the given periods at the given a (`Catalogue.fill`)."""
    check_method(method)
    number = number_of(jobs, workers)
    coming = need(path, a, periods, number, method)
    further = need_of_pruned(path, periods if geometric else (), number)
    check_room(path, coming, further)
    with at_work(coming.alone, jobs, workers) as solving:
        words = {p: count_admissible(p) for p in periods}
        steps = fill_periods(path, a, periods, method, solving)
        run_steps(steps, "words", words, tell, sum(words.values()) - coming.words)
    if geometric:
        words = {p: count_pruned(p) for p in periods}
        with at_work(further.alone, jobs, workers) as listing:
            steps = fill_geometric(path, periods, listing)
            run_steps(steps, "pruned words", words, tell, sum(words.values()) - further.words)


def fill_periods(
    path: Path, a: float, periods: Iterable[int], method: str = "newton", workers: Workers = HERE
) -> Generator[Step]:
    """Store all admissible words of the given periods, and their orbits at the given a (see `resume`).

    The file must have the latest schema. Periods that are already filled are skipped. The stored rows do not
    depend on the workers.
    """
    stadium, periods = Stadium(a), list(periods)
    parameters = {"command": "fill", "a": a, "periods": periods, "method": method}
    few = [p for p in periods if count_admissible(p) <= METHODS[method].words]
    with closing(Writer(path, parameters, references=False)) as writer:
        work = _Fill(writer, stadium.a, method)
        yield from resume(work, few, HERE)  # done before other processes could start
        yield from resume(work, periods, workers)  # including those of the few that were deleted meanwhile


class _Fill(PeriodJob):
    def __init__(self, writer: Writer, a: float, method: str) -> None:
        super().__init__(writer)
        self.a, self.method = a, method
        self.stored: set[int] = set()  # periods whose classes are stored

    def open(self, connection: "Connection", p: int) -> Cursor:
        if storing.classes_stored(connection, p):
            self.stored.add(p)
        else:
            self.stored.discard(p)
        return open_cursor(connection, tables.fill, stadium=self.writer.stadium_id(connection, self.a), p=p)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[SolvedBlock]]:
        p = cursor.p
        return cut_into_blocks(self.a, self.method, p, cursor.after, jobs, p in self.stored)

    def store(self, connection: "Connection", cursor: Cursor, part: SolvedBlock) -> dict[str, float]:
        begun, orbits = thread_time(), part.solution.with_symmetries(part.stabiliser)
        numbers = keys(part.codes, cursor.p).tolist()
        if part.words is None and not storing.classes_stored(connection, cursor.p):
            raise OvertakenError  # deleted since the block was begun without them
        if part.words is not None:
            storing.add_classes(connection, numbers, orbits.words, part.stabiliser, part.words)
        stadium, by = cursor.row["stadium"], (self.method, part.arithmetic)
        storing.add_orbits(self.writer, connection, stadium, numbers, orbits, *by)
        return {
            "words": int(SIZES[part.stabiliser].sum()),
            "enumerating": part.enumerating,
            "solving": part.solving,
            "storing": thread_time() - begun,
        }

    def counted(self, connection: "Connection", cursor: Cursor) -> tuple[int, dict[str, Any]]:
        counts = status_counts(connection, cursor.row["stadium"], cursor.p).get(cursor.p, {})
        words = sum(count for count, _ in counts.values())
        return words, counts_when_done(cursor.p, counts) | {"words": words}


PRUNED_BLOCK = 1 << 17
"""Most words, pruned or not, in a block of pruned words."""

_RULES = [",".join(map(str, rule_numbers(mask))) for mask in range(1 << len(RULES))]
"""The text for each set of broken rules."""


@dataclass(frozen=True, eq=False)
class PrunedBlock:
    """The geometrically pruned words of a span, in order, and the rules that each of them breaks."""

    span: Span
    words: list[str]
    rules: list[str]


def find_pruned(span: Span) -> PrunedBlock:
    """Find the geometrically pruned primitive words in a span."""
    words, rules = list[str](), list[str]()
    for every in primitive_words(span):
        masks = rules_broken(every)
        if span.p == len(FAMILY):
            masks[keys(pack(every), span.p) == key(FAMILY)] = 0
        words += to_strings(every[masks > 0])
        rules += [_RULES[mask] for mask in masks[masks > 0].tolist()]
    return PrunedBlock(span, words, rules)


def fill_geometric(path: Path, periods: Iterable[int], workers: Workers = HERE) -> Generator[Step]:
    """Store the geometrically pruned primitive words of the given periods, with the rules that they break.

    Yields a `Step` after every stored block (`resume`).
    """
    periods = sorted(set(periods))
    with closing(Writer(path, {"command": "fill --geometric", "periods": periods})) as writer:
        yield from resume(_Pruned(writer), periods, workers)


class _Pruned(PeriodJob):
    def total(self, p: int) -> int:
        return count_pruned(p)

    def open(self, connection: "Connection", p: int) -> Cursor:
        return open_cursor(connection, tables.pruned_fill, p=p)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[PrunedBlock]]:
        return (partial(find_pruned, span) for span in primitive_spans(cursor.p, PRUNED_BLOCK, cursor.after))

    def store(self, connection: "Connection", cursor: Cursor, part: PrunedBlock) -> dict[str, float]:
        # backwards, because ids fall as words rise, and ascending ids fill the pages of the table better
        storing.add_pruned(connection, cursor.p, part.words[::-1], part.rules[::-1])
        return {"words": len(part.words)}

    def counted(self, connection: "Connection", cursor: Cursor) -> tuple[int, dict[str, Any]]:
        return pruned_up_to(connection, cursor.p, "5" * cursor.p), {}


def check_method(method: str) -> None:
    """Raise `InputError` unless a method is one of `METHODS`."""
    if method not in [*METHODS]:
        raise InputError(f"method {method!r:.40}: use {' or '.join(METHODS)}")


def check_word(code: str) -> str:
    """Read a primitive word that a catalogue can store; raise `InputError` for others."""
    word = parse_primitive(code)
    if len(word) < LEAST_PERIOD:
        raise InputError(f"{word} has one symbol, but orbits have two or more: give a longer word")
    return word


def fill_words(
    path: Path, codes: Iterable[str], a: float, method: str = "newton", errors: str = "raise"
) -> list[Orbit]:
    """Store primitive words of any periods, with their classes and orbits at a (`Catalogue.fill`).

    One transaction stores them all. Those that are stored already are not solved again.
    """
    words = read_words(codes, errors, check_word)
    check_method(method)
    named = words[0] if len(words) == 1 else f"{len(words)} words"
    parameters = {"command": "fill", "a": a, "code": named, "method": method}
    with closing(Writer(path, parameters)) as writer:
        with writer.reading() as connection:
            found = find_words(connection, words, a)
        new = dict.fromkeys(word for word, orbit in zip(words, found, strict=True) if orbit is None)
        pruned = pruned_words(new, a)
        family = {word: orbit for word, orbit in pruned.items() if orbit.status is Status.FAMILY}
        if len(new) > len(family):
            classes = map(class_of, (word for word in new if word not in pruned))
            solved = [*_solved({each.representative: each for each in classes}.values(), a, method)]
            with writer.transaction() as connection:
                _store_pruned(connection, pruned.values())
                stadium = writer.stadium_id(connection, a) if solved else 0
                for of_period, orbits in solved:
                    numbers = storing.add_families(connection, of_period)
                    storing.add_orbits(writer, connection, stadium, numbers, orbits, method)
                found = find_words(connection, words, a)
    return [orbit or family[word] for word, orbit in zip(words, found, strict=True)]


def _solved(
    families: Iterable[SymmetryClass], a: float, method: str
) -> Iterator[tuple[list[SymmetryClass], Orbits]]:
    """Yield classes and the orbits of their representatives, period by period."""
    periods: dict[int, list[SymmetryClass]] = {}
    for family in families:
        periods.setdefault(len(family.representative), []).append(family)
    groups = [from_strings([family.representative for family in group]) for group in periods.values()]
    stadium = Stadium(a)
    if method == "newton":
        solved = solve_periods(groups, stadium, every=False)
    else:
        solved = [METHODS[method].solve(words, stadium) for words in groups]
    for group, orbits in zip(periods.values(), solved, strict=True):
        stabilisers = np.array([family.stabiliser for family in group], np.uint8)
        yield group, orbits.with_symmetries(stabilisers)


def _store_pruned(connection: "Connection", pruned: Iterable[Orbit]) -> None:
    """Store geometrically pruned words of any periods, but not the family 02."""
    periods: dict[int, dict[str, str]] = {}
    for word in pruned:
        if word.status is not Status.FAMILY:
            periods.setdefault(word.p, {})[word.representative] = ",".join(map(str, word.rules))
    for p, rules in periods.items():
        storing.add_pruned(connection, p, [*rules], [*rules.values()])


BIRTHS_BLOCK = 1 << 17
"""Approximate number of words in a block of births, which takes a few seconds."""

_BIRTHS_A_SECOND = 40_000
"""Approximate number of words for which births are found per second."""


def find_births(path: Path, periods: Sequence[int], jobs: int | None = None, tell: Tell = nobody) -> None:
    """Find and store all births and deaths of the given periods (`Catalogue.fill_births`)."""
    totals = {p: count_admissible(p) for p in periods}
    with reading(path) as connection:
        stored = sum(births.words for births in read_birth_fills(connection) if births.p in totals)
    with at_work((sum(totals.values()) - stored) / _BIRTHS_A_SECOND, jobs) as workers:
        run_steps(fill_births(path, periods, workers), "births", totals, tell, stored)


def fill_births(path: Path, periods: Iterable[int], workers: Workers = HERE) -> Generator[Step]:
    """Find and store all births and deaths of the given periods; yield a `Step` after every stored block."""
    periods = sorted(set(periods))
    with closing(Writer(path, {"command": "births", "periods": periods}, references=False)) as writer:
        yield from resume(_Births(writer), periods, workers)


class _Births(PeriodJob):
    def open(self, connection: "Connection", p: int) -> Cursor:
        return open_cursor(connection, tables.birth_fill, p=p)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[SolvedBlock]]:
        spans = cut_into_spans(cursor.p, cursor.after, BIRTHS_BLOCK, jobs)
        return (partial(solve_block, find_changes, False, span) for span in spans)

    def store(self, connection: "Connection", cursor: Cursor, part: SolvedBlock) -> dict[str, float]:
        numbers = keys(part.codes, cursor.p).tolist()
        least, words = unpack(part.codes, cursor.p), part.words or []
        storing.add_classes(connection, numbers, least, part.stabiliser, words)
        storing.add_changes(self.writer, connection, numbers, part.solution, part.arithmetic)
        return {"words": int(SIZES[part.stabiliser].sum())}

    def counted(self, connection: "Connection", cursor: Cursor) -> tuple[int, dict[str, Any]]:
        return words_up_to(connection, None, cursor.p, "5" * cursor.p), {}

    def closing(self, connection: "Connection", cursor: Cursor) -> dict[str, Any]:
        storing.number_events(connection, cursor.p)
        return count_births(connection, cursor.p)
