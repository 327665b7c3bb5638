"""Dialogs that ask for a line of text, or for names from a list."""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.events import Key
from textual.suggester import Suggester
from textual.widgets import Input, Label, OptionList

from orbitdb.cli.output import code_text
from orbitdb.cli.tui.help import purpose
from orbitdb.cli.tui.screens import Dialog, Field, in_shell, key
from orbitdb.cli.tui.stored import SHOWABLE, USUAL
from orbitdb.errors import InputError, StoreError
from orbitdb.symbols.words import least_rotation, parse, primitive_root
from orbitdb.text import printable

Names = tuple[str, ...]


class NameList(OptionList):
    """A list in which j and k move the cursor, as in the table."""

    BINDINGS: ClassVar[list[BindingType]] = purpose(
        "move", key("j,down", "cursor_down", "next line"), key("k,up", "cursor_up", "previous line")
    )


class LineDialog(Dialog[str | None]):
    """Ask for a line of text, check it as it is typed, and offer other lines to choose from.

    `check` returns what a line means, or raises an error that says what is wrong with it.
    """

    AUTO_FOCUS = "Input"
    EMPTY: str | None = None
    """The answer if the line is empty."""
    HINT = "enter accepts, escape cancels"
    HELP = ""
    """What stands below the line of text."""
    SUGGESTER: Suggester | None = None
    SELECTED = True
    """Whether the first letter replaces the line."""
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
        others = self._lines[:-1]
        with Vertical(classes="dialog bottom") as box:
            box.border_title = self._title
            box.border_subtitle = self.HINT + (", ↑ ↓ choose" if others else "")
            if others:
                yield NameList(*map(Text, others), classes="others")
            yield Field(
                self._lines[-1],
                placeholder=self._placeholder,
                suggester=self.SUGGESTER,
                select_on_focus=self.SELECTED,
            )
            yield Label("", classes="complaint", markup=False)
            if self.HELP:
                yield Label(self.HELP, classes="help", markup=False)

    def on_input_changed(self, event: Input.Changed) -> None:
        self.follow(event.value)

    def follow(self, text: str) -> None:
        """Show what a line means, or what is wrong with it."""
        self.tell(*self.checked(text))

    def checked(self, text: str) -> tuple[str, bool]:
        """Return what a line means or what is wrong with it, and whether it is wrong."""
        try:
            return (self._check_line(text) if text.strip() else ""), False
        except (InputError, StoreError) as error:
            return in_shell(str(error)), True

    def tell(self, text: str, wrong: bool = False) -> None:
        self.query_one(Input).set_class(wrong, "-wrong")
        self.query_one(".complaint", Label).set_class(not wrong, "-note").update(text)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        message, wrong = self.checked(event.value)
        if wrong:
            self.tell(message, wrong)
        else:
            self.dismiss(event.value.strip() or self.EMPTY)

    def action_older(self, steps: int) -> None:
        """Move up or down in the list of lines; the last one is the line that the dialog opened with."""
        self._take_up(max(0, min(self._place - steps, len(self._lines) - 1)))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        self._take_up(event.option_index)

    def _take_up(self, place: int) -> None:
        self._place, line = place, self.query_one(Input)
        line.value = self._lines[place]
        line.cursor_position = len(line.value)
        line.focus()
        for listed in self.query(OptionList):
            listed.highlighted = place if place < listed.option_count else None


class ColumnSuggester(Suggester):
    """Completes the name of a column at the end of a filter, with the first column that begins so."""

    def __init__(self) -> None:
        super().__init__(use_cache=False, case_sensitive=True)

    async def get_suggestion(self, value: str) -> str | None:
        """Return the completed line; None if it ends within quotes, or with no beginning of a name."""
        word = re.search(r"(?<![:\w])[a-z]\w*$", value)
        if word is None or value.count("'") % 2 or word[0] in SHOWABLE:
            return None
        return next((value[: word.start()] + name for name in SHOWABLE if name.startswith(word[0])), None)


class FilterDialog(LineDialog):
    """Ask for a filter, pass every valid line on as it is typed, and show what the rows report about it.

    `tried` is the last line that was passed on.
    """

    EMPTY = ""
    HINT = "→ completes, enter accepts, escape cancels"
    HELP = "contains(code, '0202') finds 0202 in any rotation; not contains(..) leaves it out"
    SUGGESTER = ColumnSuggester()
    SELECTED = False

    def __init__(
        self, where: str, check: Callable[[str], str], filters: Sequence[str], follow: Callable[[str], object]
    ) -> None:
        placeholder = "lambda_c < 0.5 and time_reversal = 'self'"
        super().__init__("filter, as in --where", where, placeholder, check, filters)
        self.tried, self._pass_on, self._report = where, follow, ""

    def follow(self, text: str) -> None:
        """Pass a valid line on; until the line is valid, the rows of the last one stay."""
        if not self.is_current:  # a letter typed before escape; the earlier rows are back
            return
        message, wrong = self.checked(text)
        if not wrong:
            self.tried = text.strip()
            self._pass_on(self.tried)
        self.tell(message if wrong else self._report)  # quietly, because the line may be unfinished

    def say(self, report: str) -> None:
        """Show what the rows report, unless the line is not valid."""
        self._report = report
        if self.is_mounted and not self.checked(self.query_one(Input).value)[1]:
            self.tell(report)

    def on_mount(self) -> None:
        self.say(self._report)


def describe_code(code: str) -> str:
    """Return the period and the least rotation of a code, as text."""
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {code_text(least_rotation(word))}"


class ListDialog(Dialog[Any]):
    """Choose a name from a list, in which each is shown as its text; the cursor starts at `current`."""

    def __init__(self, title: str, hint: str, texts: Mapping[str, str], current: str | None = None) -> None:
        super().__init__()
        self._title, self._hint, self._texts, self._current = title, hint, texts, current
        self._names = list(texts)
        self._typed, self._landed = "", -1  # the letters, and the index they led to

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog bottom" if self._hint else "dialog small") as box:
            box.border_title, box.border_subtitle = self._title, self._hint
            yield NameList(*map(self._text, self._names))

    def on_mount(self) -> None:
        self._list.highlighted = self._names.index(self._current) if self._current in self._names else 0

    def on_key(self, event: Key) -> None:
        """Move the cursor to the first entry that begins with the typed letters; other keys work as usual."""
        letter = event.character if event.is_printable else None
        typed = self._typed if self._list.highlighted == self._landed else ""
        for text in (typed + letter, letter) if letter else ():
            for place, name in enumerate(self._names):
                if self._texts[name].startswith(text):
                    self._typed, self._landed, self._list.highlighted = text, place, place
                    event.stop()
                    event.prevent_default()
                    return

    def _text(self, name: str) -> Text:
        return Text(printable(self._texts[name]))

    @property
    def _list(self) -> OptionList:
        return self.query_one(OptionList)

    @property
    def _place(self) -> int:
        return self._list.highlighted or 0

    def on_option_list_option_selected(self) -> None:
        self.choose()

    def choose(self) -> None:
        self.dismiss(self._names[self._place])


class MarksDialog(ListDialog):
    """Mark any number of names in a list; `marked` are those marked at the start."""

    BINDINGS: ClassVar[list[BindingType]] = [
        key("space", "mark", priority=True),
        key("enter", "take", priority=True),
    ]

    def __init__(self, title: str, hint: str, texts: Mapping[str, str], marked: Collection[str]) -> None:
        super().__init__(title, hint, texts)
        self._marked = set(marked)

    def _text(self, name: str) -> Text:
        return Text(f"[{'x' if name in self._marked else ' '}] {self._texts[name]}")

    def _show(self, *places: int) -> None:
        for place in places:
            self._list.replace_option_prompt_at_index(place, self._text(self._names[place]))

    def action_mark(self) -> None:
        self._marked ^= {self._names[self._place]}
        self._show(self._place)

    choose = action_mark  # by a click

    def action_take(self) -> None:
        self.dismiss(tuple(name for name in self._names if name in self._marked))


class ColumnDialog(MarksDialog):
    """Choose which columns to show, and in which order; the code is always first."""

    BINDINGS: ClassVar[list[BindingType]] = [key("J", "shift(1)"), key("K", "shift(-1)"), key("R", "usual")]

    def __init__(self, shown: Sequence[str]) -> None:
        width = max(map(len, SHOWABLE))
        texts = {name: f"{name:{width}}  {column.brief}" for name, column in SHOWABLE.items()}
        super().__init__("columns", "space marks, J K move, R resets, enter accepts", texts, ())
        self._arrange(shown)

    def _arrange(self, shown: Sequence[str]) -> None:
        first = [name for name in shown if name != "code"]
        self._marked = set(first)
        self._names = first + [name for name in SHOWABLE if name not in (*first, "code")]

    def action_shift(self, step: int) -> None:
        """Move the column under the cursor up or down by a step, and mark it to be shown."""
        place, other = self._place, self._place + step
        if 0 <= other < len(self._names):
            self._names[place], self._names[other] = self._names[other], self._names[place]
            self._marked.add(self._names[other])
            self._show(place, other)
            self._list.highlighted = other

    def action_usual(self) -> None:
        self._arrange(USUAL)
        self._show(*range(len(self._names)))
        self._list.highlighted = 0
