"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import math
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.render import code_text, note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.fixed_points import ClassRows
    from orbitdb.orbits import Orbit
    from orbitdb.selection import Selection
    from orbitdb.store.catalogue import Catalogue

EXAMPLES = """
Examples:

  orbitdb plot orbit --code 1232131 --a 1.2 -o orbit.pdf

  orbitdb plot entropy --p 2-11 -o entropy.svg

  orbitdb plot birkhoff --p 2-8 --reversal self -o phase-space.png

The figures: orbit, its path in the stadium (Fig. 1 of the paper); reverse, an orbit and its time
reverse (Fig. 4); entropy (Fig. 5) and lyapunov (Fig. 6) against the period; sheet, all classes of a
period; birkhoff, the bounces in phase space; lengths, the length spectrum.
"""


class Kind(StrEnum):
    """The figures."""

    ORBIT = "orbit"
    REVERSE = "reverse"
    ENTROPY = "entropy"
    LYAPUNOV = "lyapunov"
    SHEET = "sheet"
    BIRKHOFF = "birkhoff"
    LENGTHS = "lengths"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(plot)


def plot(
    kind: Annotated[Kind, typer.Argument(help="What to draw.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="Ends in .png, .svg or .pdf.")
    ],
    code: Annotated[
        str | None, typer.Option("--code", help="The word, for orbit and reverse; stored or not.")
    ] = None,
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    status: options.Statuses = None,
    reversal: options.Reversal = None,
    symmetry: options.Symmetry = None,
    contains: options.Contains = None,
    bounds: options.Bounds = None,
    where: options.Where = None,
    parameter: options.Parameters = None,
    limit: Annotated[int, typer.Option("--limit", min=1, help="Orbits on a sheet at most.")] = 120,
    db: options.Database = None,
) -> None:
    """Draw an orbit, or a figure of the chosen subset, into a file."""
    from orbitdb.export import complete
    from orbitdb.plots import style

    ending = style.check_ending(output)
    if kind in (Kind.ORBIT, Kind.REVERSE):
        if code is None:
            raise InputError(f"name the orbit to draw: plot {kind} --code 1232131")
        found = _orbit(code, a, db)
        made = _draw_orbit(found) if kind is Kind.ORBIT else _draw_reverse(found)
        said = f"orbit {found.code} at a = {a:g}"
    else:
        from orbitdb.store.catalogue import Catalogue

        chosen = options.selection(
            a,
            p,
            "orbit" if status is None else status,
            reversal,
            symmetry,
            contains,
            bounds,
            where,
            parameter,
        )
        made = _FIGURES[kind](Catalogue(db), chosen, limit)
        said = chosen.describe()
    with complete(output) as draft:
        style.save(made, draft, ending, said)
    note(f"{said}, in {output}")


def _orbit(code: str, a: float, db: Path | None) -> "Orbit":
    """Return the orbit of a word, stored or solved on the spot.

    Raises
    ------
    InputError
        If it has none.
    """
    from orbitdb import survey
    from orbitdb.cli.query import primitive
    from orbitdb.stadium import Stadium
    from orbitdb.store.database import check_file, default_path
    from orbitdb.words import parse, primitive_root

    Stadium(a)
    path = db or default_path()
    found = survey.find(None if check_file(path) is None else path, primitive_root(parse(code)), a)
    if found.coordinates is None:
        raise InputError(f"{code_text(found.code)} at a = {a:g} cannot be drawn: {found.status.sentence}")
    primitive(code)  # tells of a code that repeats a shorter one
    return found


def _draw_orbit(found: "Orbit") -> "Figure":
    from orbitdb.plots.paths import draw_orbit
    from orbitdb.plots.style import figure
    from orbitdb.stadium import Stadium

    with figure(6.4, _height(found.a, 6.4)) as made:
        ax = made.add_subplot()
        assert found.points is not None
        draw_orbit(ax, Stadium(found.a), found.points)
        ax.set_title(_caption(found))
    return made


def _draw_reverse(found: "Orbit") -> "Figure":
    """Draw an orbit above its time reverse, whose bounces are those of the orbit backwards."""
    from orbitdb.plots.paths import draw_orbit
    from orbitdb.plots.style import BLUE, ORANGE, figure
    from orbitdb.stadium import Stadium
    from orbitdb.symmetry import REVERSE, images_of

    reverse = images_of(found.code)[REVERSE]
    same = found.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted, too"
    with figure(6.4, 2 * _height(found.a, 6.4)) as made:
        above, below = made.subplots(2, 1)
        assert found.points is not None
        draw_orbit(above, Stadium(found.a), found.points)
        above.set_title(f"(a) {_caption(found)}")
        draw_orbit(below, Stadium(found.a), found.points[::-1], BLUE if same else ORANGE)
        below.set_title(f"(b) its time reverse {_short(reverse)}: {kind}")
    return made


def _height(a: float, width: float) -> float:
    """Return the height in inches of a stadium drawn this wide, with its title and axis."""
    return max(2.0, (width - 0.8) * 2.7 / (2 * a + 2.7) + 0.9)


def _caption(found: "Orbit") -> str:
    numbers = f"$a = {found.a:g}$,  $L = {found.length:.4f}\\,R$,  $\\lambda = {found.lyapunov:.4f}$"
    return f"{_short(found.code)},  {numbers}"


def _short(code: str) -> str:
    from orbitdb.words import run_notation

    if len(code) <= 30:
        return code
    text = run_notation(code)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _draw_entropy(catalogue: "Catalogue", chosen: "Selection", _limit: int) -> "Figure":
    from orbitdb.averages import entropy
    from orbitdb.plots.curves import draw_entropy
    from orbitdb.plots.style import figure, plain

    rows, highest = _class_rows(catalogue, chosen)
    found = entropy(rows, highest)
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        draw_entropy(ax, found.p, found.K_0, found.h_zeta, found.h_zeta_change)
        ax.set_title(plain(chosen.describe()))
    return made


def _draw_lyapunov(catalogue: "Catalogue", chosen: "Selection", _limit: int) -> "Figure":
    from orbitdb.averages import lyapunov
    from orbitdb.plots.curves import Line, LyapunovRows, draw_lyapunov
    from orbitdb.plots.style import figure, plain
    from orbitdb.store.trajectories import best_reference

    rows, highest = _class_rows(catalogue, chosen)
    found = lyapunov(rows, highest)
    known = best_reference(catalogue, chosen.a)
    if known is None:
        note(f"no trajectories at a = {chosen.a:g} to compare with: run 'orbitdb simulate --a {chosen.a:g}'")
    lines = (
        (None, None)
        if known is None
        else (Line(known.lambda_d, known.lambda_d_error), Line(known.lambda_c, known.lambda_c_error))
    )
    discrete = LyapunovRows(found.lambda_d, found.lambda_d_pair, found.lambda_d_zeta, lines[0])
    continuous = LyapunovRows(found.lambda_c, found.lambda_c_pair, found.lambda_c_zeta, lines[1])
    with figure(6.4, 6.4) as made:
        above, below = made.subplots(2, 1, sharex=True)
        draw_lyapunov(above, found.p, discrete, r"\lambda_d", "per bounce")
        draw_lyapunov(below, found.p, continuous, r"\lambda_c", "per length $R$")
        above.set(xlabel="", title=plain(chosen.describe()))
        above.legend(loc="upper right")
    return made


def _class_rows(catalogue: "Catalogue", chosen: "Selection") -> "tuple[ClassRows, int]":
    """Return the chosen classes for averages, and the highest order; say which periods are missing."""
    from dataclasses import replace

    from orbitdb.fixed_points import missing_periods
    from orbitdb.store.filling import DONE

    done = [fill.p for fill in catalogue.fills(chosen.a) if fill.state == DONE]
    spans = chosen.periods or ((2, max(done, default=2)),)
    filled = [p for p in done if any(low <= p <= high for low, high in spans)]
    if not filled:
        raise InputError(f"no {chosen.describe()} is filled: run 'orbitdb fill --p 11 --a {chosen.a:g}'")
    highest = max(filled)
    if missing := missing_periods(highest, filled):
        note(f"left out or not filled: p = {', '.join(map(str, missing))}; averages lack their orbits")
    rows = catalogue.classes(replace(chosen, periods=tuple((p, p) for p in filled))).rows()
    if not len(rows):
        raise InputError(f"no {chosen.describe()}: nothing to draw")
    return rows, highest


def _draw_sheet(catalogue: "Catalogue", chosen: "Selection", limit: int) -> "Figure":
    from orbitdb.plots.paths import cell_size, draw_sheet
    from orbitdb.plots.style import figure, plain
    from orbitdb.stadium import Stadium

    if not chosen.periods:
        raise InputError("name a period for the sheet, such as --p 5")
    words = sorted(set(catalogue.select(chosen).representative.tolist()), key=lambda word: (len(word), word))
    orbits = [found for word in words[:limit] if (found := catalogue.find(word, chosen.a)) is not None]
    paths = [found.points for found in orbits if found.points is not None]
    if not paths:
        raise InputError(f"no {chosen.describe()}: nothing to draw")
    if len(words) > limit:
        note(f"{limit} of {len(words)} classes are drawn; --limit {len(words)} draws all")
    stadium = Stadium(chosen.a)
    wide, high = cell_size(stadium)
    columns = max(1, math.ceil(math.sqrt(0.8 * len(paths) * high / wide)))
    rows = math.ceil(len(paths) / columns)
    labels = [f"{_short(found.code)} ({found.class_size})" for found in orbits if found.points is not None]
    unit = 0.26
    with figure(max(4.0, columns * wide * unit), rows * high * unit + 0.6) as made:
        ax = made.add_subplot()
        draw_sheet(ax, stadium, paths, labels, columns)
        ax.set_title(f"Classes of {plain(chosen.describe())}: least word (class size)")
    return made


def _draw_birkhoff(catalogue: "Catalogue", chosen: "Selection", _limit: int) -> "Figure":
    import numpy as np

    from orbitdb.plots.curves import draw_birkhoff
    from orbitdb.plots.style import figure, plain
    from orbitdb.stability import Links
    from orbitdb.stadium import ANTICLOCKWISE, Stadium

    stadium = Stadium(chosen.a)
    subset = catalogue.select(chosen, coordinates=True)
    if not len(subset):
        raise InputError(f"no {chosen.describe()}: nothing to draw")
    place, sine, colour = [], [], []
    for p in np.unique(subset.p).tolist():
        words, coordinates = subset.of_period(p)
        place.append(stadium.arclength(words, coordinates).ravel())
        with np.errstate(all="ignore"):  # bounces of an altered row may be on one point
            sine.append((ANTICLOCKWISE[words] * Links.of(stadium, words, coordinates).cos_out).ravel())
        colour.append(np.repeat(subset.lambda_d[subset.p == p], p))
    with figure(7.2, 4.4) as made:
        ax = made.add_subplot()
        dots = draw_birkhoff(ax, stadium, *map(np.concatenate, (place, sine, colour)))
        made.colorbar(dots, ax=ax, label=r"$\lambda_d$ (per bounce)", pad=0.01, extend="both")
        made.suptitle(plain(chosen.describe()), fontsize=10)
    return made


def _draw_lengths(catalogue: "Catalogue", chosen: "Selection", _limit: int) -> "Figure":
    from orbitdb.plots.curves import draw_density, draw_staircase
    from orbitdb.plots.style import figure, plain

    found = catalogue.classes(chosen)
    if not len(found):
        raise InputError(f"no {chosen.describe()}: nothing to draw")
    with figure(6.4, 6.0) as made:
        above, below = made.subplots(2, 1, sharex=True)
        draw_staircase(above, found.length, found.chosen)
        draw_density(below, found.p, found.length, found.chosen)
        above.set(xlabel="", title=plain(chosen.describe()))
    return made


_FIGURES: "dict[Kind, Callable[[Catalogue, Selection, int], Figure]]" = {
    Kind.ENTROPY: _draw_entropy,
    Kind.LYAPUNOV: _draw_lyapunov,
    Kind.SHEET: _draw_sheet,
    Kind.BIRKHOFF: _draw_birkhoff,
    Kind.LENGTHS: _draw_lengths,
}
