"""``orbitdb entropy`` and ``orbitdb lyapunov``: averages over a chosen subset of orbits."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, note_gaps, note_nothing, reading
from orbitdb.cli.render import note, write
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.whole_periods import WholePeriods

ENTROPY_EXAMPLES = """
Examples:

  orbitdb entropy

  orbitdb entropy --p 2-9 --reversal self --json
"""
LYAPUNOV_EXAMPLES = """
Examples:

  orbitdb lyapunov

  orbitdb lyapunov --weight det --p 2-10

  orbitdb lyapunov --cut 9
"""
ENTROPY_COLUMNS = ("p", "N", "K_0", "h_zeta", "h_zeta_change")
LYAPUNOV_COLUMNS = (
    "p", "lambda_d", "lambda_c", "lambda_d_pair", "lambda_c_pair", "lambda_d_zeta", "lambda_c_zeta", "z0",
)  # fmt: skip
CUT_COLUMNS = ("cut", "lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
_LARGEST_CUT = 1000
_MOST_FACTORS = 100_000


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command(epilog=ENTROPY_EXAMPLES)(entropy)
    app.command(epilog=LYAPUNOV_EXAMPLES)(lyapunov)


@options.with_choice
def entropy(
    *,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N: points on orbits of period p and its divisors; K_0 = ln N / p; h_zeta: from the leading zero of
    the zeta function cut off at p, which converges much faster, with its change from p - 1.
    """
    from orbitdb.averages import by_period
    from orbitdb.averages.standing import faults_of, standing

    with progress("reading orbits") as shown:
        with reading(db, a, averaged(choice)) as (catalogue, chosen):
            subset = _read(catalogue, chosen)
        shown.tell("expanding the zeta function")
        found = by_period.entropy(subset.classes.rows(), subset.highest)
    note(subset.selection.describe())
    _note_faults(subset, faults_of(found, subset.periods))
    _write(subset, ENTROPY_COLUMNS, standing(found, subset.periods), options.chosen(format_, json))


@options.with_choice
def lyapunov(
    *,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
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
    missing). The trajectory values are those that 'orbitdb simulate' has stored.
    """
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.averages.standing import faults_of, standing
    from orbitdb.store.reading.references import best_reference

    if weight not in set(Weight):
        raise InputError(f"weight {weight!r}: use {' or '.join(Weight)}")
    with progress("reading orbits"), reading(db, a, averaged(choice)) as (catalogue, chosen):
        subset = _read(catalogue, chosen)
        reference = best_reference(catalogue, chosen.a)
    form = options.chosen(format_, json)
    if cut is not None:
        _write_cut(subset, cut, Weight(weight), form)
        return
    with progress("expanding the zeta function"):
        found = by_period.lyapunov(subset.classes.rows(), subset.highest, Weight(weight))
    columns = standing(found, subset.periods)
    names = list(LYAPUNOV_COLUMNS)
    if reference is None:
        note(f"no trajectory value at a = {chosen.a:g}: 'orbitdb simulate --a {chosen.a:g}' makes one")
    elif form is Format.TABLE:
        note(
            f"trajectories: lambda_d = {reference.lambda_d:.6f} +- {reference.lambda_d_error:.6f}, "
            f"lambda_c = {reference.lambda_c:.6f} +- {reference.lambda_c_error:.6f}"
        )
    else:
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            names.append(f"{name}_trajectory")
            columns[names[-1]] = [getattr(reference, name)] * len(columns["p"])
    note(subset.selection.describe())
    _note_faults(subset, faults_of(found, subset.periods))
    _write(subset, names, columns, form)


def _write_cut(subset: "WholePeriods", cut: float, weight: "Weight", form: Format) -> None:
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight

    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut:g}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    rows = subset.classes.rows()
    if weight is Weight.DETERMINANT and (most := by_period.largest_cut(rows, cut, _MOST_FACTORS)) < cut:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give {most:g} or less")
    with progress("summing pseudo-cycles"):
        found = by_period.lyapunov_by_stability(rows, cut, subset.highest, weight)
    values = (found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    note(subset.selection.describe())
    fault = "" if subset.missing or not found.fault else f"the zeta function gives no average {found.fault}"
    _note_faults(subset, fault)
    write(CUT_COLUMNS, [[cut, *(None if subset.missing else _known(value) for value in values)]], form)


def _read(catalogue: "Catalogue", chosen: "Selection") -> "WholePeriods":
    """Return the chosen classes of whole periods; say what is left out, and leave if there is none."""
    from orbitdb.store.reading.whole_periods import read_whole

    subset = read_whole(catalogue, chosen)
    note_gaps(catalogue, chosen, left_out=True)
    if not len(subset.classes):
        note_nothing(catalogue, subset.selection)
        raise typer.Exit(1)
    return subset


def _write(subset: "WholePeriods", names: Sequence[str], columns: dict[str, list[Any]], form: Format) -> None:
    """Write one row a whole period, and say which sums over fixed points lack periods."""
    from orbitdb.averages.fixed_points import missing_divisors

    for p in subset.periods:
        if gaps := missing_divisors(p, subset.periods):
            note(f"p = {p}: the sums over fixed points lack the periods {', '.join(map(str, gaps))}")
    rows = [list(row) for row in zip(*(columns[name] for name in names), strict=True)]
    write(names, [row for row in rows if row[names.index("p")] in subset.periods], form)


def _note_faults(subset: "WholePeriods", fault: str) -> None:
    """Say what is missing to the zeta function, and where it has no zero that can be used."""
    from orbitdb.store.reading.whole_periods import why_missing

    if subset.missing:
        note(f"the zeta function lacks the periods {why_missing(subset.missing, subset.selection)}")
    if fault:
        note(fault)


def _known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
