"""``orbitdb lyapunov``: the average Lyapunov exponents over a chosen subset of orbits."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.averaging import (
    known,
    note_divisors,
    note_faults,
    of_periods,
    read_classes,
    write_answers,
)
from orbitdb.cli.half_lengths import Answer, joined, several
from orbitdb.cli.lyapunov_blocks import write_blocks
from orbitdb.cli.options import Format
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, reading_all
from orbitdb.cli.render import note, with_error
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.whole_periods import WholePeriods
    from orbitdb.trajectories.ensemble import Reference

EXAMPLES = """
Examples:

  orbitdb lyapunov

  orbitdb lyapunov --weight det --p 2-10

  orbitdb lyapunov --cut 9

  orbitdb lyapunov --a 1 --a 1.6 --p 2-8
"""
COLUMNS = (
    "p", "lambda_d", "lambda_c", "lambda_d_pair", "lambda_c_pair", "lambda_d_zeta", "lambda_c_zeta", "z0",
)  # fmt: skip
SUM_RULE_COLUMNS = (
    "lambda_d_sum_rule", "lambda_c_sum_rule", "lambda_d_sum_rule_error", "lambda_c_sum_rule_error",
)  # fmt: skip
CUT_COLUMNS = ("cut", "lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
_LARGEST_CUT = 1000
_MOST_FACTORS = 100_000


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(lyapunov)


@options.with_choice
def lyapunov(
    *,
    a: options.StoredHalfLengths = None,
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
    missing); sum_rule: all orbits up to p with weights e^-lambda, held to exact means, with an estimate
    of the error, in brackets behind the last digits in a table. The trajectory values are those that
    'orbitdb simulate' has stored.
    """
    from orbitdb.averages.fixed_points import Weight

    if weight not in set(Weight):
        raise InputError(f"weight {weight!r}: use {' or '.join(Weight)}")
    form, many = options.chosen(format_, json), several(a)
    with reading_all(db, a, averaged(choice)) as (catalogue, stadiums):
        found = [_at_one(catalogue, chosen, cut, Weight(weight), form, many) for chosen in stadiums]
    if form is Format.TABLE and cut is None and any(found):
        write_blocks(*joined([each for each in found if each is not None], many))
    else:
        write_answers(found, many, form)
    if cut is None:
        for each in found:
            if each is not None:
                _note_bounds(each.a, many)


def _at_one(
    catalogue: "Catalogue", chosen: "Selection", cut: float | None, weight: "Weight", form: Format, many: bool
) -> Answer | None:
    """Return the averages at one a, be it one of many; None if nothing is there."""
    from orbitdb.store.reading.references import best_reference

    with progress("reading orbits"):
        subset = read_classes(catalogue, chosen, swept=cut is None)
    if subset is None:
        return None
    if cut is not None:
        return _up_to(subset, cut, weight)
    reference = best_reference(catalogue, chosen.a)
    with progress("expanding the zeta function"):
        return _by_period(subset, weight, reference, form, many)


def _by_period(
    subset: "WholePeriods", weight: "Weight", reference: "Reference | None", form: Format, many: bool
) -> Answer:
    """Return the averages of every period, with trajectory values where no note tells of them."""
    from orbitdb.averages import by_period
    from orbitdb.averages.period_sums import lyapunov_of_periods
    from orbitdb.averages.standing import faults_of, standing

    a = subset.selection.a
    at = f" at a = {a:g}" if many else ""
    if subset.swept:
        found = lyapunov_of_periods(subset.sums(), subset.highest, weight)
    else:
        found = by_period.lyapunov(subset.classes.rows(), subset.highest, weight)
    columns = standing(found, subset.periods) | _sum_rule_columns(subset)
    names = [*COLUMNS, *SUM_RULE_COLUMNS]
    if reference is None:
        note(f"no trajectory value at a = {a:g}: 'orbitdb simulate --a {a:g}' makes one")
    elif form is Format.TABLE:
        note(
            f"trajectories{at}: lambda_d = {with_error(reference.lambda_d, reference.lambda_d_error)}, "
            f"lambda_c = {with_error(reference.lambda_c, reference.lambda_c_error)}"
        )
    else:
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            names.append(f"{name}_trajectory")
            columns[names[-1]] = [getattr(reference, name)] * len(columns["p"])
    note(subset.selection.describe())
    note_faults(subset, faults_of(found, subset.periods))
    note_divisors(subset.periods, subset.selection)
    return of_periods(a, subset.periods, names, columns)


def _sum_rule_columns(subset: "WholePeriods") -> dict[str, list[Any]]:
    """Return the columns of sum rules; blank, with a note why, where they mean nothing."""
    from orbitdb.store.reading.leg_terms import sum_rules_of, why_no_further_sum_rules, why_no_sum_rules

    found = sum_rules_of(subset)
    if why := why_no_sum_rules(subset.selection, subset.missing) or why_no_further_sum_rules(subset):
        note(why)
    if found is None:
        return {name: [None] * (subset.highest - 1) for name in SUM_RULE_COLUMNS}
    return {name: [known(value) for value in getattr(found, name).tolist()] for name in SUM_RULE_COLUMNS}


def _note_bounds(a: float, many: bool) -> None:
    """Say between what the exponents are, whatever the orbits."""
    from orbitdb.averages.exact_means import exact_means

    means = exact_means(a)
    low, high = means.bounds
    ranges = (
        f"{low * scale:.6f} < {name} < {high * scale:.6f}"
        for name, scale in (("lambda_d", means.per_bounce), ("lambda_c", means.per_length))
    )
    at = f" at a = {a:g}" if many else ""
    note(f"by exact means{at}, without any orbit: {', '.join(ranges)}")


def _up_to(subset: "WholePeriods", cut: float, weight: "Weight") -> Answer:
    """Return one average over all pseudo-cycles up to a cut."""
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight

    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut:g}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    rows = subset.classes.rows()
    if weight is Weight.DETERMINANT and (most := by_period.largest_cut(rows, cut, _MOST_FACTORS)) < cut:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give {most:g} or less")
    with progress("summing pseudo-cycles") as shown:

        def show(done: float) -> None:
            shown.tell("summing pseudo-cycles", done, 1.0, counted=False)

        found = by_period.lyapunov_by_stability(rows, cut, subset.highest, weight, show)
    values = (found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    note(subset.selection.describe())
    fault = "" if subset.missing or not found.fault else f"the zeta function gives no average {found.fault}"
    note_faults(subset, fault)
    row = [cut, *(None if subset.missing else known(value) for value in values)]
    return Answer(subset.selection.a, CUT_COLUMNS, [row])
