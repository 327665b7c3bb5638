"""The filter line: the rows behind it, and their count, follow as it is typed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from textual.timer import Timer

from orbitdb.cli.tui.dialogs.basic import LineDialog
from orbitdb.store.asking.expressions import unfinished

if TYPE_CHECKING:
    from orbitdb.cli.tui.panels import Panels

_PAUSE = 0.25
"""Seconds without a key before rows are read."""


class FilterDialog(LineDialog):
    """Ask for a filter, and try it as it is typed.

    Parameters
    ----------
    main : Panels
        It shows the rows of a filter, and reports how many they are or what went wrong with them.
    where : str
        The filter that holds now.
    others : sequence of str
        Filters that were typed before.

    Attributes
    ----------
    word : str or None
        What the cursor was on, and goes to where it is among the rows; at the top it stays there.
    """

    def __init__(self, main: "Panels", where: str, others: Sequence[str]) -> None:
        placeholder = "lambda_c < 0.5 and time_reversal = 'self'"
        super().__init__("filter, as in --where", where, placeholder, main.check_filter, others)
        row = main.rows.table.row if main.rows.table.cursor else None
        self._main, self.word = main, row[0] if row else None
        self._tried = where.strip()
        self._report = self._note = ""
        self._timer: Timer | None = None

    def on_mount(self) -> None:
        """Follow the rows that are shown."""
        self.watch(self._main.rows, "report", self._hear)

    def _hear(self, report: str) -> None:
        self._report = report
        self._say()

    def _say(self) -> None:
        self.tell("; ".join(filter(None, (self._report, self._note))))

    def follow(self, text: str) -> None:
        """Try the line when no key has come for a moment; till then the rows are the last good ones."""
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
            self._timer = self.set_timer(_PAUSE, lambda: self._try(text.strip()))

    def _try(self, where: str) -> None:
        self._timer, self._tried = None, where
        self._main.try_filter(where, self.word)
