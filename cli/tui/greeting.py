"""What the main screen shows before anything is stored."""

from pathlib import Path

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from orbitdb.plaintext import printable

_TEXT = """\
[b]Nothing is stored here yet.[/b]

$path

Press [b]f[/b] to fill it: the periods up to 11 take a few seconds
and hold 89,789 words, the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to leave."""


class Greeting(Vertical):
    """Tells how to begin."""

    def __init__(self, path: Path) -> None:
        super().__init__(id="greeting")
        self._path = path

    def compose(self) -> ComposeResult:
        """Show the text."""
        yield Static(Content.from_markup(_TEXT, path=printable(str(self._path))))
