"""A subset for notebooks: a table of its first rows, with a small picture of each orbit."""

from collections.abc import Sequence
from html import escape

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.svg import small_svg

MOST_ROWS = 10
MOST_BOUNCES = 200
"""A small picture of longer orbits would show nothing."""

_HEADINGS = ("", "code", "p", "status", "length", "&lambda;", "&lambda;<sub>d</sub>", "&lambda;<sub>c</sub>",
             "class", "symmetry")  # fmt: skip


def subset_html(title: str, orbits: Sequence[Orbit], total: int) -> str:
    """Return a table of some orbits.

    Parameters
    ----------
    title : str
        What they are.
    orbits : sequence of Orbit
        Those that are shown.
    total : int
        How many there are in all.
    """
    head = "".join(f"<th>{heading}</th>" for heading in _HEADINGS)
    rows = "\n".join(_row(orbit) for orbit in orbits)
    more = f"<p>&hellip; and {total - len(orbits):,} more</p>" if total > len(orbits) else ""
    return f"<p>{escape(title)}</p>\n<table>\n<tr>{head}</tr>\n{rows}\n</table>\n{more}"


def _row(orbit: Orbit) -> str:
    points = orbit.points
    picture = "" if points is None or orbit.p > MOST_BOUNCES else small_svg(Stadium(orbit.a), points)
    texts = (_short(orbit.code), str(orbit.p), orbit.status, _number(orbit.length), _number(orbit.lyapunov),
             _number(orbit.lambda_d), _number(orbit.lambda_c), str(orbit.class_size or ""),
             orbit.symmetry or "")  # fmt: skip
    return f"<tr><td>{picture}</td>" + "".join(f"<td>{escape(text)}</td>" for text in texts) + "</tr>"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.7g}"


def _short(code: str) -> str:
    return code if len(code) <= 40 else f"{code[:37]}..."
