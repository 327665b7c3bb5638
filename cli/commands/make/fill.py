"""``orbitdb fill``: enumerate, solve and store."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from orbitdb.cli.arguments import given_codes, primitive
from orbitdb.cli.options import Database, HalfLength, count_option, takes_only
from orbitdb.cli.progress import progress
from orbitdb.cli.render import code_text, note
from orbitdb.cli.storing import DryRun, Solvers, announce, asked_periods, bring, show_steps, written
from orbitdb.errors import InputError
from orbitdb.plaintext import several

EXAMPLES = (
    "fill --p 11",
    "fill --from 12 --p 13 --a 1",
    "fill --p 15 --jobs 4",
    "fill --p 10 --method relaxation --scheduler tcp://node1:8786",
    "fill --code '1^20(02)^5 3'",
)


def fill(
    *,
    context: typer.Context,
    asked: Annotated[
        str | None,
        typer.Option("--p", metavar="PERIODS", help="The highest period to fill, or periods such as 2-8."),
    ] = None,
    first: Annotated[int, count_option("--from", help="The lowest period to fill.")] = 2,
    a: HalfLength = 1.6,
    code: Annotated[
        list[str] | None, typer.Option(help="Store this word only; repeatable; - reads words from stdin.")
    ] = None,
    geometric: Annotated[
        bool,
        typer.Option(
            "--geometric", help="Also keep the geometrically pruned words, with the rules they break."
        ),
    ] = False,
    method: Annotated[str, typer.Option(help="newton or relaxation (the paper's, slow).")] = "newton",
    solvers: Solvers,
    dry_run: DryRun = False,
    db: Database,
) -> None:
    """Fill a catalogue: all words of every period, and the orbits among them.

    A fill that was interrupted goes on where it stopped; finished periods are skipped.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.filling.estimate import check_room, need
    from orbitdb.filling.periods import METHODS, fill_geometric, fill_periods
    from orbitdb.orbits.orbit import Status
    from orbitdb.symbols.counting import count_admissible, count_primitive

    Stadium(a)
    if method not in METHODS:
        raise InputError(f"method {method!r}: use {' or '.join(METHODS)}")
    if code:
        takes_only(context, "with --code", "code", "a", "method", "dry_run")
        _fill_words([primitive(each) for each in given_codes(code)], a, method, db, dry_run)
        return
    if asked is None:
        raise InputError("say what to fill: --p 11 for the periods up to 11, or --code 1232131 for one word")
    periods = asked_periods(context, asked, first)
    span, coming = f"p = {written(periods)} at a = {a:g}", need(db, a, periods, solvers.number(), method)
    announce(span, coming, db, dry_run)
    if dry_run:
        return
    check_room(db, coming)
    start = time.monotonic()
    with solvers.at_work(coming.words, METHODS[method].words) as workers:
        bring(db)
        with progress(span) as shown:
            words = {p: count_admissible(p) for p in periods}
            steps = fill_periods(db, a, periods, method, workers)
            show_steps(shown, steps, "words", words, sum(words.values()) - coming.words)
            if geometric:
                words = {p: count_primitive(p) for p in periods}
                show_steps(shown, fill_geometric(db, periods), "pruned words", words)
    with Catalogue(db) as catalogue:
        fills = [fill for fill in catalogue.fills(a) if fill.p in periods]
        pruned = catalogue.count(a=a, p=periods, status=Status.GEOMETRIC) if geometric else 0
    n_t, n_c = (sum(getattr(fill, name) or 0 for fill in fills) for name in ("n_t", "n_c"))
    stored = f"{several(n_t, 'word')}, {several(n_c, 'orbit')}"
    stored += f", {several(pruned, 'geometrically pruned word')}" if geometric else ""
    note(f"{span}: {stored}, {time.monotonic() - start:.1f} s, in {db}")


def _fill_words(words: Sequence[str], a: float, method: str, db: Path, dry_run: bool) -> None:
    from orbitdb.filling.periods import fill_word

    if dry_run:
        note(f"{len(words)} words to solve at a = {a:g}, in {db}")
        return
    bring(db)
    for word in words:
        found = fill_word(db, word, a, method)
        kept = "" if found.stored else "; not stored"
        note(f"{code_text(word)}: {found.status.sentence}{kept}")
