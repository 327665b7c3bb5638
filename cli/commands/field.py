"""``orbitdb field``: orbits in a magnetic field."""

from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import not_shown, note, notes, progress
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import given_codes, primitive_words, snapshot, solving
from orbitdb.errors import InputError
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.answers.field import FieldOrbits

EXAMPLES = (
    "field 0123 --kappa 0:0.3:7",
    "field --kappa 0.05 --p 2-8 --counts",
    "field --kappa 0.1 --p 2-11 --time-reversal pair --format csv > field.csv",
)

TABLE_COLUMNS = ("code", "kappa", "status", "action", "area", "lyapunov", "splitting")
"""Columns of a table; they fit into 80 characters."""


def field(
    *,
    context: typer.Context,
    words: options.Words = None,
    code: options.Codes = None,
    kappa: options.Kappa = None,
    counts: Annotated[
        bool, typer.Option("--counts", help="Count the orbits of whole periods instead of listing words.")
    ] = False,
    by_bounce: options.ByBounce = False,
    a: options.HalfLength = None,
    choice: SelectionOptions,
    limit: options.Limit = None,
    output: Output,
    db: options.Database,
) -> None:
    """Follow orbits into a magnetic field, where paths are arcs of circles.

    kappa is the curvature of the arcs, 1 / (cyclotron radius) = e B R / (m v) for a stadium of radius R. Each
    word is followed from its fixed point without a field, also if that is not an orbit; the options that
    choose rows apply to the numbers without a field. The status is orbit, elliptic (a stable orbit), joint (a
    bounce has left its wall), grazing (an arc meets the boundary too early) or unresolved (it could not be
    followed). The action is S = L - kappa A, and splitting is the action of the reverse minus that of the
    word. Nothing is stored.
    """
    if not kappa:
        raise InputError("say how strong the field is, such as --kappa 0.05")
    if words or code:
        options.takes_only(context, "with words", "words", "code", "kappa", "by_bounce", "a", "limit")
    if counts:
        options.refuse_idle(context, "with --counts", "by_bounce", "limit")
    orbits = _followed([*chain.from_iterable(kappa)], words, code, a, choice, db)
    found = orbits.counts() if counts else orbits
    notes(found.notes)
    if by_bounce:
        from orbitdb.orbits.bounces import BOUNCE_COLUMNS

        rows = islice(orbits.by_bounce(), output.most(limit))
        count, total = (
            output.write(("code", "kappa", *BOUNCE_COLUMNS), rows),
            int(orbits.p[orbits.exists].sum()),
        )
        if count < total:
            note(f"{several(total, 'bounce')}{not_shown(count, total)}")
        if not total:
            raise typer.Exit(1)
        return
    names = TABLE_COLUMNS if output.for_people and not counts else [*found.columns]
    count = output.write(names, islice(found.rows(names), None if counts else output.most(limit)))
    if not len(found):
        raise typer.Exit(1)
    if count < len(found):
        note(f"{len(found)} rows{not_shown(count, len(found))}")


def _followed(
    kappa: list[float],
    words: list[str] | None,
    code: list[str] | None,
    a: float | None,
    choice: SelectionOptions,
    db: Path,
) -> "FieldOrbits":
    """Follow the given words into the field, or else the chosen ones."""
    if not (words or code):
        with progress("following") as shown, snapshot(db, a, choice, usual=()) as (catalogue, (chosen,)):
            return catalogue.field(kappa, chosen, progress=shown)
    codes = primitive_words(given_codes(words, code))
    if not codes:
        note("stdin contains no code")
    with progress("following") as shown, solving(db, a) as (catalogue, (at,)):
        return catalogue.field(kappa, code=codes, a=at, progress=shown)
