"""Describe a word and its bounces as text for people."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from orbitdb.cli.output import LONG_CODE, Format, Output, code_text, number, write
from orbitdb.text import in_brackets, several, with_bound

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit

_MOST_BOUNCES = 40
"""Maximum number of bounces to list."""

_NUMBERS = ("length", "lyapunov", "lambda_d", "lambda_c", "maslov", "margin", "residual", "error")


def facts(
    orbit: "Orbit",
    born_with: Sequence[tuple[float, list[str]]] = (),
    sign: str = "+-",
    output: Output | None = None,
) -> list[tuple[str, str]]:
    """Return the facts about a word, and the words born with it, as pairs of a name and a text."""
    from orbitdb.orbits.births import closed_form
    from orbitdb.orbits.status import EXISTING
    from orbitdb.symbols.pruning import RULES
    from orbitdb.symbols.words import run_notation
    from orbitdb.text import format_float

    code = orbit.code if orbit.p <= LONG_CODE else run_notation(orbit.code)
    facts = [
        ("code", code),
        ("a", format_float(orbit.a)),
        ("p", str(orbit.p)),
        ("status", orbit.status.sentence),
    ]
    facts += [(f"  rule {rule.number}", rule.sentence) for rule in RULES if rule.number in orbit.rules]
    if orbit.exists:
        facts.append(("exists", lives_text(orbit.exists)))
    ends = sorted({end for life in orbit.exists or () for end in life if end})
    forms = ((end, closed_form(end)) for end in ends)
    facts += [(f"  {end:.9g}", f"{form}, recognised numerically") for end, form in forms if form is not None]
    facts += [(f"  born at {a:.9g}", f"with {', '.join(map(code_text, words))}") for a, words in born_with]
    for name in _NUMBERS if orbit.length is not None else ("margin",):
        value, bound = getattr(orbit, name), getattr(orbit, f"{name}_error", None)
        if value is not None:
            facts.append((name, _said(name, value, bound, sign, output)))
    if orbit.class_size is not None:
        words, least = several(orbit.class_size, "word"), code_text(orbit.representative)
        another = "orbit" if orbit.status in EXISTING else "word"
        retraces = orbit.time_reversal == "self"
        reversal = "retraces its path" if retraces else f"its reverse is another {another}"
        symmetry = "no symmetry" if orbit.symmetry == "1" else f"symmetry {orbit.symmetry}"
        facts += [("time_reversal", reversal), ("class", f"{words}, least {least}, {symmetry}")]
    return [*facts, ("stored", "yes" if orbit.stored else "no: solved on the spot")]


def _said(name: str, value: Any, bound: float | None, sign: str, output: Output | None) -> str:
    """Return a number of an orbit as text, with its bound, if there is one, or as the options ask."""
    if bound is None or (output is not None and output.digits is not None):
        return number(name, value, output.digits if output else None)
    return in_brackets(value, bound) if output and output.uncertainty else with_bound(value, bound, sign)


def lives_text(lives: Sequence[tuple[float, float | None]]) -> str:
    """Describe the values of `a` at which a word is an orbit, given its lives (birth, death or None)."""
    return ", and ".join(
        ("for every a" if not low else f"for a > {low:.12g}") if high is None else
        (f"for a < {high:.12g}" if not low else f"for {low:.12g} < a < {high:.12g}")
        for low, high in lives
    )  # fmt: skip


_WALLS = ("bottom", "left, up", "top", "right, up", "left, down", "right, down")


def write_bounces(orbit: "Orbit") -> None:
    """Write the bounces of an orbit, unless there are too many for a screen."""
    if orbit.coordinates is None or orbit.p > _MOST_BOUNCES:
        return
    from orbitdb.orbits.bounces import bounce_rows

    (bounces,) = bounce_rows(orbit.a, [orbit.code], [orbit.coordinates])
    rows = (
        (n, symbol, _wall(orbit.code, n - 1), coordinate, x, y) for n, symbol, coordinate, x, y, *_ in bounces
    )
    print()
    write(("n", "symbol", "wall", "coordinate", "x", "y"), rows, Format.TABLE)


def _wall(code: str, n: int) -> str:
    """Return the wall of a bounce; only runs of several bounces on a semicircle go up or down."""
    name = _WALLS[int(code[n])]
    alone = code[n - 1] != code[n] and code[(n + 1) % len(code)] != code[n]
    return name.partition(",")[0] if alone else name
