"""Dialogs that ask for a line of text and check it as it is typed."""

from collections.abc import Callable, Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.widgets import Input, Label, OptionList

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.cli.tui.dialogs.lists import NameList
from orbitdb.cli.tui.keys import key
from orbitdb.cli.tui.screens import Dialog, Field
from orbitdb.errors import InputError, StoreError
from orbitdb.numerals import real
from orbitdb.symbols.words import least_rotation, parse, primitive_root


class LineDialog(Dialog[str | None]):
    """Ask for a line of text, check it as it is typed, and offer other lines to choose from.

    `check` returns what a line means, or raises an error that says what is wrong with it.
    """

    AUTO_FOCUS = "Input"
    EMPTY: str | None = None
    """The answer if the line is empty."""
    BINDINGS: ClassVar[list[BindingType]] = [key("up", "older(1)"), key("down", "older(-1)")]

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
        """Lay out the lines to choose from, the field, and the message about the line."""
        others = self._lines[:-1]
        with Vertical(classes="dialog bottom") as box:
            box.border_title = self._title
            box.border_subtitle = "enter accepts, escape cancels" + (", ↑ ↓ choose" if others else "")
            if others:
                yield NameList(*map(Text, others), classes="others")
            yield Field(self._lines[-1], placeholder=self._placeholder)
            yield Label("", classes="complaint", markup=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Check the line as it is typed."""
        self.follow(event.value)

    def follow(self, text: str) -> None:
        """Show what a line means, or what is wrong with it."""
        self.tell(*self.checked(text))

    def checked(self, text: str) -> tuple[str, bool]:
        """Return what a line means or what is wrong with it, and whether it is wrong."""
        try:
            return (self._check_line(text) if text.strip() else ""), False
        except (InputError, StoreError) as error:
            return str(error), True

    def tell(self, text: str, wrong: bool = False) -> None:
        """Show a message about the line, marked as an error if `wrong`."""
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
        """Move up or down in the list of lines; the last one is the line that the dialog opened with."""
        self._take_up(max(0, min(self._place - steps, len(self._lines) - 1)))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Put the line that was clicked into the input."""
        self._take_up(event.option_index)

    def _take_up(self, place: int) -> None:
        self._place, line = place, self.query_one(Input)
        line.value = self._lines[place]
        line.cursor_position = len(line.value)
        line.focus()
        for listed in self.query(OptionList):
            listed.highlighted = place if place < listed.option_count else None


def half_length(text: str) -> float:
    """Parse a half length, or raise an error that says how to write one."""
    try:
        value = real(text.strip())
    except ValueError:
        raise InputError(f"a = {text!r}: write a number such as 1.6") from None
    return Stadium(value).a


def code_told(code: str) -> str:
    """Return the period and the least rotation of a code, as text."""
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {code_text(least_rotation(word))}"
