"""The dialog that chooses a stadium: one of the catalogue from a list, or any by its number."""

from collections.abc import Sequence

from textual import events
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Input, Label, OptionList
from textual.widgets.option_list import Option

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.tui.dialogs.basic import ChoiceDialog
from orbitdb.errors import InputError
from orbitdb.numerals import real

_NUMBER = frozenset("0123456789.")


class HalfLengthDialog(ChoiceDialog):
    """Choose a half length; a number that is typed takes the place of the list.

    Parameters
    ----------
    values : sequence of float
        Those of the catalogue.
    current : float
        The one that is shown.
    """

    def __init__(self, values: Sequence[float], current: float) -> None:
        super().__init__("half length a", [(repr(a), f"a = {a:g}") for a in values], repr(current))

    def compose(self) -> ComposeResult:
        """Show the values, a line for any other, and what to do there."""
        with Vertical(classes="dialog small") as box:
            box.border_title = self._title
            yield OptionList(*(Option(text, id=name) for name, text in self._choices))
            yield Input(placeholder="or type any other", select_on_focus=False)
            yield Label("", classes="complaint -note", markup=False)

    def on_mount(self) -> None:
        """Begin at what holds now, or at the line if there is nothing to choose from."""
        super().on_mount()
        if not self._choices:
            self.query_one(Input).focus()

    def on_key(self, event: events.Key) -> None:
        """Take a digit for the line, wherever the cursor is."""
        line = self.query_one(Input)
        if event.character in _NUMBER and not line.has_focus:
            line.focus()
            line.insert_text_at_cursor(event.character or "")
            event.stop()

    def on_input_changed(self, event: Input.Changed) -> None:
        """Say at once what is wrong with a number, or what there is at that a."""
        a, told = _read(event.value)
        if a is not None:
            filled = repr(a) in dict(self._choices)
            told = "filled" if filled else "nothing is filled there: f fills it, c solves a code"
        self.query_one(Input).set_class(a is None and bool(told), "-wrong")
        self.query_one(Label).update(told)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take the number if it is one."""
        a, _ = _read(event.value)
        if a is not None:
            self.dismiss(repr(a))


def _read(text: str) -> tuple[float | None, str]:
    """Return the half length that is written, or None and what is wrong with it."""
    if not text.strip():
        return None, ""
    try:
        return Stadium(real(text.strip())).a, ""
    except InputError as error:
        return None, str(error)
    except ValueError:
        return None, f"{text!r} is no number: write one such as 2.5"
