"""Writing results by period, at one a or at several, and what is to be said of them."""

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli import render
from orbitdb.cli.half_lengths import Answer, joined
from orbitdb.cli.options import Format

if TYPE_CHECKING:
    from orbitdb.store.reading.results import Result

Write = Callable[[Sequence[str], Sequence[Sequence[Any]]], object]


def write_results(
    found: "Sequence[Result]",
    many: bool,
    form: Format,
    hidden: Collection[str] = (),
    write: Write | None = None,
) -> None:
    """Write what is found at one a, or at several, and its notes; leave if there is nothing.

    Parameters
    ----------
    found : sequence of Result
    many : bool
        Whether there may be several a, which are named then.
    form : Format
    hidden : collection of str, optional
        Columns that a table does without, as a note tells of them.
    write : callable, optional
        What writes the table, by default as usual.
    """
    for each in found:
        for text in (*each.notes, *(each.facts if form is Format.TABLE else ())):
            here = f"a = {each.selection.a:g}"
            render.note(f"{here}: {text}" if many and here not in text else text)
    answers = []
    for each in filter(len, found):
        names = [name for name in each.columns if form is not Format.TABLE or name not in hidden]
        answers.append(Answer(each.selection.a, names, [list(row) for row in each.rows(names)]))
    if not answers:
        raise typer.Exit(1)
    names, rows = joined(answers, many)
    if write is not None:
        write(names, rows)
    else:
        render.write(names, rows, form)
