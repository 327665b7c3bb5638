"""Dialogs: a choice from a list, a line of text, keys, and the question before quitting."""

from collections.abc import Callable, Sequence
from typing import ClassVar

from rich.table import Table
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Button, Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from orbitdb.cli.tui.screens import Dialog
from orbitdb.errors import InputError, StoreError

Group = tuple[str, Sequence[tuple[str, str]]]
"""A heading, and what stands below it: names and what they mean."""

_ESCAPE = Binding("escape", "dismiss(None)", "Close", show=False)


class ChoiceDialog(Dialog[str | None]):
    """Choose one of some names."""

    BINDINGS: ClassVar[list[BindingType]] = [
        _ESCAPE,
        Binding("j", "cursor('down')", show=False),
        Binding("k", "cursor('up')", show=False),
    ]

    def __init__(self, title: str, choices: Sequence[tuple[str, str]], current: str) -> None:
        super().__init__()
        self._title, self._choices, self._current = title, choices, current

    def compose(self) -> ComposeResult:
        """Show the choices."""
        with Vertical(classes="dialog small") as box:
            box.border_title = self._title
            yield OptionList(*(Option(text, id=name) for name, text in self._choices))

    def on_mount(self) -> None:
        """Begin at what holds now."""
        names = [name for name, _ in self._choices]
        options = self.query_one(OptionList)
        options.highlighted = names.index(self._current) if self._current in names else 0

    def action_cursor(self, direction: str) -> None:
        """Move as in the table."""
        getattr(self.query_one(OptionList), f"action_cursor_{direction}")()

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Take the choice."""
        self.dismiss(event.option.id)


class LineDialog(Dialog[str | None]):
    """Ask for a line, check it as it is typed, keep what was typed before at hand."""

    BINDINGS: ClassVar[list[BindingType]] = [
        _ESCAPE,
        Binding("up", "older(1)", show=False),
        Binding("down", "older(-1)", show=False),
    ]

    def __init__(
        self,
        title: str,
        value: str = "",
        placeholder: str = "",
        check: Callable[[str], str] = lambda _: "",
        history: Sequence[str] = (),
    ) -> None:
        super().__init__()
        self._title, self._placeholder = title, placeholder
        self._check_line = check
        self._lines = [value, *(line for line in reversed(history) if line != value)]
        self._place = 0

    def compose(self) -> ComposeResult:
        """Show the line and what is wrong with it."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title = self._title
            box.border_subtitle = "enter takes it, escape leaves, ↑ what was typed before"
            yield Input(self._lines[0], placeholder=self._placeholder)
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
        """Go back and forth in what was typed before."""
        self._place = max(0, min(self._place + steps, len(self._lines) - 1))
        line = self.query_one(Input)
        line.value = self._lines[self._place]
        line.cursor_position = len(line.value)


class KeysDialog(Dialog[None]):
    """The keys that matter, and below them what the columns are."""

    BINDINGS: ClassVar[list[BindingType]] = [_ESCAPE, Binding("question_mark,q", "dismiss(None)", show=False)]

    def __init__(self, groups: Sequence[Group], below: Group | None = None) -> None:
        super().__init__()
        self._groups, self._below = groups, below

    def compose(self) -> ComposeResult:
        """Show the keys, group by group, in two columns where there is room."""
        with VerticalScroll(classes="dialog large") as box:
            box.border_title = "keys"
            box.border_subtitle = "escape closes"
            yield Static(self._table())
            if self._below is not None:
                title, names = self._below
                yield Static(f"[bold]{title}[/bold]")
                yield Static(self._rows(names))

    def _table(self) -> Table:
        table = Table.grid(padding=(0, 2, 0, 0), expand=True)
        table.add_column()
        table.add_column()
        half = (len(self._groups) + 1) // 2
        table.add_row(self._column(self._groups[:half]), self._column(self._groups[half:]))
        return table

    @staticmethod
    def _column(groups: Sequence[Group]) -> Table:
        table = Table.grid(padding=(0, 2, 0, 0))
        for title, keys in groups:
            table.add_row(f"[bold]{title}[/bold]", "")
            for key, meaning in keys:
                table.add_row(key, meaning)
            table.add_row("", "")
        return table

    @staticmethod
    def _rows(names: Sequence[tuple[str, str]]) -> Table:
        table = Table.grid(padding=(0, 2, 0, 0))
        for name, meaning in names:
            table.add_row(name, meaning)
        return table


class QuestionDialog(Dialog[bool]):
    """Ask whether to do something that cannot be taken back."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "dismiss(True)", show=False),
        Binding("n,escape", "dismiss(False)", show=False),
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
