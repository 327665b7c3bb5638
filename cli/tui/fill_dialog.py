"""The dialog that fills the catalogue: what to fill, an estimate of the cost, and the progress."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

from textual.app import ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.message import Message
from textual.widgets import Button, Input, Label

from orbitdb.cli.grids import half_length
from orbitdb.cli.tui.screens import Dialog, Field, QuestionDialog
from orbitdb.period_ranges import periods_to_make
from orbitdb.progress import Tell, Work
from orbitdb.selection import Selection
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import parse, primitive_root
from orbitdb.text import format_float, several

_FIELDS = (
    ("a", "half length a", ""),
    ("periods", "periods", "2-11"),
    ("codes", "or codes", "1^20(02)^5 3, 1232131"),
)
_LINE = 54
"""Columns of the line that says how far a fill is."""


class FillRequest(NamedTuple):
    """What to fill: periods or single words, in the stadium with half length `a`."""

    a: float
    periods: tuple[int, ...] = ()
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class FillState:
    """What is filled, how far the work is, and the number of words done.

    `stored` is the number of words that were stored before, once it is known.
    `state` is ``running``, ``stopping``, ``done``, ``stopped`` or ``failed``, and `message` says why a fill
    failed.
    """

    request: FillRequest
    state: str = "running"
    done: int = 0
    stored: int | None = None
    message: str = ""
    work: Work = field(default_factory=lambda: Work("filling"))

    @property
    def runs(self) -> bool:
        return self.state in ("running", "stopping")

    def sentence(self, columns: int = _LINE) -> str:
        if self.runs:
            line = self.work.line(columns, time.monotonic())
            return line if self.state == "running" else f"{self.state}: {line}"
        return self.message if self.state == "failed" else f"{self.state}: {_words(self.done)}"


def _words(count: int) -> str:
    return f"{count:,} word{'s' * (count != 1)}"


def parse_request(a: str, periods: str, codes: str) -> FillRequest:
    """Read what to fill from the fields; raise an error that names the unreadable part."""
    value = half_length(a)
    if codes.strip():
        return FillRequest(value, words=tuple(primitive_root(parse(code)) for code in codes.split(",")))
    return FillRequest(value, periods=periods_to_make(periods))


def cost_of(path: Path, request: FillRequest) -> tuple[str, int]:
    """Return the estimated cost and the number of words to fill; raise if the disk has too little room."""
    from orbitdb.catalogue import Catalogue
    from orbitdb.filling.estimate import about
    from orbitdb.text import gigabytes

    at = f"at a = {format_float(request.a)}"
    if request.words:
        return f"{several(len(request.words), 'word')} to solve {at}", len(request.words)
    catalogue = Catalogue(path, missing_ok=True)
    coming = catalogue.estimate(request.periods, a=request.a)
    if not coming.words:
        return f"these periods are already filled {at}: nothing to do", 0
    catalogue._check_room(coming)
    takes = f"{about(coming.seconds)}, up to {gigabytes(coming.bytes)}"
    return f"{_words(coming.words)} to fill {at}: {takes}", coming.words


def fill_request(path: Path, request: FillRequest, tell: Tell) -> None:
    """Create the catalogue if it is missing, and fill it; call `tell` after every stored batch."""
    from orbitdb.catalogue import Catalogue

    catalogue = Catalogue.create(path, request.a)
    if request.periods:
        catalogue.fill(request.periods, progress=tell)
    if request.words:
        catalogue.fill(code=request.words)
        tell(len(request.words), len(request.words), "words")


class FillDialog(Dialog[None]):
    """Ask what to fill, and show the progress of a running fill.

    It proposes all periods up to the highest chosen one that is not filled. If all chosen periods are filled,
    it proposes those up to the one after the highest filled period.
    """

    AUTO_FOCUS = "#periods"  # focus given later would miss the first keys

    @dataclass
    class Begin(Message):
        """Asks the application to begin a fill."""

        request: FillRequest

    class Stop(Message):
        """Asks the application to stop the fill after the current batch."""

    def __init__(self, path: Path, selection: Selection, filled: Sequence[int]) -> None:
        super().__init__()
        wanted = [high for _, high in selection.periods if high not in filled]
        top = min(max(wanted, default=max(filled, default=10) + 1), MAX_PERIOD)
        self._path = path
        self._values = {"a": format_float(selection.a), "periods": f"2-{top}", "codes": ""}
        self._fills = False

    def compose(self) -> ComposeResult:
        with VerticalScroll(classes="dialog", can_focus=False) as box:
            box.border_title = "fill the catalogue"
            for name, title, example in _FIELDS:
                with Horizontal(classes="field"):
                    yield Label(title)
                    yield Field(self._values[name], placeholder=example, id=name, compact=True)
            yield Label("", id="cost", markup=False)
            yield Label("", id="progress", markup=False)
            with Horizontal(classes="buttons"):
                yield Button("Fill", id="start", compact=True)
                yield Button("Stop", id="stop", compact=True)

    def on_mount(self) -> None:
        self.follow(getattr(self.app, "fill_state", None))
        if self._fills:
            self.query_one("#stop").focus()

    def follow(self, state: FillState | None) -> None:
        """Show how far the fill is; close when it is done."""
        if self._fills and state is not None and state.state == "done":
            self.dismiss()
        self._fills = runs = state is not None and state.runs
        self.query_one("#start").display = not runs
        self.query_one("#stop").display = runs
        self.query_one(VerticalScroll).border_subtitle = f"escape closes this{'; the fill continues' * runs}"
        self.query_one("#cost").display = not runs
        self._weigh_fields()
        if state is not None:
            self.query_one("#progress", Label).update(state.sentence())

    def on_input_changed(self) -> None:
        self.query_one("#periods", Input).disabled = bool(self.query_one("#codes", Input).value.strip())
        self._weigh_fields()

    def on_input_submitted(self) -> None:
        self._weigh_fields(begin=True)

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "start":
            self._weigh_fields(begin=True)
        else:
            self.app.post_message(self.Stop())

    def _weigh_fields(self, begin: bool = False) -> None:
        if self._fills:
            return
        self.query_one("#progress", Label).update("")  # how the last fill ended no longer matters
        fields = [self.query_one(f"#{name}", Input).value for name, _, _ in _FIELDS]

        def weigh(_: object) -> tuple[FillRequest, str, int]:
            request = parse_request(*fields)
            return request, *cost_of(self._path, request)

        def take(cost: tuple[FillRequest, str, int]) -> None:
            """Show the estimate; if requested, begin, but ask first if the fill is large."""
            from orbitdb.filling.estimate import LARGE

            request, estimate, words = cost
            self._say(estimate)
            if not begin or not words or self._fills:
                return
            if words < LARGE:
                self.app.post_message(self.Begin(request))
                return
            question = f"{estimate}. You can stop the fill at any time and resume it later."
            self.ask(
                QuestionDialog(question, "Fill", "Cancel"),
                lambda sure: sure and self.app.post_message(self.Begin(request)),
            )

        self.in_thread("cost", weigh, take, partial(self._say, wrong=True))

    def _say(self, text: str, wrong: bool = False) -> None:
        self.query_one("#cost", Label).set_class(wrong, "-wrong").update(text)
