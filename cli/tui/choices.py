"""Choosing a subset: each change gives a new `Selection`, which describes itself."""

from dataclasses import replace

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.errors import InputError
from orbitdb.numerals import real
from orbitdb.orbits.orbit import Status
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation, parse, primitive_root

SHOWN = (Status.ORBIT, Status.DYNAMICAL, Status.BOUNDARY, Status.GEOMETRIC, Status.UNRESOLVED)
"""The statuses that rows may have."""

_STATUSES: tuple[tuple[Status, ...], ...] = ((), *((status,) for status in SHOWN))
_REVERSALS = (None, "self", "pair")


def half_length(text: str) -> float:
    """Read a half length.

    Raises
    ------
    InputError
        If it is none; the message says how to write it.
    """
    try:
        return Stadium(real(text.strip())).a
    except InputError:
        raise
    except ValueError:
        raise InputError(f"a = {text!r}: write a number such as 1.6") from None


def code_told(code: str) -> str:
    """Say what a code is."""
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {code_text(least_rotation(word))}"


def next_status(selection: Selection) -> Selection:
    """Choose the next status: all, orbits, dynamically pruned words and so on."""
    place = _STATUSES.index(selection.statuses) if selection.statuses in _STATUSES else -1
    return replace(selection, statuses=_STATUSES[(place + 1) % len(_STATUSES)])


def next_reversal(selection: Selection) -> Selection:
    """Choose all words, those that retrace their path, or the others."""
    place = _REVERSALS.index(selection.time_reversal)
    return replace(selection, time_reversal=_REVERSALS[(place + 1) % len(_REVERSALS)])


def other_period(selection: Selection, known: list[int], step: int) -> Selection:
    """Choose one period, the next or the one before; beyond the ends stand all of them."""
    ring = [None, *known]
    now = selection.periods[0][0] if len(selection.periods) == 1 else None
    place = ring.index(now) if now in ring else 0
    period = ring[(place + step) % len(ring)]
    return replace(selection, periods=() if period is None else ((period, period),))


def chips(selection: Selection, a_values: int) -> str:
    """Return the choices as one line with links to the actions that change them."""
    spans = ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    status = ", ".join(selection.statuses) or "every status"
    reversal = {"self": "self-retracing", "pair": "with a reverse", None: "any reversal"}
    parts = [
        ("choose_a", f"a = {selection.a:g}" + (f" of {a_values}" if a_values > 1 else "")),
        ("period(1)", f"p {spans or 'all'}"),
        ("status", status),
        ("reversal", reversal[selection.time_reversal]),
        ("filter", escaped(selection.describe_rest()) or "no filter"),
    ]
    return " │ ".join(f"[@click=screen.{action}]{text}[/]" for action, text in parts)


def escaped(text: str) -> str:
    """Return a text that stands for itself where markup is read."""
    return printable(text).replace("\\", "\\\\").replace("[", "\\[")
