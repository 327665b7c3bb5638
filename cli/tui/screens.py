"""What all screens and dialogs are made of: keys in groups, work in threads, and closing once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, TypeVar

from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingType
from textual.command import CommandPalette
from textual.containers import ScrollableContainer
from textual.dom import DOMNode
from textual.message import Message
from textual.screen import ModalScreen, Screen
from textual.worker import get_current_worker

from orbitdb.errors import InputError, StoreError
from orbitdb.store.asking.confinement import CancelledError

Result = TypeVar("Result")

Keys = Mapping[str, Sequence[Binding]]
"""The keys of a screen or widget under the headings of the help; it says the tooltip, or the description."""

key = partial(Binding, show=False)
"""A key that the footer leaves out."""

ESCAPE = key("escape", "dismiss(None)", "Close")


def bindings(keys: Keys) -> list[BindingType]:
    """Return keys as Textual takes them."""
    return [each for group in keys.values() for each in group]


SCROLLING: Keys = {
    "scrolling": [
        key("j,down", "scroll_down", "down"),
        key("k,up", "scroll_up", "up"),
        key("pagedown", "page_down", "next page"),
        key("pageup", "page_up", "previous page"),
        key("g,home", "scroll_home", "to the top"),
        key("G,end", "scroll_end", "to the end"),
        key("l,right", "scroll_right", "right"),
        key("h,left", "scroll_left", "left"),
    ]
}
RETURN = (
    Binding("escape", "dismiss", "back", tooltip="back to the orbits"),
    key("q", "dismiss", tooltip="back to the orbits"),
)


class ScrollBox(ScrollableContainer):
    """A box in which one moves as in the table."""

    KEYS: ClassVar[Keys] = SCROLLING
    BINDINGS = bindings(SCROLLING)


@dataclass
class Failed(Message):
    """A worker could not do what it should."""

    reason: str


def in_thread(
    node: DOMNode,
    group: str,
    find: Callable[[Callable[[], bool]], Any],
    take: Callable[[Any], object],
    fail: Callable[[str], object] | None = None,
) -> None:
    """Find something out in a thread, and take it when it is there.

    Parameters
    ----------
    node : DOMNode
        Whoever wants it; when it goes, nobody waits any more. It takes what was found as its own message,
        and messages that this gives rise to rise no higher: on the main screen it is the screen.
    group : str
        Whatever else is being found in this group is not waited for any more.
    find : callable
        Is given a function that tells whether nobody waits any more.
    take : callable
        Is given what was found.
    fail : callable, optional
        Is given the message of an error; by default the screen says it (`Failed`).
    """

    def run() -> None:
        worker = get_current_worker()
        then: Callable[[], object]
        try:
            then = partial(take, find(lambda: worker.is_cancelled))
        except CancelledError:
            return
        except (InputError, StoreError) as error:
            told = str(error)
            then = partial(node.post_message, Failed(told)) if fail is None else partial(fail, told)
        if not worker.is_cancelled:
            node.call_later(then)

    node.run_worker(run, group=group, exclusive=True, thread=True)


class OwnScreen(Screen[Result]):
    """A screen that does nothing before it is there, closes once, and says what went wrong."""

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Let a key do nothing that comes before the widgets it is meant for."""
        return self.is_mounted and super().check_action(action, parameters)

    def dismiss(self, result: Result | None = None) -> AwaitComplete:
        """Close, unless another key or click has closed it already, or another screen stands above it."""
        return super().dismiss(result) if self.is_current else AwaitComplete()

    def on_failed(self, message: Failed) -> None:
        """Say it; Textual calls the handlers of the classes below this one first."""
        self.notify(message.reason, severity="error")


class Dialog(ModalScreen[Result], OwnScreen[Result]):
    """A dialog: what is below it is seen, and hears no keys."""


class ActionsDialog(CommandPalette, OwnScreen[None]):
    """All actions by name: Textual's own list of commands."""
