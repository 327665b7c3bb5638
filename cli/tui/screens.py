"""What all screens and dialogs are made of: keys may come faster than a screen comes and goes."""

from typing import TypeVar

from textual.await_complete import AwaitComplete
from textual.command import CommandPalette
from textual.screen import ModalScreen, Screen

Result = TypeVar("Result")


class OwnScreen(Screen[Result]):
    """A screen that does nothing before it is there, and closes once."""

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Let a key do nothing that comes before the widgets it is meant for."""
        return self.is_mounted and super().check_action(action, parameters)

    def dismiss(self, result: Result | None = None) -> AwaitComplete:
        """Close, unless another key or click has closed it already, or another screen stands above it."""
        return super().dismiss(result) if self.is_current else AwaitComplete()


class Dialog(ModalScreen[Result], OwnScreen[Result]):
    """A dialog: what is below it is seen, and hears no keys."""


class ActionsDialog(CommandPalette, OwnScreen[None]):
    """All actions by name: Textual's own list of commands."""
