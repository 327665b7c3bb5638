"""Browser: what the screens ask of the application that shows them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from orbitdb.orbits.orbit import Orbit

if TYPE_CHECKING:
    from orbitdb.cli.tui.dialogs.filling import FillState
    from orbitdb.cli.tui.kept import Kept
    from orbitdb.cli.tui.orbit.facts import Certificate
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.lookup import Lives


class Browser(Protocol):
    """The application: it holds the file, what is known of it, and the fill that runs.

    Attributes
    ----------
    path : Path
        The file.
    catalogue : Catalogue or None
        None where there is no file yet.
    fill_state : FillState or None
        How far the fill is that was begun here.
    kept : Kept
        What was chosen for good: columns, filters, marked words.
    leaving : bool
        Whether the screen is about to go, as a signal or an answer has said.
    """

    path: Path
    catalogue: "Catalogue | None"
    fill_state: "FillState | None"
    kept: "Kept"
    leaving: bool

    def find(self, word: str, a: float) -> Orbit:
        """Return a word's stored orbit, or solve it."""

    def follow(self, orbit: Orbit, steps: Sequence[bool], home: float) -> Orbit:
        """Return what becomes of an orbit some steps up or down in a, with its lives; ``home`` is a stop."""

    def find_at(self, word: str, a: float, lives: "Lives | None") -> Orbit:
        """Return a word's orbit, whose lives are known."""

    def certificate(self, orbit: Orbit) -> "Certificate":
        """Return what is proved of an orbit."""

    def check_filter(self, where: str, parameters: dict[str, str | int | float]) -> None:
        """Refuse what is not one expression over the columns."""

    def writable(self) -> bool:
        """Tell whether the file may be filled."""

    def look_again(self) -> None:
        """Forget what is known of the file: somebody else may have filled it."""

    def take_in_hand(self) -> None:
        """Let the process not end before this thread, which has something to put away."""

    def tell(self, text: str) -> None:
        """Show a line to the user, from whatever thread."""
