"""``orbitdb entropy`` and ``orbitdb lyapunov``: averages over a chosen subset of orbits."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.render import note, note_partial, with_error, write
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
SUM_RULE_COLUMNS = (
    "lambda_d_sum_rule", "lambda_c_sum_rule", "lambda_d_sum_rule_error", "lambda_c_sum_rule_error",
)  # fmt: skip
CUT_COLUMNS = ("cut", "lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
_LARGEST_CUT = 1000
_MOST_FACTORS = 100_000
_FIXED_POINTS = {"N", "K_0", "lambda_d", "lambda_c"}


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command(epilog=ENTROPY_EXAMPLES)(entropy)
    app.command(epilog=LYAPUNOV_EXAMPLES)(lyapunov)


@options.with_choice
def entropy(
    *,
    a: options.HalfLength = 1.6,
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
    from orbitdb.store.reading.catalogue import Catalogue

    subset = _read(Catalogue(db), choice.at(a))
    found = by_period.entropy(subset.classes.rows(), subset.highest)
    columns = {name: getattr(found, name).tolist() for name in ENTROPY_COLUMNS}
    _write(subset, ENTROPY_COLUMNS, columns, options.chosen(format_, json))


@options.with_choice
def lyapunov(
    *,
    a: options.HalfLength = 1.6,
    choice: options.Choice,
    weight: Annotated[
        str, typer.Option("--weight", help="exp: e^-lambda, as in the paper; det: 1/|det(1 - M)|.")
    ] = "exp",
    cut: Annotated[
        float | None,
        typer.Option("--cut", help="One zeta average over all pseudo-cycles of lambda up to this, instead."),
    ] = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the average Lyapunov exponents over the chosen orbits, by period.

    lambda_d and lambda_c: the paper's eqs. (5) and (6), per bounce and per length; pair: means of
    neighbouring periods; zeta: from the zeta function cut off at p, with its zero z0 (1 if nothing is
    missing); sum_rule: all orbits up to p with weights e^-lambda, held to exact means, with an estimate
    of the error. The trajectory values are those that 'orbitdb simulate' has stored.
    """
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.references import best_reference

    if weight not in set(Weight):
        raise InputError(f"weight {weight!r}: use {' or '.join(Weight)}")
    with Catalogue(db).at_one_moment() as catalogue:
        subset = _read(catalogue, choice.at(a))
        reference = best_reference(catalogue, subset.selection.a)
    form = options.chosen(format_, json)
    if cut is not None:
        _write_cut(subset, cut, Weight(weight), form)
        return
    found = by_period.lyapunov(subset.classes.rows(), subset.highest, Weight(weight))
    columns = {name: getattr(found, name).tolist() for name in LYAPUNOV_COLUMNS}
    columns |= _sum_rule_columns(subset)
    names = [*LYAPUNOV_COLUMNS, *SUM_RULE_COLUMNS]
    if reference is None:
        note(f"no trajectory value at a = {a:g}: 'orbitdb simulate --a {a:g}' makes one")
    elif form is Format.TABLE:
        note(
            f"trajectories: lambda_d = {with_error(reference.lambda_d, reference.lambda_d_error)}, "
            f"lambda_c = {with_error(reference.lambda_c, reference.lambda_c_error)}"
        )
    else:
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            names.append(f"{name}_trajectory")
            columns[names[-1]] = [getattr(reference, name)] * len(columns["p"])
    _write(subset, names, columns, form)
    _note_bounds(subset.selection.a)


def _sum_rule_columns(subset: "WholePeriods") -> dict[str, list[Any]]:
    """Return the columns of sum rules; blank, with a note why, where they mean nothing."""
    from orbitdb.store.reading.leg_terms import sum_rules_of, why_no_sum_rules

    found = sum_rules_of(subset)
    if found is None:
        note(why_no_sum_rules(subset.selection, subset.missing))
        return {name: [None] * (subset.highest - 1) for name in SUM_RULE_COLUMNS}
    return {name: getattr(found, name).tolist() for name in SUM_RULE_COLUMNS}


def _note_bounds(a: float) -> None:
    """Say between what the exponents are, whatever the orbits."""
    from orbitdb.averages.exact_means import exact_means

    means = exact_means(a)
    low, high = means.bounds
    ranges = (
        f"{low * scale:.6f} < {name} < {high * scale:.6f}"
        for name, scale in (("lambda_d", means.per_bounce), ("lambda_c", means.per_length))
    )
    note(f"by exact means, without any orbit: {', '.join(ranges)}")


def _write_cut(subset: "WholePeriods", cut: float, weight: "Weight", form: Format) -> None:
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight

    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut:g}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    rows = subset.classes.rows()
    if weight is Weight.DETERMINANT and (cut / rows.lyapunov).sum() > _MOST_FACTORS:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give a smaller one, such as 9")
    found = by_period.lyapunov_by_stability(rows, cut, subset.highest, weight)
    values = (found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    note(subset.selection.describe())
    _note_missing(subset)
    write(CUT_COLUMNS, [[cut, *(None if subset.missing else _known(value) for value in values)]], form)


def _read(catalogue: "Catalogue", chosen: "Selection") -> "WholePeriods":
    """Return the chosen classes of whole periods; say what is left out, and leave if there is none."""
    from orbitdb.store.reading.whole_periods import read_whole

    subset = read_whole(catalogue, chosen)
    note_partial(subset.partial, chosen.a, left_out=True)
    if not len(subset.classes):
        note(f"no {subset.selection.describe()} in filled periods: 'orbitdb info' shows what is filled")
        raise typer.Exit(1)
    return subset


def _write(subset: "WholePeriods", names: Sequence[str], columns: dict[str, list[Any]], form: Format) -> None:
    """Write one row a filled period; what periods that are not there would change is left out."""
    from orbitdb.averages.fixed_points import missing_divisors, missing_periods

    note(subset.selection.describe())
    rows = []
    for i, p in enumerate(columns["p"]):
        if p not in subset.periods:
            continue
        gaps, holes = missing_divisors(p, subset.periods), missing_periods(p, subset.periods)
        if gaps:
            note(f"p = {p}: the sums over fixed points lack the periods {_listed(gaps)}")
        row = []
        for name in names:
            lost = gaps if name in _FIXED_POINTS else holes if name != "p" else []
            row.append(None if lost and not name.endswith("trajectory") else _known(columns[name][i]))
        rows.append(row)
    _note_missing(subset)
    write(names, rows, form)


def _note_missing(subset: "WholePeriods") -> None:
    if subset.missing:
        note(f"the zeta function lacks the periods {_listed(subset.missing)}")


def _listed(periods: list[int]) -> str:
    return ", ".join(map(str, periods))


def _known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
