"""What is known of an orbit, in words."""

from rich.console import Group
from rich.table import Table
from rich.text import Text

from orbitdb.cli.render import number
from orbitdb.cli.tui.pictures import phase_points
from orbitdb.orbits import Orbit
from orbitdb.pruning import RULES
from orbitdb.words import run_notation

_LONGEST = 30
_MOST_BOUNCES = 60

Certificate = tuple[float, int] | None


def facts_of(orbit: Orbit, certificate: Certificate = None) -> list[tuple[str, str]]:
    """Return what is known of a word, (name, sentence) by (name, sentence).

    Parameters
    ----------
    orbit : Orbit
    certificate : tuple of float and int, optional
        Radius and bits of its proof.
    """
    facts = [("code", _short(orbit.code)), ("status", orbit.status.sentence)]
    facts += [(f"rule {rule.number}", rule.sentence) for rule in RULES if rule.number in orbit.rules]
    if run_notation(orbit.code) != orbit.code:
        facts.insert(1, ("runs", run_notation(orbit.code)))
    facts.append(("period", str(orbit.p)))
    if orbit.length is not None:
        facts += _numbers(orbit)
    elif orbit.margin is not None:
        facts.append(("margin", f"{number('margin', orbit.margin)}, outside"))
    if orbit.class_size is not None:
        facts.append(("class", _class_of(orbit)))
    if orbit.time_reversal is not None:
        reverse = "retraces its path" if orbit.time_reversal == "self" else "its reverse is another orbit"
        facts.append(("reversal", reverse))
    if orbit.length is not None:
        proof = (
            "none stored" if certificate is None else f"radius {certificate[0]:.0e}, {certificate[1]} bits"
        )
        facts.append(("certificate", proof))
    facts.append(("stored", "yes" if orbit.stored else "no: solved on the spot"))
    return facts


def _numbers(orbit: Orbit) -> list[tuple[str, str]]:
    facts = []
    for name, bound in (("length", orbit.length_error), ("lyapunov", orbit.lyapunov_error)):
        error = "" if bound is None else f" ± {number('error', bound)}"
        facts.append((name, number(name, getattr(orbit, name)) + error))
    rates = [f"{number(name, getattr(orbit, name))}" for name in ("lambda_d", "lambda_c")]
    return [
        *facts,
        ("λ_d, λ_c", ", ".join(rates)),
        ("margin", f"{number('margin', orbit.margin)}, error {number('error', orbit.error)}"),
    ]


def _class_of(orbit: Orbit) -> str:
    symmetry = "no symmetry" if orbit.symmetry == "1" else f"symmetry {orbit.symmetry}"
    return f"{orbit.class_size} of {_short(orbit.representative)}, {symmetry}"


def _short(word: str) -> str:
    if len(word) <= _LONGEST:
        return word
    runs = run_notation(word)
    return runs if len(runs) <= 2 * _LONGEST else f"{runs[:_LONGEST]}…"


def as_table(orbit: Orbit, certificate: Certificate = None) -> Group:
    """Return the facts as aligned lines, and the bounces below them."""
    facts = Table.grid(padding=(0, 2, 0, 0))
    facts.add_column(style="bold", no_wrap=True)
    for name, sentence in facts_of(orbit, certificate):
        facts.add_row(name, Text(sentence))
    if orbit.coordinates is None or orbit.p > _MOST_BOUNCES:
        return Group(facts)
    bounces = Table.grid(padding=(0, 2, 0, 0))
    bounces.add_row("", *(Text(title, "bold") for title in ("", "coordinate", "along the wall", "sine")))
    for n, (symbol, x, (way, sine)) in enumerate(
        zip(orbit.code, orbit.coordinates.tolist(), phase_points(orbit).tolist(), strict=True), 1
    ):
        numbers = (f"{value:>{width}.6f}" for value, width in ((x, 10), (way, 14), (sine, 9)))
        bounces.add_row(f"{n:>3}", symbol, *numbers)
    return Group(facts, Text(""), bounces)
