"""``orbitdb field``: orbits in a magnetic field."""

from itertools import chain, islice
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output, note, progress
from orbitdb.cli.snapshots import given_codes, primitive, snapshot, solving
from orbitdb.errors import InputError

EXAMPLES = (
    "field 0123 --kappa 0:0.3:7",
    "field --kappa 0.05 --p 2-8 --counts",
    "field --kappa 0.1 --p 2-11 --reversal pair --format csv > field.csv",
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
    a: options.StoredHalfLength = None,
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
    from orbitdb.answers.results import Result

    if not kappa:
        raise InputError("say how strong the field is, such as --kappa 0.05")
    named = words or code
    if named:
        options.takes_only(context, "with words", "words", "code", "kappa", "a", "limit")
    if counts:
        options.refuse_idle(context, "with --counts", "limit")
    values = [*chain.from_iterable(kappa)]
    if named:
        codes = [primitive(each) for each in given_codes(words, code)]
        if not codes:
            note("stdin contains no code")
        with progress("following") as shown, solving(db, a) as (catalogue, (at,)):
            orbits = catalogue.field(values, words=codes, a=at, progress=shown)
    else:
        with progress("following") as shown, snapshot(db, a, choice) as (catalogue, (chosen,)):
            orbits = catalogue.field(values, chosen, progress=shown)
    found = orbits.counts() if counts else orbits
    for text in found.notes:
        note(text)
    if isinstance(found, Result):
        output.write([*found.columns], found.rows())
        return
    names = TABLE_COLUMNS if output.for_people else orbits.columns
    most = options.ON_SCREEN if output.table and limit is None else limit
    count = output.write(names, islice(found.rows(names), most))
    if not len(found):
        raise typer.Exit(1)
    if count < len(found):
        note(f"{len(found)} rows; {count} shown, --limit {len(found)} shows all")
