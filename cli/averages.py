"""``orbitdb entropy`` and ``orbitdb lyapunov``: averages over a chosen subset of orbits."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.render import note, write
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.fixed_points import Weight
    from orbitdb.selection import Selection

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
_FIXED_POINTS = {"N", "K_0", "lambda_d", "lambda_c"}


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command(epilog=ENTROPY_EXAMPLES)(entropy)
    app.command(epilog=LYAPUNOV_EXAMPLES)(lyapunov)


def entropy(
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    status: options.Statuses = None,
    reversal: options.Reversal = None,
    symmetry: options.Symmetry = None,
    contains: options.Contains = None,
    bounds: options.Bounds = None,
    where: options.Where = None,
    parameter: options.Parameters = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N: points on orbits of period p and its divisors; K_0 = ln N / p; h_zeta: from the leading zero of
    the zeta function cut off at p, which converges much faster, with its change from p - 1.
    """
    from orbitdb import averages

    chosen = options.selection(a, p, status, reversal, symmetry, contains, bounds, where, parameter)
    subset = _Subset(chosen, db)
    found = averages.entropy(subset.rows, subset.highest)
    columns = {name: getattr(found, name).tolist() for name in ENTROPY_COLUMNS}
    subset.write(ENTROPY_COLUMNS, columns, options.chosen(format_, json))


def lyapunov(
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    status: options.Statuses = None,
    reversal: options.Reversal = None,
    symmetry: options.Symmetry = None,
    contains: options.Contains = None,
    bounds: options.Bounds = None,
    where: options.Where = None,
    parameter: options.Parameters = None,
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
    missing). The trajectory values are those that 'orbitdb simulate' has stored.
    """
    from orbitdb import averages
    from orbitdb.fixed_points import Weight
    from orbitdb.store.trajectories import best_reference

    if weight not in set(Weight):
        raise InputError(f"weight {weight!r}: use {' or '.join(Weight)}")
    chosen = options.selection(a, p, status, reversal, symmetry, contains, bounds, where, parameter)
    subset = _Subset(chosen, db)
    form = options.chosen(format_, json)
    if cut is not None:
        _write_cut(subset, cut, Weight(weight), form)
        return
    found = averages.lyapunov(subset.rows, subset.highest, Weight(weight))
    columns = {name: getattr(found, name).tolist() for name in LYAPUNOV_COLUMNS}
    names = list(LYAPUNOV_COLUMNS)
    reference = best_reference(subset.catalogue, chosen.a)
    if reference is None:
        note(f"no trajectory value at a = {a:g}: 'orbitdb simulate --a {a:g}' makes one")
    elif form is Format.TABLE:
        note(
            f"trajectories: lambda_d = {reference.lambda_d:.6f} +- {reference.lambda_d_error:.6f}, "
            f"lambda_c = {reference.lambda_c:.6f} +- {reference.lambda_c_error:.6f}"
        )
    else:
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            names.append(f"{name}_trajectory")
            columns[names[-1]] = [getattr(reference, name)] * len(columns["p"])
    subset.write(names, columns, form)


def _write_cut(subset: "_Subset", cut: float, weight: "Weight", form: Format) -> None:
    from orbitdb import averages
    from orbitdb.fixed_points import Weight

    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut:g}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    if weight is Weight.DETERMINANT and (cut / subset.rows.lyapunov).sum() > _MOST_FACTORS:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give a smaller one, such as 9")
    found = averages.lyapunov_by_stability(subset.rows, cut, subset.highest, weight)
    row = (cut, found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    note(subset.selection.describe())
    write(CUT_COLUMNS, [[_known(value) for value in row]], form)


class _Subset:
    """The chosen classes, and what of their periods is filled."""

    def __init__(self, selection: "Selection", db: Any) -> None:
        import numpy as np

        from orbitdb.orbits import Status
        from orbitdb.store.catalogue import Catalogue
        from orbitdb.store.filling import DONE

        if not selection.statuses:
            selection = replace(selection, statuses=(Status.ORBIT,))
        self.selection = selection
        self.catalogue: Catalogue = Catalogue(db)
        spans = selection.periods or ((2, 10**9),)
        self.have = [
            fill.p
            for fill in self.catalogue.fills(selection.a)
            if fill.state == DONE and any(low <= fill.p <= high for low, high in spans)
        ]
        rows = self.catalogue.classes(selection).rows()
        self.rows = rows.rows(np.isin(rows.period, self.have))
        self.highest = max(self.have, default=0)
        if not self.highest or not len(self.rows):
            note(f"no {selection.describe()} in filled periods: 'orbitdb info' shows what is filled")
            raise typer.Exit(1)

    def write(self, names: Sequence[str], columns: dict[str, list[Any]], form: Format) -> None:
        """Write one row a filled period; what periods that are not there would change is left out."""
        from orbitdb.fixed_points import missing_divisors, missing_periods

        note(self.selection.describe())
        rows = []
        for i, p in enumerate(columns["p"]):
            if p not in self.have:
                continue
            gaps, holes = missing_divisors(p, self.have), missing_periods(p, self.have)
            if gaps:
                note(f"p = {p}: the sums over fixed points lack the periods {_listed(gaps)}")
            row = []
            for name in names:
                lost = gaps if name in _FIXED_POINTS else holes if name != "p" else []
                row.append(None if lost and not name.endswith("trajectory") else _known(columns[name][i]))
            rows.append(row)
        if missing := missing_periods(self.highest, self.have):
            note(f"the zeta function lacks the periods {_listed(missing)}")
        write(names, rows, form)


def _listed(periods: list[int]) -> str:
    return ", ".join(map(str, periods))


def _known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
