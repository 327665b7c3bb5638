"""What commands that store share: periods that are asked for, the newest schema, how far they have come."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from orbitdb.cli.options import refuse_idle
from orbitdb.cli.progress import Progress, progress
from orbitdb.cli.render import note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.filling.resuming import Progress as Step
    from orbitdb.store.file.migrate import Migration

_LEAST = 2
"""No orbit has fewer bounces."""


def bring(path: Path) -> "Migration":
    """Make a catalogue, or bring an older one to the newest schema and say where its copy is."""
    from orbitdb.store.file.migrate import migrate

    with progress("bringing the catalogue to the newest schema"):
        done = migrate(path)
    if done.backup is not None:
        note(f"{path}: schema {done.before} -> {done.after}; as it was, it is kept in {done.backup}")
    return done


def asked_periods(context: typer.Context, p: str, first: int) -> tuple[int, ...]:
    """Return the periods that --p and --from ask for, in rising order.

    Raises
    ------
    InputError
        If they cannot be read, or one of them cannot be filled.
    """
    from orbitdb.store.asking.parsing import parse_periods

    if "-" in p[1:] or "," in p:
        refuse_idle(context, f"with --p {p}", "first")
        return _all_of(parse_periods(p))
    return _all_of(((first, _highest(p)),))


def written(periods: Sequence[int]) -> str:
    """Write periods in rising order, as a range if none is left out."""
    gapless = len(periods) == periods[-1] - periods[0] + 1
    return f"{periods[0]}..{periods[-1]}" if gapless else ", ".join(map(str, periods))


def _highest(text: str) -> int:
    from orbitdb.numerals import whole

    try:
        return whole(text)
    except ValueError:
        raise InputError(f"--p {text!r:.40}: write periods as 11, 2-8 or 2,3,5-7") from None


def _all_of(spans: Sequence[tuple[int, int]]) -> tuple[int, ...]:
    """Return periods to fill in rising order.

    Raises
    ------
    InputError
        If one of them cannot be filled, or a range runs backwards.
    """
    from orbitdb.symbols.enumeration import MAX_PERIOD

    for first, last in spans:
        if (least := min(first, last)) < _LEAST:
            raise InputError(f"period {least}: the least period is {_LEAST}")
        if (most := max(first, last)) > MAX_PERIOD:
            raise InputError(f"period {most}: fill periods of {MAX_PERIOD} or less")
        if first > last:
            raise InputError(f"periods {first} to {last} run backwards: give --from {last} or less")
    return tuple(sorted({p for first, last in spans for p in range(first, last + 1)}))


def show_steps(
    shown: Progress, steps: "Iterable[Step]", what: str, totals: Mapping[int, int], known: int = 0
) -> None:
    """Take the steps of a fill, and show how far all its periods are, of which some words were known."""
    total = sum(totals.values())
    shown.tell(what, known, total)
    for step in steps:
        before = sum(count for p, count in totals.items() if p < step.p)
        shown.tell(f"{what}, p = {step.p:>2} of {max(totals)}", before + step.words, total)
