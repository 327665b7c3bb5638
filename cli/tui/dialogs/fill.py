"""The dialog that asks what to fill, says what that is going to take, and shows how far it is."""

from typing import TYPE_CHECKING, ClassVar, cast

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.widgets import Button, Input, Label, ProgressBar

from orbitdb.cli.tui.dialogs.fill_state import Cost, FillState, Wish, cost_of, parse_wish
from orbitdb.cli.tui.screens import ESCAPE, Dialog, QuestionDialog
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.cli.tui.app import BrowseApp

_FIELDS = (
    ("a", "half length a", ""),
    ("periods", "periods", "2-11"),
    ("codes", "or codes", "1^20(02)^5 3, 1232131"),
)


class FillDialog(Dialog[None]):
    """Ask what to fill, beginning with an a and periods; while something is filled, show how far it is."""

    BINDINGS: ClassVar[list[BindingType]] = [ESCAPE]

    AUTO_FOCUS = "#periods"  # a focus that is set later comes behind the first keys

    def __init__(self, a: str, periods: str) -> None:
        super().__init__()
        self._values = {"a": a, "periods": periods, "codes": ""}

    @property
    def _browser(self) -> "BrowseApp":
        return cast("BrowseApp", self.app)

    def compose(self) -> ComposeResult:
        """Show the fields, what they take, and the progress."""
        with VerticalScroll(classes="dialog", can_focus=False) as box:
            box.border_title = "fill the catalogue"
            box.border_subtitle = "escape closes this; the fill goes on"
            for name, title, example in _FIELDS:
                with Horizontal(classes="field"):
                    yield Label(title)
                    yield Input(self._values[name], placeholder=example, id=name, compact=True)
            yield Label("", id="cost", markup=False)
            yield ProgressBar(show_eta=False, id="bar")
            yield Label("", id="told", markup=False)
            with Horizontal(classes="buttons"):
                yield Button("Fill", id="start", variant="primary")
                yield Button("Stop", id="stop", variant="error")

    def on_mount(self) -> None:
        """Follow the fill that may be running."""
        if self._browser.fills:
            self.query_one("#stop").focus()
        self.watch(self.app, "fill_state", self._follow)

    def _follow(self, state: FillState | None) -> None:
        runs = self._browser.fills
        self.query_one("#start", Button).disabled = runs
        self.query_one("#stop", Button).disabled = not runs
        self.query_one("#cost").display = not runs
        bar = self.query_one("#bar", ProgressBar)
        bar.display = state is not None
        if state is not None:
            bar.update(total=state.total or None, progress=state.done)
            self.query_one("#told", Label).update(state.sentence())
            self._weigh_fields()

    def on_input_changed(self) -> None:
        """Say what the fields are going to take."""
        self.query_one("#periods", Input).disabled = bool(self.query_one("#codes", Input).value.strip())
        self._weigh_fields()

    def on_input_submitted(self) -> None:
        """Begin."""
        self._weigh_fields(begin=True)

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Begin or stop."""
        if event.button.id == "start":
            self._weigh_fields(begin=True)
        else:
            self._browser.action_stop_fill()

    def _weigh_fields(self, begin: bool = False) -> None:
        """Ask what the fields are going to take; begin, if that is wanted, as soon as it is known."""
        if self._browser.fills:
            return
        try:
            wish = parse_wish(*(self.query_one(f"#{name}", Input).value for name, _, _ in _FIELDS))
        except InputError as error:
            self.give_up("cost")
            self._say(str(error), wrong=True)
            return
        self.in_thread(
            "cost",
            lambda _: cost_of(self._browser.path, wish),
            lambda cost: self._take_cost(wish, cost, begin),
            lambda told: self._say(told, wrong=True),
        )

    def _take_cost(self, wish: Wish, cost: Cost, begin: bool) -> None:
        """Say what the wish takes; begin, or ask first where that is much."""
        self._say(cost.sentence)
        if not begin or cost.nothing or self._browser.fills:
            return
        if not cost.large:
            self._browser.begin_fill(wish)
            return
        question = f"{cost.sentence}. It can be stopped at any time, and goes on later where it was."
        dialog = QuestionDialog(question, "Fill", "Leave it")
        self.app.push_screen(dialog, lambda sure: self._browser.begin_fill(wish) if sure else None)

    def _say(self, text: str, wrong: bool = False) -> None:
        self.query_one("#cost", Label).set_class(wrong, "-wrong").update(text)
