"""``orbitdb lyapunov``: the average Lyapunov exponents over a chosen subset of orbits."""

import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice, with_choice
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.reading import averaged, reading_all
from orbitdb.cli.render import write
from orbitdb.cli.rows import write_results
from orbitdb.numerals import concise

EXAMPLES = """
Examples:

  orbitdb lyapunov

  orbitdb lyapunov --weight det --p 2-10

  orbitdb lyapunov --cut 9

  orbitdb lyapunov --a 1 --a 1.6 --p 2-8
"""


@with_choice
def lyapunov(
    *,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    weight: Annotated[
        str, typer.Option("--weight", help="exp: e^-lambda, as in the paper; det: 1/|det(1 - M)|.")
    ] = "exp",
    cut: Annotated[
        float | None,
        options.number_option(
            "--cut", help="One zeta average over all pseudo-cycles of lambda up to this, instead."
        ),
    ] = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the average Lyapunov exponents over the chosen orbits, by period.

    lambda_d and lambda_c: the paper's eqs. (5) and (6), per bounce and per length; pair: means of
    neighbouring periods; zeta: from the zeta function cut off at p, with its zero z0 (1 if nothing is
    missing); sum_rule: all orbits up to p with weights e^-lambda, held to exact means, with an estimate
    of the error, in brackets behind the last digits in a table. The trajectory values are those that
    'orbitdb simulate' has stored.
    """
    form, many = options.chosen(format_, json), several(a)
    with progress("averaging") as shown, reading_all(db, a, averaged(choice)) as (catalogue, stadiums):
        from orbitdb.catalogue.averaged import lyapunov as average

        def tell(done: float) -> None:
            shown.tell("summing pseudo-cycles", done, 1.0, counted=False)

        found = [average(catalogue, chosen, weight, cut, tell) for chosen in stadiums]
    if form is Format.TABLE and cut is None:
        write_results(found, many, form, write=_write_blocks)
    else:
        write_results(found, many, form)


_METHODS = ("pair", "zeta", "sum_rule")
_EXPONENTS = ("lambda_d", "lambda_c")


def _write_blocks(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write averages to stdout, by period, z0 in the first block.

    Parameters
    ----------
    names : sequence of str
        Those of the other formats.
    rows : sequence of sequences
        Theirs; None where an average does not stand.
    """
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    for number, exponent in enumerate(_EXPONENTS):
        block = {name: columns[name] for name in ("a", "p", exponent) if name in columns}
        block |= {method: columns[f"{exponent}_{method}"] for method in _METHODS}
        errors = columns[f"{exponent}_sum_rule_error"]
        block["sum_rule"] = list(map(concise, block["sum_rule"], errors))
        if number:
            sys.stdout.write("\n")
        else:
            block["z0"] = columns["z0"]
        write(list(block), list(zip(*block.values(), strict=True)), Format.TABLE)
