"""How far periods are filled, and the counts of the finished ones."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import sqlalchemy as sa

from orbitdb.numerals import exact
from orbitdb.store.file.schema import DONE
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import MAX_PACKED

_USUAL = 11
"""The highest period of a first fill, as everywhere in what users are told."""

_SHOWN = 6
"""Values of a that are told at most."""

_SINGLE = "'orbitdb fill --code WORD' stores single words"


@dataclass(frozen=True)
class Fill:
    """How far a period is filled at one a, and the counts of the paper's Table 1.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``; there are no counts before it is done.
    words : int
        Words stored so far.
    seconds : float
        Time spent.
    enumerating, solving, storing : float
        Time of processors spent on words and their classes, on orbits, and on the database (seconds).
    primitive : int or None
        All primitive cyclic words of the period.
    pruned : tuple of int or None
        How many of them break rule 1, 2 .. 6.
    n_t, n_c : int or None
        Words left after geometric pruning, and orbits.
    classes : int or None
        Symmetry classes of the orbits.
    boundary, unresolved : int or None
        Words of these statuses.
    """

    p: int
    state: str
    words: int
    seconds: float
    enumerating: float
    solving: float
    storing: float
    primitive: int | None
    pruned: tuple[int | None, ...]
    n_t: int | None
    n_c: int | None
    classes: int | None
    boundary: int | None
    unresolved: int | None

    @property
    def whole(self) -> bool:
        """Whether all words of the period are stored; if not, a fill goes on or was stopped."""
        return self.state == DONE


def as_fill(row: sa.Row[Any]) -> Fill:
    """Return a row of the table ``fill``.

    Raises
    ------
    StoreError
        If its period cannot have been filled.
    """
    values = row._mapping
    if not 2 <= values["p"] <= MAX_PACKED:
        raise unsound("a filled period of", values["p"])
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (each.name for each in fields(Fill) if each.name != "pruned")
    return Fill(pruned=pruned, **{name: values[name] for name in names})


def describe_fills(fills: Sequence[Fill], a: float) -> str:
    """Say in a few words what is filled at one a."""
    whole, partial = ([fill.p for fill in fills if fill.whole is state] for state in (True, False))
    parts = [written_periods(whole)] if whole else []
    parts += [f"{written_periods(partial)} in part"] if partial else []
    return f"{' and '.join(parts) or 'no whole period'} at a = {exact(a)}"


def describe_partial(fills: Sequence[Fill], a: float, left_out: bool = False) -> str:
    """Say in one line that periods are stored in part, and what completes them.

    Parameters
    ----------
    fills : sequence of Fill
        One period or more at one a, none of them whole.
    a : float
        The stadium.
    left_out : bool, optional
        Whether what is shown does without them.
    """
    many = len(fills) > 1
    periods = ", ".join(str(fill.p) for fill in fills)
    return (
        f"period{'s' * many} {periods} at a = {a:g} {'are' if many else 'is'} partial"
        f"{' and left out' * left_out}: a fill goes on or was stopped; "
        f"'orbitdb fill --p {max(fill.p for fill in fills)} --a {a:g}' completes {'them' if many else 'it'}"
    )


def describe_unfilled(
    known: Sequence[Fill], periods: Sequence[tuple[int, int]], a: float, filled_at: Sequence[float]
) -> str | None:
    """Say in one line which of the periods asked for are not filled, what is, and what fills them.

    Periods that are stored in part are left to `describe_partial`.

    Parameters
    ----------
    known : sequence of Fill
        What is filled at the one a that is asked for, whole or in part.
    periods : sequence of (int, int)
        The ranges of periods that are asked for, both ends in them; empty for all that are filled.
    a : float
        The stadium.
    filled_at : sequence of float
        The values of a at which something is filled.

    Returns
    -------
    str or None
        None if nothing that is asked for is missing. What has no words (periods below 2) is not missing.
    """
    if not periods and known:
        return None
    asked, stored = periods or [(2, _USUAL)], {fill.p for fill in known}
    within = [p for p in range(2, MAX_PERIOD + 1) if any(low <= p <= high for low, high in asked)]
    gaps = [p for p in within if p not in stored]
    beyond = [(max(low, MAX_PERIOD + 1), high) for low, high in asked if high > MAX_PERIOD]
    if not gaps and not beyond:
        return None
    spans = joined_spans([*((p, p) for p in gaps), *beyond])
    verb = "are" if _many(spans) else "is"
    what = f"{_written(spans)} {verb} not filled" if periods else "nothing is filled"
    command = f"'orbitdb fill --p {gaps[-1]} --a {exact(a)}'" if gaps else ""
    remedy = f"{command} fills {_written(spans) if not periods else 'them' if _many(spans) else 'it'}"
    if beyond:
        remedy = f"fills end at period {MAX_PERIOD}{f' ({command})' if gaps else ''}, {_SINGLE}"
    return f"{what} at a = {exact(a)}{_filled(known, a, filled_at)}: {remedy}"


def _filled(known: Sequence[Fill], a: float, filled_at: Sequence[float]) -> str:
    """Say in parentheses what is filled at one a, and at which others something is; empty if nothing is."""
    here = joined_spans([(fill.p, fill.p) for fill in known if fill.whole])
    others = sorted((other for other in filled_at if other != a), key=lambda other: abs(other - a))
    parts = [_written(here)] if here else []
    if others:
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        parts.append(f"some at a = {', '.join(map(exact, sorted(others[:_SHOWN])))}{more}")
    return f" (filled: {'; '.join(parts)})" if parts else ""


def written_periods(periods: Sequence[int]) -> str:
    """Write periods as ranges, such as "periods 2-8, 11"."""
    return _written(joined_spans([(p, p) for p in periods]))


def joined_spans(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return ranges of periods in order, those that touch or overlap as one."""
    joined: list[tuple[int, int]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + 1:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def _many(spans: Sequence[tuple[int, int]]) -> bool:
    return len(spans) > 1 or spans[0][0] < spans[0][1]


def _written(spans: Sequence[tuple[int, int]]) -> str:
    ranges = (str(low) if low == high else f"{low}-{high}" for low, high in spans)
    return f"period{'s' * _many(spans)} {', '.join(ranges)}"
