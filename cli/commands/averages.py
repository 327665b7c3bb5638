"""``orbitdb entropy`` and ``orbitdb lyapunov``: averages over a chosen subset of orbits."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import enclosed, options
from orbitdb.cli.lyapunov_blocks import write_blocks
from orbitdb.cli.options import Format
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, note_gaps, note_nothing, reading
from orbitdb.cli.render import note, with_error, write
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.counted import Counted
    from orbitdb.store.reading.enclosures import Enclosure
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
    the zeta function cut off at p, which converges much faster, with its change from p - 1. The proved
    bounds are those that 'orbitdb bounds' has stored.
    """
    from orbitdb.averages import by_period
    from orbitdb.averages.standing import faults_of, standing

    with progress("reading orbits") as shown:
        with reading(db, a, averaged(choice)) as (catalogue, chosen):
            counted = _counted(catalogue, chosen)
            proved = enclosed.enclosure(catalogue, chosen.a)
            if counted is not None:
                note_gaps(catalogue, chosen, left_out=True, counted=counted)
                _write_counted(counted, options.chosen(format_, json), proved)
                return
            _note_uncounted(catalogue, chosen)
            subset = _read(catalogue, chosen)
        shown.tell("expanding the zeta function")
        found = by_period.entropy(subset.classes.rows(), subset.highest)
    form = options.chosen(format_, json)
    note(subset.selection.describe())
    if form is Format.TABLE:
        _note_proved(subset.selection.a, proved)
    _note_faults(subset, faults_of(found, subset.periods))
    _note_divisors(subset.periods)
    columns = standing(found, subset.periods)
    columns |= _proved_columns(proved, len(columns["p"]), form)
    _write(subset, _entropy_names(columns), columns, form)


def _note_proved(a: float, proved: "tuple[Enclosure, str] | None") -> None:
    """Say what is known of the entropy of all orbits by proof."""
    from orbitdb.entropy.letters import geometric_entropy
    from orbitdb.store.reading.fills import exact

    most = f"at most {math.ceil(geometric_entropy() * 1e6) / 1e6:.6f} at any a"
    if proved is None:
        note(f"of all orbits it is {most}: 'orbitdb bounds --a {exact(a)}' encloses it")
    else:
        note(f"{proved[1]}; {most}")


def _proved_columns(
    proved: "tuple[Enclosure, str] | None", count: int, form: Format
) -> dict[str, list[float | str]]:
    """Return proved bounds as columns, where no note tells of them."""
    return enclosed.columns_of(None if proved is None or form is Format.TABLE else proved[0], count)


def _entropy_names(columns: dict[str, list[Any]]) -> list[str]:
    """Return the names of the columns of entropies that there are."""
    return [*ENTROPY_COLUMNS, *(name for name in enclosed.COLUMNS if name in columns)]


def _counted(catalogue: "Catalogue", chosen: "Selection") -> "Counted | None":
    """Return counts in which sweeps and births stand for fills, where all orbits of periods are chosen."""
    if replace(chosen, periods=()) != type(chosen)(chosen.a):
        return None
    counted = catalogue.counts(chosen)
    return counted if counted.without_rows else None


def _note_uncounted(catalogue: "Catalogue", chosen: "Selection") -> None:
    """Say why births do not answer for a subset of the orbits of periods that only they know."""
    all_of_them = type(chosen)(chosen.a, chosen.periods)
    if chosen != all_of_them and (counted := catalogue.counts(all_of_them)).from_births:
        note(
            f"births tell how many orbits of {counted.from_births_written()} there are at a = {chosen.a:g}, "
            "and not which of them are chosen: leave out all but --p, or fill them"
        )


def _write_counted(counted: "Counted", form: Format, proved: "tuple[Enclosure, str] | None") -> None:
    """Write the entropies of counts, and what is proved beside them."""
    import numpy as np

    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import missing_periods
    from orbitdb.averages.standing import faults_of, standing

    cycles = np.zeros(max(counted.chosen) + 1, dtype=np.int64)
    for p in counted.chosen:
        cycles[p] = counted.known[p].n_c
    found = by_period.entropy_of_counts(cycles)
    if missing := missing_periods(max(counted.chosen), counted.chosen):
        note(f"the zeta function lacks the periods {', '.join(map(str, missing))}")
    if form is Format.TABLE:
        _note_proved(counted.a, proved)
    if fault := faults_of(found, counted.chosen):
        note(fault)
    _note_divisors(counted.chosen)
    columns = standing(found, counted.chosen)
    columns |= _proved_columns(proved, len(columns["p"]), form)
    names = _entropy_names(columns)
    rows = [list(row) for row in zip(*(columns[name] for name in names), strict=True)]
    write(names, [row for row in rows if row[0] in counted.chosen], form)


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
    missing); sum_rule: all orbits up to p with weights e^-lambda, held to exact means, with an estimate
    of the error, in brackets behind the last digits in a table. The trajectory values are those that
    'orbitdb simulate' has stored.
    """
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import Weight
    from orbitdb.averages.period_sums import lyapunov_of_periods
    from orbitdb.averages.standing import faults_of, standing
    from orbitdb.store.reading.references import best_reference

    if weight not in set(Weight):
        raise InputError(f"weight {weight!r}: use {' or '.join(Weight)}")
    with progress("reading orbits"), reading(db, a, averaged(choice)) as (catalogue, chosen):
        subset = _read(catalogue, chosen, swept=cut is None)
        reference = best_reference(catalogue, chosen.a)
    form = options.chosen(format_, json)
    if cut is not None:
        _write_cut(subset, cut, Weight(weight), form)
        return
    with progress("expanding the zeta function"):
        if subset.swept:
            found = lyapunov_of_periods(subset.sums(), subset.highest, Weight(weight))
        else:
            found = by_period.lyapunov(subset.classes.rows(), subset.highest, Weight(weight))
    columns = standing(found, subset.periods) | _sum_rule_columns(subset)
    names = [*LYAPUNOV_COLUMNS, *SUM_RULE_COLUMNS]
    if reference is None:
        note(f"no trajectory value at a = {chosen.a:g}: 'orbitdb simulate --a {chosen.a:g}' makes one")
    elif form is Format.TABLE:
        note(
            f"trajectories: lambda_d = {with_error(reference.lambda_d, reference.lambda_d_error)}, "
            f"lambda_c = {with_error(reference.lambda_c, reference.lambda_c_error)}"
        )
    else:
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            names.append(f"{name}_trajectory")
            columns[names[-1]] = [getattr(reference, name)] * len(columns["p"])
    note(subset.selection.describe())
    _note_faults(subset, faults_of(found, subset.periods))
    _note_divisors(subset.periods)
    if form is Format.TABLE:
        write_blocks(columns, subset.periods)
    else:
        _write(subset, names, columns, form)
    _note_bounds(subset.selection.a)


def _sum_rule_columns(subset: "WholePeriods") -> dict[str, list[Any]]:
    """Return the columns of sum rules; blank, with a note why, where they mean nothing."""
    from orbitdb.store.reading.leg_terms import sum_rules_of, why_no_further_sum_rules, why_no_sum_rules

    found = sum_rules_of(subset)
    if why := why_no_sum_rules(subset.selection, subset.missing) or why_no_further_sum_rules(subset):
        note(why)
    if found is None:
        return {name: [None] * (subset.highest - 1) for name in SUM_RULE_COLUMNS}
    return {name: [_known(value) for value in getattr(found, name).tolist()] for name in SUM_RULE_COLUMNS}


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
    if weight is Weight.DETERMINANT and (most := by_period.largest_cut(rows, cut, _MOST_FACTORS)) < cut:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give {most:g} or less")
    with progress("summing pseudo-cycles") as shown:

        def show(done: float) -> None:
            shown.tell("summing pseudo-cycles", done, 1.0, counted=False)

        found = by_period.lyapunov_by_stability(rows, cut, subset.highest, weight, show)
    values = (found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    note(subset.selection.describe())
    fault = "" if subset.missing or not found.fault else f"the zeta function gives no average {found.fault}"
    _note_faults(subset, fault)
    write(CUT_COLUMNS, [[cut, *(None if subset.missing else _known(value) for value in values)]], form)


def _read(catalogue: "Catalogue", chosen: "Selection", swept: bool = False) -> "WholePeriods":
    """Return the chosen classes of whole periods; say what is left out, and leave if there is none."""
    from orbitdb.store.reading.whole_periods import read_whole

    subset = read_whole(catalogue, chosen, swept)
    note_gaps(catalogue, chosen, left_out=True, counted=subset.counted() if subset.swept else None)
    if not len(subset.classes) and not any(sums.ranges.least for sums in subset.swept.values()):
        note_nothing(catalogue, subset.selection)
        raise typer.Exit(1)
    return subset


def _note_divisors(periods: Sequence[int]) -> None:
    """Say which sums over fixed points lack periods."""
    from orbitdb.averages.fixed_points import missing_divisors

    for p in periods:
        if gaps := missing_divisors(p, periods):
            note(f"p = {p}: the sums over fixed points lack the periods {', '.join(map(str, gaps))}")


def _write(subset: "WholePeriods", names: Sequence[str], columns: dict[str, list[Any]], form: Format) -> None:
    """Write one row a whole period."""
    rows = [list(row) for row in zip(*(columns[name] for name in names), strict=True)]
    write(names, [row for row in rows if row[names.index("p")] in subset.periods], form)


def _note_faults(subset: "WholePeriods", fault: str) -> None:
    """Say what is missing to the zeta function, and where it has no zero that can be used."""
    if subset.missing:
        note(f"the zeta function lacks the periods {subset.why_missing()}")
    if fault:
        note(fault)


def _known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
