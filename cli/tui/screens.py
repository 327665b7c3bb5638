"""What all screens and dialogs are made of: keys may come faster than a screen comes and goes."""

from dataclasses import dataclass
from typing import TypeVar

from textual.await_complete import AwaitComplete
from textual.command import CommandPalette
from textual.message import Message
from textual.screen import ModalScreen, Screen

Result = TypeVar("Result")


@dataclass
class Failed(Message):
    """A worker could not do what it should."""

    reason: str


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
