"""``orbitdb table``, ``entropy``, ``lyapunov`` and ``simulate``: averages by period or over trajectories."""

from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.grids import many_a
from orbitdb.cli.notes import notes, progress
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output, write_facts
from orbitdb.cli.snapshots import given_a, snapshot, storable
from orbitdb.display import columns_of
from orbitdb.text import concise, format_float, with_error

if TYPE_CHECKING:
    from orbitdb.answers.results import Result
    from orbitdb.trajectories.ensemble import Reference


EXAMPLES = {
    "table": ("table", "table --a 1 --p 2-8 --json", "table --a all --p 11"),
    "entropy": ("entropy", "entropy --p 2-9 --time-reversal self --json", "entropy --a all --format csv"),
    "lyapunov": (
        "lyapunov",
        "lyapunov --weight det --p 2-10",
        "lyapunov --cut 9",
        "lyapunov --a 1 --a 1.6 --p 2-8",
    ),
    "simulate": ("simulate", "simulate --a 1 --bounces 100000000 --seed 7 --json", "simulate --legwise"),
}


def table(
    *, a: options.HalfLengths = None, p: options.Periods = None, output: Output, db: options.Database
) -> None:
    """Show the paper's Table 1 for the filled periods: the numbers of words and orbits, and the entropy.

    N_t is the number of words that the geometric rules allow, N_c the number of orbits, N the number of
    points on orbits whose period is p or a divisor of p, and K_0 = ln N / p. classes counts the orbits up to
    symmetry. boundary counts the orbits through a joint, which N_c leaves out. Periods that are not filled at
    this a are counted from births, if 'orbitdb births' has found them.
    """
    with snapshot(db, a, SelectionOptions(p=p), usual=()) as (catalogue, selections):
        result = catalogue.table(selections if many_a(a) else selections[0])
    output.write(*_rows_of(result, output))


def entropy(
    *, a: options.HalfLengths = None, choice: SelectionOptions, output: Output, db: options.Database
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N is the number of points on orbits whose period is p or a divisor of p, and K_0 = ln N / p. h_zeta comes
    from the leading zero of the zeta function truncated at p. It converges much faster; its change from p - 1
    is shown, too, but is not an error bound. The proved bounds come from 'orbitdb bounds', or are computed on
    the spot.
    """
    with progress("reading orbits"), snapshot(db, a, choice, ["orbit"]) as (catalogue, selections):
        result = catalogue.entropy(selections if many_a(a) else selections[0])
    from orbitdb.answers.results import PROVED

    output.write(*_rows_of(result, output, hidden=PROVED if output.table else ()))


def lyapunov(
    *,
    a: options.HalfLengths = None,
    choice: SelectionOptions,
    weight: Annotated[
        Literal["exp", "det"],
        typer.Option(help="exp for e^-lambda, as in the paper, or det for 1/|det(1 - M)|."),
    ] = "exp",
    cut: Annotated[
        float | None,
        options.number_option(
            help="Instead, compute one zeta average over all pseudo-cycles with lambda up to this value."
        ),
    ] = None,
    output: Output,
    db: options.Database,
) -> None:
    """Compute the average Lyapunov exponents of the chosen orbits, by period.

    lambda_d and lambda_c are the averages of the paper's eqs. (6) and (7), per bounce and per unit length.
    pair is the mean for the periods p - 1 and p. zeta comes from the zeta function truncated at p; z0 is its
    zero (1 if no orbit is missing). sum_rule averages over all orbits up to p with weights e^-lambda,
    constrained by exact means. In a table, its estimated error follows in brackets, in units of the last
    digit. The other averages do not converge to lambda as p grows. The values for trajectories come from
    'orbitdb simulate'.
    """
    with progress("averaging") as shown, snapshot(db, a, choice, ["orbit"]) as (catalogue, selections):
        chosen = selections if many_a(a) else selections[0]
        result = catalogue.lyapunov(chosen, weight=weight, cut=cut, progress=shown)
    names, rows = _rows_of(result, output)
    if not output.table or cut is not None:
        output.write(names, rows)
        return
    columns = columns_of(names, rows)
    output.write(*_block(columns, "lambda_d", further=True))
    print()
    output.write(*_block(columns, "lambda_c"))


def _block(
    columns: dict[str, list[Any]], exponent: str, further: bool = False
) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Return the averages of one exponent, errors in brackets; `further` adds columns of neither exponent."""
    from orbitdb.answers.lyapunov import AVERAGES, EXPONENTS

    block: dict[str, list[Any]] = {name: columns[name] for name in ("a", "p") if name in columns}
    for average in AVERAGES:
        values = columns[name := average.of(exponent)]
        block[average.name or exponent] = (
            list(map(concise, values, columns[f"{name}_error"])) if average.error else values
        )
    if further:
        block |= {name: columns[name] for name in columns if not name.startswith(("a", "p", *EXPONENTS))}
    return list(block), list(zip(*block.values(), strict=True))


def _rows_of(
    result: "Result", output: Output, hidden: Collection[str] = ()
) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Return the columns of a result, except hidden ones, and its rows; exit if there are no rows.

    Notes say what is missing and, for a table, what else is known.
    """
    notes([*result.notes, *(result.facts if output.table else ())])
    if not len(result):
        raise typer.Exit(1)
    names = [name for name in result.columns if name not in hidden]
    return names, list(result.rows(names))


def simulate(
    *,
    a: options.HalfLength = None,
    wanted: Annotated[
        int,
        options.count_option(
            "--bounces",
            least=1,
            most=10**12,
            help="Total number of bounces, such as 1e8; about a thousand at least, in 256 trajectories.",
        ),
    ] = 20_000_000,
    seed: Annotated[
        int, options.count_option(least=0, help="Random seed; the same seed gives the same result.")
    ] = 0,
    legwise: Annotated[
        bool,
        typer.Option("--legwise", help="Sample leg by leg and use exact means, for much smaller errors."),
    ] = False,
    store: options.Store = None,
    output: Output,
    db: options.Database,
) -> None:
    """Average over random trajectories: Lyapunov exponents and mean free path, with standard errors.

    The result is stored, and 'orbitdb lyapunov' shows it beside the averages over orbits. With --legwise,
    only the small part of lambda whose mean is not known exactly is sampled.
    """
    from orbitdb.catalogue import Catalogue

    catalogue = Catalogue(db, *given_a(db, a), missing_ok=True)
    keeps = storable(catalogue, store)
    file = catalogue.check_writable() if keeps else None
    with progress("trajectories") as shown:
        means = catalogue.simulate(wanted, seed=seed, legwise=legwise, store=False, progress=shown)
    try:
        if keeps:
            catalogue.keep(means, file)
    finally:
        if output.table:
            write_facts(_facts(means))
        else:
            output.write([*means.row()], [[*means.row().values()]])
    notes(means.notes(wanted))


def _facts(means: "Reference") -> list[tuple[str, str]]:
    """Return the result as pairs of a name and a text."""
    return [
        ("a", format_float(means.a)),
        ("lambda_d", with_error(means.lambda_d, means.lambda_d_error)),
        ("lambda_c", with_error(means.lambda_c, means.lambda_c_error)),
        ("mean free path", with_error(means.mean_free_path, means.mean_free_path_error)),
        ("bounces", str(means.bounces)),
        ("seed", str(means.seed)),
    ]
