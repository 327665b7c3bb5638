"""The application, which holds the catalogue and any running fill, shows the screens, and ends in order."""

import asyncio
import gc
import os
import signal
import threading
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from importlib import resources
from pathlib import Path
from types import FrameType
from typing import Any, ClassVar

from textual.app import App, SystemCommand
from textual.binding import Binding, BindingType
from textual.events import Key
from textual.reactive import reactive
from textual.screen import Screen
from textual.worker import WorkerFailed

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.colours import readable_variables
from orbitdb.cli.tui.export import Export
from orbitdb.cli.tui.fill_dialog import FillDialog, FillState, fill_request
from orbitdb.cli.tui.help import explained, keys_by_purpose, keys_of, purpose
from orbitdb.cli.tui.keys_screen import KeysScreen
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.screens import ActionsDialog, Field, QuestionDialog, Working, in_shell, key
from orbitdb.cli.tui.stored import Kept
from orbitdb.errors import StoreError
from orbitdb.selection import Selection
from orbitdb.store.where import CancelledError
from orbitdb.text import printable

_SECONDS_BETWEEN_LOOKS = 2.0
_WIDTHS = [(0, "-thin"), (70, "-narrow"), (110, "-broad"), (140, "-wide")]
_HEIGHTS = [(0, "-low"), (16, "-shallow"), (20, "-short"), (36, "-tall")]
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_PATIENCE = 1.8
"""Seconds from a signal until the process ends even if the screen has not closed."""
_MOST_AT_ONCE = 64
"""Maximum number of threads, which is more than held-down keys can occupy."""


class LooseThreads(ThreadPoolExecutor):
    """A thread pool that the screen does not wait for when it closes; most of the threads only read."""

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        super().shutdown(wait=False, cancel_futures=True)


class BrowseApp(App[None], Working):
    """The application that browses a catalogue, starting with a subset and optionally a word.

    The catalogue need not exist yet. Columns, filters and marked words are saved in the state file; without
    such a file, they last for the session. After `run`, call `end`.
    """

    TITLE = "orbitdb"
    CSS = resources.files(__package__).joinpath("style.tcss").read_text(encoding="utf-8")
    HORIZONTAL_BREAKPOINTS = _WIDTHS
    VERTICAL_BREAKPOINTS = _HEIGHTS
    BINDINGS: ClassVar[list[BindingType]] = purpose(
        "other",
        Binding("question_mark", "keys", "keys", tooltip="show all keys and what they do"),
        key("ctrl+p", "command_palette", "actions", tooltip="list all actions by name, and the themes"),
        Binding("q", "quit", "quit", tooltip="quit"),
        key("ctrl+q,ctrl+c", "quit", "quit", system=True),
    )

    fill_state: reactive[FillState | None] = reactive(None, repaint=False, init=False)

    def __init__(
        self, path: Path, selection: Selection, code: str | None = None, state: Path | None = None
    ) -> None:
        super().__init__()
        self.catalogue = Catalogue(path, missing_ok=True)
        self.kept = Kept(state, partial(self.notify, severity="error"))
        if self.kept.load() and self.kept.state.theme in self.available_themes:
            self.theme = self.kept.state.theme
        self.title = printable(f"orbitdb {path.name}")
        self._selection, self._code = selection, code
        self.exports: set[Path] = set()  # files that are being written
        self._shown_at = 0.0
        self.leaving = False
        self._writing: list[threading.Thread] = []
        self._failure: BaseException | None = None
        self._signal: int | None = None
        self._handlers: dict[int, Any] = {}

    def get_default_screen(self) -> Screen[None]:
        return MainScreen(self.catalogue, self.kept, self._selection, self._code)

    @property
    def _main(self) -> MainScreen:
        main = self.screen_stack[0]
        assert isinstance(main, MainScreen)
        return main

    def on_load(self) -> None:
        """Run work in threads that do not delay the end of the process."""
        asyncio.get_running_loop().set_default_executor(LooseThreads(_MOST_AT_ONCE))

    def on_mount(self) -> None:
        """Handle signals, so that the terminal is restored before one of them ends the program."""
        gc.freeze()  # otherwise garbage collection of everything loaded so far would delay keys
        if threading.current_thread() is threading.main_thread():
            loop = asyncio.get_running_loop()
            for number in _SIGNALS:
                if signal.getsignal(number) != signal.SIG_IGN:
                    self._handlers[number] = signal.signal(number, partial(self._take_signal, loop))

    def on_key(self, event: Key) -> None:
        """Insert a printable character into the focused field, after all earlier keys have taken effect.

        Some terminals join escape and the key that follows it to a key with Alt, which means nothing here. In
        a dialog with a field, only escape counts: what was typed into the field must not become a command.
        """
        field = self.focused if isinstance(self.focused, Field) else None
        letter = event.key.removeprefix("alt+")
        if letter != event.key and len(letter) == 1:
            event.prevent_default()
            self.post_message(Key("escape", None))
            if field is None:
                self.post_message(Key(letter, letter))
        elif event.character is not None and event.is_printable and field is not None:
            event.prevent_default()
            field.replace(event.character, *field.selection)

    # filling and writing

    @property
    def fills(self) -> bool:
        return self.fill_state is not None and self.fill_state.runs

    def on_fill_dialog_begin(self, message: FillDialog.Begin) -> None:
        if self.fills:
            return
        state = self.fill_state = FillState(message.request)
        self._main.go_along(state.request.a)

        def tell(done: float, total: float, text: str) -> None:
            nonlocal state
            if self.fill_state is not None and self.fill_state.state == "stopping":
                raise CancelledError
            state.work.report(done, total, text.removeprefix("words, "), time.monotonic())
            stored = state.stored
            if stored is None:  # the first report of a fill of periods counts what was stored before it
                stored = int(done) if state.request.periods else 0
            state = replace(state, done=int(done) - stored, stored=stored)
            self.call_later(self._take_step, state)

        def fill(_: object) -> str:
            self._writing.append(threading.current_thread())
            try:
                fill_request(self.catalogue.path, state.request, tell)
            except CancelledError:
                return "stopped"
            return "done"

        def end(how: str, message: str = "") -> None:
            self._take_step(replace(state, state=how, message=message))

        self.in_thread("fill", fill, end, partial(end, "failed"))

    def watch_fill_state(self, state: FillState | None) -> None:
        """Show the state of the fill on the main screen, and in the dialog if that is open."""
        self._main.say_choices()
        for screen in self.screen_stack:
            if isinstance(screen, FillDialog) and screen.is_mounted:
                screen.follow(state)

    def _take_step(self, state: FillState) -> None:
        """Show the progress of a fill, and read the stored rows again from time to time."""
        stopping = self.fill_state is not None and self.fill_state.state == "stopping" and state.runs
        if not stopping:
            self.fill_state = state
        if self.leaving:
            return
        rested = time.monotonic() - self._shown_at > _SECONDS_BETWEEN_LOOKS
        if not state.runs or (rested and not self._main.rows.reads):
            self._shown_at = time.monotonic()
            self._main.action_look_again()
        if not state.runs:
            severity = "error" if state.state == "failed" else "information"
            self.notify(f"fill {state.sentence()}", severity=severity)

    def on_fill_dialog_stop(self) -> None:
        if self.fill_state is not None and self.fills:
            self.fill_state = replace(self.fill_state, state="stopping")

    def on_export(self, message: Export) -> None:
        """Write the requested file in a thread, unless that file is already being written."""
        path = message.path
        if path in self.exports:
            self.failed(f"{path} is still being written: wait until it is finished, or name another file")
            return
        self.exports.add(path)
        self.notify(f"writing {path} ...")

        def write(_: object) -> str:
            try:
                self._writing.append(threading.current_thread())
                return message.write(lambda: self.leaving)
            finally:
                self.exports.discard(path)

        self.in_thread(f"export {path}", write, self.notify)

    def watch_theme(self, theme: str) -> None:
        """Keep the theme for the next session."""
        if self.is_running and theme != self.kept.state.theme:
            with self.kept.changing() as state:
                state.theme = theme

    # messages and keys

    def notify(self, message: str, *, title: str = "", **options: Any) -> None:
        """Show a message as plain text, because errors and paths can contain what looks like markup.

        Only Textual's own messages have a title, and markup.
        """
        shown = message if title else printable(in_shell(message))
        super().notify(shown, title=title, **options | {"markup": bool(title)})

    def get_css_variables(self) -> dict[str, str]:
        self.theme_variables = readable_variables(super().get_css_variables())
        return self.theme_variables

    def deliver_screenshot(self, *names: str | None, **options: Any) -> str | None:
        """Save a screenshot to the downloads folder if there is one, otherwise to the current folder."""
        from platformdirs import user_downloads_path

        folder = options.get("path") or (None if user_downloads_path().is_dir() else os.curdir)
        return super().deliver_screenshot(*names[:1], **options | {"path": folder})

    def action_keys(self) -> None:
        """Show the keys that work now."""
        self.push_screen(KeysScreen(keys_of(self, self.screen)))

    def action_command_palette(self) -> None:
        if not isinstance(self.screen, ActionsDialog):
            self.push_screen(ActionsDialog(id="--command-palette"))

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Yield every action of the screen once, then those commands of Textual that have other titles."""
        own: dict[str, SystemCommand] = {}
        actions = (action for _, actions in keys_by_purpose(screen) for action in actions)
        for node, binding, *_ in (action[0] for action in actions):
            if binding.action != "command_palette":  # that shows this list
                title = explained(binding)
                title = title[:1].upper() + title[1:]
                run = partial(self.call_later, self.run_action, binding.action, node)
                own.setdefault(title, SystemCommand(title, f"key {self.get_key_display(binding)}", run))
        yield from own.values()
        titles = ("Quit", "Keys")
        yield from (command for command in super().get_system_commands(screen) if command.title not in titles)

    # the end

    async def action_quit(self) -> None:
        """Quit, after all earlier keys and the answers of closed dialogs have taken effect."""
        self._main.call_later(self._main.call_next, self.call_later, self._quit)

    def _quit(self) -> None:
        """Quit; ask first if a fill is running or an export is being written."""
        if not (self.fills or self.exports):
            self.exit()
            return
        question = "A fill is running. What it has stored is kept, and you can resume it later."
        if not self.fills:
            question = "An export is being written. If you quit now, the unfinished file is discarded."
        dialog = QuestionDialog(question, "Stop it and quit", "Stay")
        self.push_screen(dialog, lambda sure: self.leave() if sure else None)

    def leave(self) -> None:
        self.leaving = True
        self.on_fill_dialog_stop()
        self.exit()

    def _take_signal(self, loop: asyncio.AbstractEventLoop, number: int, frame: FrameType | None) -> None:
        """Leave; if the terminal is gone or stopped, so that the loop is blocked, end the process."""
        self._signal = number
        last = threading.Timer(_PATIENCE, os._exit, [128 + number])
        last.daemon = True
        last.start()
        with suppress(RuntimeError):  # the loop is already closed
            loop.call_soon_threadsafe(self.leave)

    def _handle_exception(self, error: Exception) -> None:
        """Close the screen without a traceback on the terminal; `end` raises the error again."""
        self._failure = self._failure or (error.error if isinstance(error, WorkerFailed) else error)
        if isinstance(error, StoreError):
            self._close_messages_no_wait()
        else:
            super()._handle_exception(error)

    def _fatal_error(self) -> None:
        """Close the screen; Textual would print its own traceback."""
        self._close_messages_no_wait()

    def end(self) -> None:
        """Wait for what is being written; then end as every command does after a failure or signal."""
        for thread in self._writing:
            thread.join()
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if self._signal is not None:
            signal.raise_signal(self._signal)
        if self._failure is not None:
            raise self._failure
