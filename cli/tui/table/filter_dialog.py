"""The filter dialog, which updates the rows as you type."""

from functools import partial

from textual.timer import Timer

from orbitdb.cli.tui.choices import Choices
from orbitdb.cli.tui.dialogs.lines import LineDialog
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.store.asking.where import unfinished

_PAUSE = 0.25
"""Seconds without a key before the rows are read."""


class FilterDialog(LineDialog):
    """Ask for a filter and apply it as it is typed; the main screen shows the resulting rows and reports.

    The cursor stays on its word if that is among the new rows, and at the top if it was there.
    """

    EMPTY = ""

    def __init__(self, rows: RowsPanel, choices: Choices) -> None:
        where = choices.selection.where or ""
        placeholder = "lambda_c < 0.5 and time_reversal = 'self'"
        super().__init__("filter, as in --where", where, placeholder, choices.check_filter, choices.tried)
        self._rows, self._choices, self._before = rows, choices, where
        self._word = rows.table.row[0] if rows.table.row and rows.table.cursor else None
        self._tried, self._note = where.strip(), ""
        self._timer: Timer | None = None

    def on_mount(self) -> None:
        """Show the report of the rows whenever it changes."""
        self.watch(self._rows, "report", self._say)

    def _say(self) -> None:
        self.tell("; ".join(filter(None, (self._rows.report, self._note))))

    def follow(self, text: str) -> None:
        """Apply the line after a moment without keys; until then, the rows of the last valid line stay."""
        if not self.is_current:  # a letter typed before escape; the earlier rows are back
            return
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if text.strip() != self._tried:
            self._rows.stop_reading()
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
        if (where or None) != self._choices.selection.where:
            self._rows.wanted = self._word
            self._choices.selection = self._choices.filtered(where or None)
        elif self._rows.asked is None:  # reading was stopped
            self._rows.read(self._choices.selection)

    def take(self, where: str | None) -> None:
        """Show the rows of the accepted line, or those from before if the dialog was cancelled."""
        self._try(self._before if where is None else where)
        if where:
            self._choices.tried.append(where)
