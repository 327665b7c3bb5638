"""``orbitdb lyapunov``: the average Lyapunov exponents over a chosen subset of orbits."""

from typing import Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice
from orbitdb.cli.output import Output, note_results, rows_of
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, reading
from orbitdb.numerals import concise

EXAMPLES = (
    "lyapunov",
    "lyapunov --weight det --p 2-10",
    "lyapunov --cut 9",
    "lyapunov --a 1 --a 1.6 --p 2-8",
)


def lyapunov(
    *,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    weight: Annotated[
        str, typer.Option(help="exp for e^-lambda, as in the paper, or det for 1/|det(1 - M)|.")
    ] = "exp",
    cut: Annotated[
        float | None,
        options.number_option(
            help="Instead, take one zeta average over all pseudo-cycles with lambda up to this."
        ),
    ] = None,
    output: Output,
    db: options.Database,
) -> None:
    """Compute the average Lyapunov exponents over the chosen orbits, by period.

    lambda_d and lambda_c: the paper's eqs. (5) and (6), per bounce and per length. pair: means of
    neighbouring periods. zeta: from the zeta function truncated at p, with its zero z0 (1 if no orbit is
    missing). sum_rule: all orbits up to p with weights e^-lambda, constrained by exact means; a table has an
    estimate of its error in brackets behind the last digits. The trajectory values come from
    'orbitdb simulate'.
    """
    with progress("averaging") as shown, reading(db, a, averaged(choice)) as (catalogue, stadiums):
        from orbitdb.catalogue.averaged import lyapunov as average

        def tell(done: float) -> None:
            shown.tell("summing pseudo-cycles", done, 1.0)

        found = [average(catalogue, chosen, weight, cut, tell) for chosen in stadiums]
    note_results(found, several(a), output.table)
    names, rows = rows_of(found, several(a))
    if not output.table or cut is not None:
        output.write(names, rows)
        return
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    output.write(*_block(columns, "lambda_d", "z0"))
    print()
    output.write(*_block(columns, "lambda_c"))


def _block(
    columns: dict[str, list[Any]], exponent: str, *further: str
) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Return the part of the table that one exponent has, the error in brackets behind the sum rule."""
    block = {name: columns[name] for name in ("a", "p", exponent) if name in columns}
    block |= {method: columns[f"{exponent}_{method}"] for method in ("pair", "zeta")}
    sums = f"{exponent}_sum_rule"
    block["sum_rule"] = list(map(concise, columns[sums], columns[f"{sums}_error"]))
    block |= {name: columns[name] for name in further}
    return list(block), list(zip(*block.values(), strict=True))
