"""The filter line: the rows behind it, and their count, follow as it is typed."""

from collections.abc import Callable, Sequence

from textual.dom import DOMNode
from textual.timer import Timer

from orbitdb.cli.tui.dialogs.basic import LineDialog
from orbitdb.store.asking.expressions import unfinished

_PAUSE = 0.25
"""Seconds without a key before rows are read."""


class FilterDialog(LineDialog):
    """Ask for a filter, and try it as it is typed.

    Parameters
    ----------
    where : str
        The filter that holds now.
    check : callable
        Refuses what cannot be used.
    stop : callable
        Reads no further for the filter before, at every key.
    attempt : callable
        Shows the rows of a filter; it is never given one that is refused.
    screen : DOMNode
        Its reactive ``report`` says how many rows are shown, or what went wrong with them.
    history : sequence of str
        What was typed before.
    """

    def __init__(
        self,
        where: str,
        check: Callable[[str], str],
        stop: Callable[[], None],
        attempt: Callable[[str], None],
        screen: DOMNode,
        history: Sequence[str],
    ) -> None:
        placeholder = "lambda_c < 0.5 and time_reversal = 'self'"
        super().__init__("filter, as in --where", where, placeholder, check, history)
        self._stop, self._attempt, self._rows = stop, attempt, screen
        self._tried = where.strip()
        self._report = self._note = ""
        self._timer: Timer | None = None

    def on_mount(self) -> None:
        """Follow the rows that are shown."""
        self.watch(self._rows, "report", self._hear)

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
            self._stop()
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
        self._attempt(where)
