"""Dialogs: a choice from a list, a line of text, and the question before quitting."""

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.widgets import Button, Input, Label, OptionList

from orbitdb.cli.tui.screens import ESCAPE, Dialog, key
from orbitdb.errors import InputError, StoreError
from orbitdb.plaintext import printable


class NameList(OptionList):
    """A list in which one moves as in the table."""

    BINDINGS: ClassVar[list[BindingType]] = [key("j", "cursor_down"), key("k", "cursor_up")]


class ChoiceDialog(Dialog[str | None]):
    """Choose one of some names.

    Parameters
    ----------
    title : str
    choices : mapping of str to str
        What is shown of each name.
    current : str
        The one to begin at.
    notes : mapping of str to str, optional
        What is said of the name under the cursor.
    """

    BINDINGS: ClassVar[list[BindingType]] = [ESCAPE]

    def __init__(
        self, title: str, choices: Mapping[str, str], current: str, notes: Mapping[str, str] | None = None
    ) -> None:
        super().__init__()
        self._title, self._choices, self._current, self._notes = title, choices, current, notes
        self.names = list(choices)

    def compose(self) -> ComposeResult:
        """Show the choices."""
        with Vertical(classes="dialog " + ("small" if self._notes is None else "bottom")) as box:
            box.border_title = self._title
            yield NameList(*(Text(printable(text)) for text in self._choices.values()))
            if self._notes is not None:
                yield Label("", classes="complaint -note", markup=False)

    def on_mount(self) -> None:
        """Begin at what holds now."""
        place = self.names.index(self._current) if self._current in self.names else 0
        self.query_one(OptionList).highlighted = place

    @property
    def under_cursor(self) -> str:
        """The name under the cursor."""
        return self.names[self.query_one(OptionList).highlighted or 0]

    def on_option_list_option_highlighted(self) -> None:
        """Say what there is to say of it."""
        if self._notes is not None:
            self.query_one(Label).update(self._notes[self.under_cursor])

    def on_option_list_option_selected(self) -> None:
        """Take it."""
        self.dismiss(self.under_cursor)


class LineDialog(Dialog[str | None]):
    """Ask for a line, check it as it is typed, and list others that may be taken.

    Parameters
    ----------
    title, value, placeholder : str
    check : callable, optional
        Says what a line means, or raises an error that says what is wrong with it.
    others : sequence of str, optional
        Lines that were typed before, or that are at hand.
    """

    AUTO_FOCUS = "Input"
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
        """Show the lines to choose from, the one that is typed, and what is wrong with it."""
        others = self._lines[:-1]
        with Vertical(classes="dialog bottom") as box:
            box.border_title = self._title
            box.border_subtitle = "enter takes it, escape leaves" + (", ↑ ↓ choose" if others else "")
            if others:
                yield NameList(*map(Text, others), classes="others")
            yield Input(self._lines[-1], placeholder=self._placeholder)
            yield Label("", classes="complaint", markup=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Follow what is typed."""
        self.follow(event.value)

    def follow(self, text: str) -> None:
        """Say at once what is wrong with a line, or what it means."""
        self.tell(*self.checked(text))

    def checked(self, text: str) -> tuple[str, bool]:
        """Return what there is to say about a line, and whether it is wrong."""
        try:
            return (self._check_line(text) if text.strip() else ""), False
        except (InputError, StoreError) as error:
            return str(error), True

    def tell(self, text: str, wrong: bool = False) -> None:
        """Show what there is to say."""
        self.query_one(Input).set_class(wrong, "-wrong")
        self.query_one(Label).set_class(not wrong, "-note").update(text)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take the line if nothing is wrong with it."""
        told, wrong = self.checked(event.value)
        if wrong:
            self.tell(told, wrong)
        else:
            self.dismiss(event.value.strip())

    def action_older(self, steps: int) -> None:
        """Go up and down in the lines, the one that is typed being the last."""
        self._take_up(max(0, min(self._place - steps, len(self._lines) - 1)))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Take up the line under the mouse."""
        self._take_up(event.option_index)

    def _take_up(self, place: int) -> None:
        self._place, line = place, self.query_one(Input)
        line.value = self._lines[place]
        line.cursor_position = len(line.value)
        line.focus()
        for listed in self.query(OptionList):
            listed.highlighted = place if place < listed.option_count else None


class QuestionDialog(Dialog[bool]):
    """Ask whether to do something that cannot be taken back."""

    BINDINGS: ClassVar[list[BindingType]] = [
        key("y", "dismiss(True)"),
        key("n,escape", "dismiss(False)"),
    ]

    def __init__(self, question: str, yes: str, no: str) -> None:
        super().__init__()
        self._question, self._yes, self._no = question, yes, no

    def compose(self) -> ComposeResult:
        """Show the question."""
        with Vertical(classes="dialog"):
            yield Label(self._question, markup=False)
            with Horizontal(classes="buttons"):
                yield Button(f"{self._no} (n)", id="no", variant="primary")
                yield Button(f"{self._yes} (y)", id="yes", variant="error")

    def on_button_pressed(self, event: Button.Pressed) -> None:
        """Take the answer."""
        self.dismiss(event.button.id == "yes")
