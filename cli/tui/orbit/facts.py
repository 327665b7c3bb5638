"""What is known of an orbit, in words."""

from collections.abc import Callable, Sequence
from functools import partial
from textwrap import wrap
from typing import ClassVar

from rich.segment import Segment
from textual.geometry import Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from orbitdb.cli.orbit_facts import lives_text
from orbitdb.cli.render import number
from orbitdb.cli.tui.orbit.lives import bar
from orbitdb.cli.tui.orbit.pictures import phase_points
from orbitdb.numerals import upwards, with_bound
from orbitdb.orbits.orbit import Orbit
from orbitdb.plaintext import printable
from orbitdb.symbols.pruning import RULES
from orbitdb.symbols.words import run_notation

_LONGEST = 30
_MOST_BOUNCES = 60
_BAR = 24

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
    if orbit.exists:
        facts += [("exists", bar(orbit.exists, orbit.a, _BAR)), ("", lives_text(orbit.exists))]
    if orbit.class_size is not None:
        facts.append(("class", _class_of(orbit)))
    if orbit.time_reversal is not None:
        reverse = "retraces its path" if orbit.time_reversal == "self" else "its reverse is another orbit"
        facts.append(("reversal", reverse))
    if orbit.length is not None:
        proof = (
            "none stored"
            if certificate is None
            else f"radius {upwards(certificate[0])}, {certificate[1]} bits"
        )
        facts.append(("certificate", proof))
    facts.append(("stored", "yes" if orbit.stored else "no: solved on the spot"))
    return [(name, printable(sentence)) for name, sentence in facts]


def _numbers(orbit: Orbit) -> list[tuple[str, str]]:
    facts = []
    for name, bound in (("length", orbit.length_error), ("lyapunov", orbit.lyapunov_error)):
        value: float = getattr(orbit, name)
        facts.append((name, number(name, value) if bound is None else with_bound(value, bound, "±")))
    rates = [f"{number(name, getattr(orbit, name))}" for name in ("lambda_d", "lambda_c")]
    return [
        *facts,
        ("λ_d, λ_c", ", ".join(rates)),
        ("maslov", str(orbit.maslov)),
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


Line = list[tuple[str, str]]
"""A line as (text, style name), in pieces."""


def folded(facts: Sequence[tuple[str, str]], width: int) -> list[Line]:
    """Return facts, (name, sentence) by (name, sentence), as aligned lines of at most some width."""
    margin = max((len(name) for name, _ in facts), default=0) + 2
    lines: list[Line] = []
    for name, sentence in facts:
        first, *others = wrap(sentence, max(width - margin, 8)) or [""]
        lines.append([(name.ljust(margin), "name"), (first, "")])
        lines += [[(" " * margin + more, "")] for more in others]
    return lines


def lines_of(orbit: Orbit, certificate: Certificate, width: int) -> list[Line]:
    """Return the facts as aligned lines of at most some width, and the bounces below them."""
    lines = folded(facts_of(orbit, certificate), width)
    if orbit.coordinates is not None and orbit.p <= _MOST_BOUNCES:
        lines += [[], [("  n  symbol   coordinate  along wall       sine", "name")]]
        bounces = zip(orbit.code, orbit.coordinates.tolist(), phase_points(orbit).tolist(), strict=True)
        for n, (symbol, x, (way, sine)) in enumerate(bounces, 1):
            lines.append([(f"{n:>3}  {symbol:>6}  {x:>11.6f} {way:>11.6f} {sine:>10.6f}", "")])
    return lines


class FactsPanel(ScrollView, can_focus=True):
    """What is known of the orbit that is shown; its lines are folded to its width."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"facts--name"}

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._shown: Callable[[int], list[Line]] | None = None
        self._lines: list[Line] = []

    def show(self, orbit: Orbit | None, certificate: Certificate = None) -> None:
        """Show what is known of an orbit."""
        self.show_lines(None if orbit is None else partial(lines_of, orbit, certificate))

    def show_lines(self, lines: Callable[[int], list[Line]] | None) -> None:
        """Show some lines, which are asked for with the width there is."""
        self._shown = lines
        self._fold()
        self.scroll_to(y=0, animate=False, immediate=True)

    def on_resize(self) -> None:
        """Fold anew."""
        self._fold()

    def _fold(self) -> None:
        width = self.scrollable_content_region.width
        self._lines = [] if self._shown is None else self._shown(width)
        height = max(len(self._lines), self.size.height)  # a change of it lays the whole screen out
        self.virtual_size = Size(width, height)
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Draw one line."""
        width, base = self.scrollable_content_region.width, self.rich_style
        place = self.scroll_offset.y + y
        if place >= len(self._lines):
            return Strip.blank(width, base)
        name = base + self.get_component_rich_style("facts--name", partial=True)
        pieces = [Segment(text, name if style else base) for text, style in self._lines[place]]
        return Strip(pieces).adjust_cell_length(width, base)
