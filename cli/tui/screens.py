"""Base classes of screens and dialogs, which run work in threads and close only once; keys they share."""

from collections.abc import Callable, Generator
from contextlib import suppress
from functools import partial
from typing import Any, ClassVar, TypeVar

from textual._styles_cache import StylesCache
from textual.app import ComposeResult
from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingType
from textual.command import CommandPalette
from textual.containers import Horizontal, ScrollableContainer, Vertical
from textual.content import Content
from textual.dom import DOMNode
from textual.events import Key
from textual.screen import ModalScreen, Screen
from textual.widget import Widget
from textual.widgets import Button, Input, Label
from textual.worker import Worker, get_current_worker

from orbitdb.cli.advice import completed
from orbitdb.cli.tui.help import purpose
from orbitdb.errors import InputError, StoreError
from orbitdb.store.where import CancelledError

Result = TypeVar("Result")
Answer = TypeVar("Answer")

key = partial(Binding, show=False)
"""Make a binding that the last line does not show; the page of keys shows its description."""

SCROLLING: list[BindingType] = purpose(
    "move",
    key("j,down", "scroll_by(0, 1)", "down"),
    key("k,up", "scroll_by(0, -1)", "up"),
    key("pagedown", "scroll_by(0, 1, True)", "next page"),
    key("pageup", "scroll_by(0, -1, True)", "previous page"),
    key("g,home", "scroll_home", "to the top"),
    key("G,end", "scroll_end", "to the end"),
    key("l,right", "scroll_by(1, 0)", "right"),
    key("h,left", "scroll_by(-1, 0)", "left"),
)

LEAVING: list[BindingType] = purpose(
    "other",
    Binding("escape", "dismiss", "back", tooltip="return to the orbits"),
    key("q", "dismiss", "return to the orbits"),
)


def in_shell(text: str) -> str:
    """Turn the calls in a note into commands, and say that these are for the shell."""
    return completed(text, "in a shell, ")


class Working(DOMNode):
    """Base class for screens, widgets and the application, which run work in threads and open dialogs.

    List it last among the base classes, because Textual takes styles from the first one.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._latest: dict[str, Worker[None]] = {}

    def in_thread(
        self,
        group: str,
        find: Callable[[Callable[[], bool]], Any],
        take: Callable[[Any], object],
        fail: Callable[[str], object] | None = None,
    ) -> None:
        """Run `find` in a thread, and pass its result to `take` unless newer work in this group has begun.

        Earlier work in this group is cancelled. `find` gets a function that tells whether it has been
        cancelled; it returns one result or yields several. `fail`, which is `failed` by default, gets the
        message of an error.
        """

        def run() -> None:
            worker = get_current_worker()  # the thread may run before `run_worker` returns
            hand_over = partial(self._hand_over, group, worker)
            try:
                outcome = find(lambda: worker.is_cancelled)
                for part in outcome if isinstance(outcome, Generator) else (outcome,):
                    self.call_later(hand_over, partial(take, part))
                    if worker.is_cancelled:
                        return
            except CancelledError:
                return
            except (InputError, StoreError, ModuleNotFoundError) as error:
                self.call_later(hand_over, partial(fail or self.failed, in_shell(str(error))))

        self._latest[group] = self.run_worker(run, group=group, exclusive=True, thread=True)

    def _hand_over(self, group: str, worker: Worker[None], to: Callable[[], object]) -> None:
        if self._latest.get(group) is worker:
            to()

    def give_up(self, group: str) -> None:
        if (worker := self._latest.pop(group, None)) is not None:
            worker.cancel()

    def failed(self, reason: str) -> None:
        self.app.notify(reason, severity="error")

    def ask(self, dialog: Screen[Answer | None], take: Callable[[Answer], object]) -> None:
        """Open a dialog or another screen, and pass its answer to `take` unless it is cancelled."""

        def hear(answer: Answer | None) -> None:
            if answer is not None:
                take(answer)

        self.app.push_screen(dialog, hear)


class Scrolling(Widget):
    """Base class of what scrolls by the keys `SCROLLING`; list it last."""

    def action_scroll_by(self, columns: int, lines: int, pages: bool = False) -> None:
        """Scroll at once: Textual's own actions lose keys that arrive before the screen is drawn again."""
        height = self.container_size.height if pages else 1
        self.scroll_relative(columns, lines * height, animate=False, immediate=True)


class ScrollBox(ScrollableContainer, Scrolling):
    """A scrolling box with the movement keys of the table."""

    BINDINGS = SCROLLING


class Field(Input):
    """A text field that receives letters in order with all other keys (`BrowseApp.on_key`)."""

    def on_key(self, event: Key) -> None:
        """Leave printable characters to the application, which inserts them."""
        if event.is_printable:
            event.prevent_default()


class TopLine(Horizontal):
    """The first line of a screen: the program and the file on the left, the subtitle on the right."""

    def compose(self) -> ComposeResult:
        program, _, file = str(self.app.title).partition(" ")
        yield Label(Content.assemble((program, "bold $foreground"), Content(f"  {file}")), id="program")
        yield Label(id="subtitle", markup=False)

    def on_mount(self) -> None:
        self.watch(
            self.screen, "sub_title", lambda text: self.query_one("#subtitle", Label).update(text or "")
        )


class OwnScreen(Screen[Result], Working):
    """A screen that ignores keys until it is mounted, closes only once, and reports errors."""

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Ignore keys that arrive before the widgets exist."""
        return self.is_mounted and super().check_action(action, parameters)

    def on_unmount(self) -> None:
        """Forget the lines of the screen; Textual would keep up to a megabyte of them."""
        StylesCache.get_inner_outer.cache_clear()

    async def action_to(self, part: str, action: str) -> None:
        await self.app.run_action(action, self.query_one(f"#{part}"))

    def dismiss(self, result: Result | None = None) -> AwaitComplete:
        """Close the screen, unless it is already closed or another screen is on top of it."""
        return super().dismiss(result) if self.is_current else AwaitComplete()


class Dialog(ModalScreen[Result], OwnScreen[Result]):
    """A dialog. The screen below it stays visible but receives no keys."""

    BINDINGS: ClassVar[list[BindingType]] = [key("escape", "dismiss(None)", "Close")]


class QuestionDialog(Dialog[bool | None]):
    """Ask a yes-or-no question before a step such as a long fill, or quitting during one."""

    BINDINGS: ClassVar[list[BindingType]] = [key("y", "dismiss(True)"), key("n,escape", "dismiss(False)")]

    def __init__(self, question: str, yes: str, no: str) -> None:
        super().__init__()
        self._question, self._yes, self._no = question, yes, no

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog"):
            yield Label(self._question, markup=False)
            with Horizontal(classes="buttons"):
                yield Button(f"{self._no} (n)", id="no", compact=True)
                yield Button(f"{self._yes} (y)", id="yes", compact=True)

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.dismiss(event.button.id == "yes")


class ActionsDialog(CommandPalette, OwnScreen[None]):
    """A list of all actions by name: Textual's command palette, kept from closing twice."""

    def _action_command_list(self, action: str) -> None:
        """Move in the list; do nothing before it is laid out, when Textual raises `KeyError`."""
        with suppress(KeyError):
            super()._action_command_list(action)
