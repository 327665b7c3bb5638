"""Dialogs with a line of text, checked as it is typed; the rows of a filter follow."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.timer import Timer
from textual.widgets import Input, Label, OptionList

from orbitdb.cli.tui.dialogs.lists import NameList
from orbitdb.cli.tui.screens import ESCAPE, Dialog, Field, key
from orbitdb.errors import InputError, StoreError
from orbitdb.store.asking.where import unfinished

if TYPE_CHECKING:
    from orbitdb.cli.tui.panels import Panels

_PAUSE = 0.25
"""Seconds without a key before rows are read."""


class LineDialog(Dialog[str | None]):
    """Ask for a line, check it as it is typed, and list other lines to choose from.

    The check returns the meaning of a line, or raises an error that explains its fault.
    """

    AUTO_FOCUS = "Input"
    EMPTY: str | None = None
    """The meaning of an empty line."""
    BINDINGS: ClassVar[list[BindingType]] = [ESCAPE, key("up", "older(1)"), key("down", "older(-1)")]

    def __init__(
        self,
        title: str,
        value: str = "",
        placeholder: str = "",
        check: Callable[[str], str] = lambda _: "",
        others: Sequence[str] = (),
    ) -> None:
        super().__init__()
        self._title, self._placeholder = title, placeholder
        self._check_line = check
        self._lines = [*dict.fromkeys(line for line in others if line != value), value]
        self._place = len(self._lines) - 1

    def compose(self) -> ComposeResult:
        """Show the lines to choose from, the typed line, and its fault."""
        others = self._lines[:-1]
        with Vertical(classes="dialog bottom") as box:
            box.border_title = self._title
            box.border_subtitle = "enter takes it, escape leaves" + (", ↑ ↓ choose" if others else "")
            if others:
                yield NameList(*map(Text, others), classes="others")
            yield Field(self._lines[-1], placeholder=self._placeholder)
            yield Label("", classes="complaint", markup=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Follow the typing."""
        self.follow(event.value)

    def follow(self, text: str) -> None:
        """Show the fault or the meaning of a line at once."""
        self.tell(*self.checked(text))

    def checked(self, text: str) -> tuple[str, bool]:
        """Return the meaning or fault of a line, and whether it is wrong."""
        try:
            return (self._check_line(text) if text.strip() else ""), False
        except (InputError, StoreError) as error:
            return str(error), True

    def tell(self, text: str, wrong: bool = False) -> None:
        """Show a text about the line."""
        self.query_one(Input).set_class(wrong, "-wrong")
        self.query_one(Label).set_class(not wrong, "-note").update(text)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Accept the line if it is valid."""
        told, wrong = self.checked(event.value)
        if wrong:
            self.tell(told, wrong)
        else:
            self.dismiss(event.value.strip() or self.EMPTY)

    def action_older(self, steps: int) -> None:
        """Go up and down in the lines; the typed one is the last."""
        self._take_up(max(0, min(self._place - steps, len(self._lines) - 1)))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Use the line under the mouse."""
        self._take_up(event.option_index)

    def _take_up(self, place: int) -> None:
        self._place, line = place, self.query_one(Input)
        line.value = self._lines[place]
        line.cursor_position = len(line.value)
        line.focus()
        for listed in self.query(OptionList):
            listed.highlighted = place if place < listed.option_count else None


class FilterDialog(LineDialog):
    """Ask for a filter, and try it as it is typed: the main screen shows its rows and reports.

    The cursor stays on its word if that is among the rows, and at the top if it was there.
    """

    EMPTY = ""

    def __init__(self, main: "Panels", where: str, others: Sequence[str]) -> None:
        placeholder = "lambda_c < 0.5 and time_reversal = 'self'"
        super().__init__("filter, as in --where", where, placeholder, main.check_filter, others)
        row = main.rows.table.row if main.rows.table.cursor else None
        self._main, self.word = main, row[0] if row else None
        self._tried, self._note = where.strip(), ""
        self._timer: Timer | None = None

    def on_mount(self) -> None:
        """Follow the shown rows."""
        self.watch(self._main.rows, "report", self._say)

    def _say(self) -> None:
        self.tell("; ".join(filter(None, (self._main.rows.report, self._note))))

    def follow(self, text: str) -> None:
        """Try the line after a moment without keys; until then, the last valid rows stay."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if text.strip() != self._tried:
            self._main.rows.stop_reading()
        told, wrong = self.checked(text)
        if wrong and not unfinished(text, told):
            self.tell(told, wrong)
            return
        self._note = "the line is not complete yet" if wrong else told
        self._say()
        if not wrong:
            self._timer = self.set_timer(_PAUSE, partial(self._try, text.strip()))

    def _try(self, where: str) -> None:
        self._timer, self._tried = None, where
        self._main.try_filter(where, self.word)
