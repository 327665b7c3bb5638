"""Choose a subset: each change gives a new `Selection`, which describes itself."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.errors import InputError
from orbitdb.numerals import exact, real
from orbitdb.orbits.status import Status
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation, parse, primitive_root

SHOWN = (Status.ORBIT, Status.DYNAMICAL, Status.BOUNDARY, Status.GEOMETRIC, Status.UNRESOLVED)
"""The statuses of rows."""

STATUSES: tuple[tuple[Status, ...], ...] = ((), *((status,) for status in SHOWN))
REVERSALS = (None, "self", "pair")


def half_length(text: str) -> float:
    """Read a half length, or explain how to write one."""
    try:
        value = real(text.strip())
    except ValueError:
        raise InputError(f"a = {text!r}: write a number such as 1.6") from None
    return Stadium(value).a


def code_told(code: str) -> str:
    """Describe a code."""
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {code_text(least_rotation(word))}"


def turned(selection: Selection, name: str, ring: Sequence[Any], step: int = 1) -> Selection:
    """Choose the value some steps further in a ring; other values count as the first."""
    present = getattr(selection, name)
    place = ring.index(present) if present in ring else 0
    return replace(selection, **{name: ring[(place + step) % len(ring)]})


def chips(selection: Selection, a_values: Sequence[float]) -> str:
    """Return the choices as one line with links to the actions that change them."""
    spans = ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    status = ", ".join(selection.statuses) or "every status"
    reversal = {"self": "self-retracing", "pair": "with a reverse", None: "any reversal"}
    several = f", one of {len(a_values)} stadiums" if len(a_values) > 1 else ""
    stored = several if selection.a in (a_values or [selection.a]) else ", not filled"
    parts = [
        ("choose_a", f"a = {exact(selection.a)}{stored}"),
        ("period(1)", f"p {spans or 'all'}"),
        ("status", status),
        ("reversal", reversal[selection.time_reversal]),
        ("filter", escaped(selection.describe_rest()) or "no filter"),
    ]
    return " │ ".join(f"[@click=screen.{action}]{text}[/]" for action, text in parts)


def escaped(text: str) -> str:
    """Return a text escaped for markup."""
    return printable(text).replace("\\", "\\\\").replace("[", "\\[")
