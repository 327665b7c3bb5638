"""Computing: the dialog that asks what to fill, and how far a fill has come."""

import time
from collections.abc import Generator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, ProgressBar

from orbitdb.errors import InputError


@dataclass(frozen=True)
class Wish:
    """What to fill: periods, or words."""

    a: float
    periods: tuple[int, ...] = ()
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class FillState:
    """How far a fill has come.

    Attributes
    ----------
    wish : Wish
    state : str
        ``running``, ``stopping``, ``done``, ``stopped`` or ``failed``.
    done, total : int
        Words of all periods, or words chosen.
    p : int
        The period at work.
    began : float
        When, on the monotonic clock.
    message : str
        What went wrong.
    """

    wish: Wish
    state: str = "running"
    done: int = 0
    total: int = 0
    p: int = 0
    began: float = field(default_factory=time.monotonic)
    message: str = ""

    @property
    def runs(self) -> bool:
        """Whether it is at work."""
        return self.state in ("running", "stopping")

    def sentence(self) -> str:
        """Say how far it is."""
        if self.state == "failed":
            return self.message
        if not self.runs:
            return f"{self.state}: {self.done:,} sequences"
        seconds = time.monotonic() - self.began
        rate = self.done / seconds if seconds > 0 else 0.0
        left = f", {(self.total - self.done) / rate:.0f} s left" if rate else ""
        share = 100 * self.done / self.total if self.total else 0
        return f"{self.state}: p = {self.p}, {share:.0f}%, {rate:,.0f}/s{left}"


def parse_wish(a: str, periods: str, codes: str) -> Wish:
    """Read what to fill.

    Raises
    ------
    InputError
        If a part cannot be read.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.store.asking.selection import parse_periods
    from orbitdb.symbols.enumeration import MAX_PERIOD
    from orbitdb.symbols.words import parse, primitive_root

    try:
        stadium = Stadium(float(a))
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"a = {a!r}: write a number such as 1.6") from None
    if codes.strip():
        return Wish(stadium.a, words=tuple(primitive_root(parse(code)) for code in codes.split(",")))
    spans = parse_periods(periods)
    if not all(low >= 2 and high <= MAX_PERIOD for low, high in spans):
        raise InputError(f"periods {periods!r}: fill from 2 to {MAX_PERIOD}")
    return Wish(stadium.a, periods=tuple(sorted({p for low, high in spans for p in range(low, high + 1)})))


def work(path: Path, state: FillState) -> Generator[FillState, None, None]:
    """Fill, and tell how far it is behind every batch that is safely stored."""
    from orbitdb.filling.periods import fill_periods
    from orbitdb.filling.single_word import fill_word
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.symbols.counting import count_admissible

    Catalogue.create(path)
    wish = state.wish
    if wish.words:
        for count, word in enumerate(wish.words, 1):
            fill_word(path, word, wish.a)
            yield replace(state, done=count, total=len(wish.words), p=len(word))
        return
    counts = {p: count_admissible(p) for p in wish.periods}
    steps = fill_periods(path, wish.a, wish.periods)
    for step in steps:
        before = sum(count for p, count in counts.items() if p < step.p)
        yield replace(state, done=before + step.words, total=sum(counts.values()), p=step.p)


class FillDialog(ModalScreen[Wish | None]):
    """Ask what to fill; while something is filled, show how far it is."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss(None)", show=False)]

    class Begun(Message):
        """Somebody wants something filled."""

        def __init__(self, wish: Wish) -> None:
            super().__init__()
            self.wish = wish

    def __init__(self, a: float, periods: str, state: FillState | None) -> None:
        super().__init__()
        self._a, self._periods = a, periods
        self._state = state

    def compose(self) -> ComposeResult:
        """Show the fields and the progress."""
        with Vertical(classes="dialog") as box:
            box.border_title = "fill the catalogue"
            box.border_subtitle = "escape hides this; a fill goes on"
            yield Label("half length a")
            yield Input(f"{self._a:g}", id="a")
            yield Label("periods, such as 2-11")
            yield Input(self._periods, id="periods")
            yield Label("or codes, with commas between, of any order")
            yield Input(placeholder="1^20(02)^5 3", id="codes")
            yield ProgressBar(show_eta=False, id="bar")
            yield Label("", id="told", markup=False)
            with Horizontal(classes="buttons"):
                yield Button("Fill", id="start", variant="primary")
                yield Button("Stop", id="stop", variant="error")

    def on_mount(self) -> None:
        """Follow the fill that may be running."""
        self.query_one("#periods" if self._state is None or not self._state.runs else "#stop").focus()
        self.watch(self.app, "fill_state", self._follow)

    def _follow(self, state: FillState | None) -> None:
        runs = state is not None and state.runs
        self.query_one("#start", Button).disabled = runs
        self.query_one("#stop", Button).disabled = not runs
        bar = self.query_one("#bar", ProgressBar)
        bar.display = state is not None
        if state is not None:
            bar.update(total=state.total or None, progress=state.done)
            self.query_one("#told", Label).update(state.sentence())

    def on_input_submitted(self) -> None:
        """Begin."""
        self._begin()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Begin or stop."""
        if event.button.id == "start":
            self._begin()
        else:
            self.run_worker(self.app.run_action("stop_fill"))

    def _begin(self) -> None:
        if self.query_one("#start", Button).disabled:
            return
        texts = [self.query_one(f"#{name}", Input).value for name in ("a", "periods", "codes")]
        try:
            wish = parse_wish(*texts)
        except InputError as error:
            self.query_one("#told", Label).update(str(error))
            return
        self.post_message(self.Begun(wish))
