"""The application, which holds the catalogue and any running fill, and shows the screens."""

import time
from collections.abc import Iterable
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from textual import work
from textual.app import SystemCommand
from textual.events import Key
from textual.reactive import reactive
from textual.screen import Screen
from textual.worker import get_current_worker

from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.dialogs.fill import FillDialog, FillState, fill_steps
from orbitdb.cli.tui.ending import OrderlyApp
from orbitdb.cli.tui.export import Export
from orbitdb.cli.tui.kept import Kept
from orbitdb.cli.tui.keys import ORBITDB, Keys, bindings
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.screens import ActionsDialog, Field, QuestionDialog, Working
from orbitdb.errors import InputError, StoreError
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection

_SECONDS_BETWEEN_LOOKS = 2.0
_WIDTHS = [(0, "-thin"), (56, "-slim"), (76, "-narrow"), (140, "-wide")]
_HEIGHTS = [(0, "-low"), (16, "-short"), (36, "-tall")]


class BrowseApp(OrderlyApp, Working):
    """The application that browses a catalogue, starting with a subset and optionally a word.

    The catalogue need not exist yet. Columns, filters and marked words are saved in the state file; without
    such a file, they last for the session.
    """

    TITLE = "orbitdb"
    CSS_PATH = "style.tcss"
    HORIZONTAL_BREAKPOINTS = _WIDTHS
    VERTICAL_BREAKPOINTS = _HEIGHTS
    KEYS: ClassVar[Keys] = ORBITDB
    BINDINGS = bindings(ORBITDB)

    fill_state: reactive[FillState | None] = reactive(None, repaint=False)

    def __init__(
        self, path: Path, selection: Selection, code: str | None = None, state: Path | None = None
    ) -> None:
        super().__init__()
        self.file = CatalogueFile(path)
        self.kept = Kept(state, partial(self.notify, severity="error"))
        self.title = printable(f"orbitdb {path.name}")
        self._selection, self._code = selection, code
        self.exports: set[Path] = set()  # files that are being written
        self._shown_at = 0.0

    def get_default_screen(self) -> Screen[None]:
        """Return the main screen, with which the application starts."""
        return MainScreen(self.file, self.kept, self._selection, self._code)

    @property
    def _main(self) -> MainScreen:
        main = self.screen_stack[0]
        assert isinstance(main, MainScreen)
        return main

    def on_key(self, event: Key) -> None:
        """Insert a printable character into the focused field, after all earlier keys have taken effect."""
        if event.character is not None and event.is_printable and isinstance(self.focused, Field):
            event.prevent_default()
            self.focused.replace(event.character, *self.focused.selection)

    # filling and writing

    @property
    def fills(self) -> bool:
        """Whether a fill is running."""
        return self.fill_state is not None and self.fill_state.runs

    def on_fill_dialog_begin(self, message: FillDialog.Begin) -> None:
        """Begin a fill, unless one is already running."""
        if not self.fills:
            self.fill_state = FillState(message.wish)
            self._main.go_along(message.wish.a)
            self._fill(self.fill_state)

    @work(thread=True, group="fill")
    def _fill(self, state: FillState) -> None:
        worker, end, message = get_current_worker(), "done", ""
        self.take_in_hand()
        try:
            with closing(fill_steps(self.file.path, state)) as steps:
                for state in steps:
                    if worker.is_cancelled:
                        end = "stopped"
                        break
                    self.call_later(self._take_step, state)
        except (InputError, StoreError) as error:
            end, message = "failed", str(error)
        self.call_later(self._take_step, replace(state, state=end, message=message))

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

    def leave(self) -> None:
        """Stop any running fill, and close the screen."""
        self.on_fill_dialog_stop()
        super().leave()

    def on_fill_dialog_stop(self) -> None:
        """Stop the fill after the current batch."""
        if self.fill_state is not None and self.fills:
            self.fill_state = replace(self.fill_state, state="stopping")
            self.workers.cancel_group(self, "fill")

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
                self.take_in_hand()
                return message.write(lambda: self.leaving)
            finally:
                self.exports.discard(path)

        self.in_thread(f"export {path}", write, self.notify)

    # messages, keys and quitting

    def notify(self, message: str, **options: Any) -> None:
        """Show a message as plain text, because errors and paths can contain what looks like markup."""
        super().notify(printable(message), **options | {"markup": False})

    def action_keys(self) -> None:
        """Show the keys of the current screen."""
        from orbitdb.cli.tui.dialogs.keys import KeysDialog

        if not isinstance(self.screen, KeysDialog):
            nodes = (self.screen.focused, self.screen, self)
            self.push_screen(KeysDialog(nodes, columns=isinstance(self.screen, MainScreen)))

    def action_command_palette(self) -> None:
        """Show all actions by name."""
        if not isinstance(self.screen, ActionsDialog):
            self.push_screen(ActionsDialog(id="--command-palette"))

    async def action_quit(self) -> None:
        """Quit, after all earlier keys have taken effect."""
        self._main.call_later(self.call_later, self._quit)

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

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Yield every action of the screen once, then those commands of Textual that have other titles."""
        own: dict[str, SystemCommand] = {}
        for active in screen.active_bindings.values():
            binding = active.binding
            if active.enabled and binding.description and not binding.system:
                title = binding.description[:1].upper() + binding.description[1:]
                run = partial(self.call_later, self.run_action, binding.action, active.node)
                own.setdefault(title, SystemCommand(title, f"key {self.get_key_display(binding)}", run))
        yield from own.values()
        yield from (each for each in super().get_system_commands(screen) if each.title not in own)
