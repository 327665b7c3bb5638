"""The application: it holds the catalogue and the fill, and shows the screens."""

import time
from collections.abc import Iterable
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from textual import work
from textual.app import SystemCommand
from textual.binding import Binding
from textual.events import Key
from textual.reactive import reactive
from textual.screen import Screen
from textual.worker import get_current_worker

from orbitdb.cli.tui.dialogs.fill import FillState, Wish, fill_steps
from orbitdb.cli.tui.ending import OrderlyApp
from orbitdb.cli.tui.keeping import Kept
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.orbit.facts import Certificate
from orbitdb.cli.tui.screens import ActionsDialog, Field, Keys, QuestionDialog, bindings, key
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.single_word import solve_word
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.database import check_file
from orbitdb.store.file.tables import driver
from orbitdb.store.reading.lookup import certificate_of
from orbitdb.store.reading.moment import Reader

_SECONDS_BETWEEN_LOOKS = 2.0
_WIDTHS = [(0, "-thin"), (56, "-slim"), (76, "-narrow"), (140, "-wide")]
_HEIGHTS = [(0, "-low"), (16, "-short"), (36, "-tall")]


class BrowseApp(OrderlyApp):
    """Browse a catalogue, which need not exist, starting with a subset and optionally a word.

    The state file keeps columns, filters and marked words; without one, they last for the session.
    """

    TITLE = "orbitdb"
    CSS_PATH = "style.tcss"
    HORIZONTAL_BREAKPOINTS = _WIDTHS
    VERTICAL_BREAKPOINTS = _HEIGHTS
    KEYS: ClassVar[Keys] = {
        "orbitdb": [
            Binding("question_mark", "keys", "keys", tooltip="these keys"),
            key("ctrl+p", "command_palette", tooltip="all actions, themes"),
            Binding("q", "quit", "quit"),
            key("ctrl+q,ctrl+c", "quit"),
        ]
    }
    BINDINGS = bindings(KEYS)

    fill_state: reactive[FillState | None] = reactive(None, repaint=False)

    def __init__(
        self, path: Path, selection: Selection, code: str | None = None, state: Path | None = None
    ) -> None:
        super().__init__()
        self.path = path
        self.kept = Kept(state, partial(self.notify, severity="error"))
        self.title = printable(f"orbitdb {path.name}")
        self._catalogue = _opened(path)
        self._selection, self._code = selection, code
        self.exports: set[Path] = set()  # files being written
        self._shown_at = 0.0

    def get_default_screen(self) -> Screen[None]:
        """Begin with the main screen."""
        return MainScreen(self._selection, self._code)

    @property
    def _main(self) -> MainScreen:
        main = self.screen_stack[0]
        assert isinstance(main, MainScreen)
        return main

    def on_key(self, event: Key) -> None:
        """Write a letter into the focused line, after the keys pressed before it have taken effect."""
        if event.character is not None and event.is_printable and isinstance(self.focused, Field):
            event.prevent_default()
            self.focused.replace(event.character, *self.focused.selection)

    # the catalogue, for the screens

    @property
    def catalogue(self) -> Reader | None:
        """The stored catalogue; None as long as there is no file."""
        self._catalogue = self._catalogue or _opened(self.path)
        return self._catalogue

    def find(self, word: str, a: float) -> Orbit:
        """Return a stored word, or solve it."""
        stored = None
        if self.catalogue is not None:
            with self.catalogue.moment() as moment:
                stored = moment.find(word, a)
        return solve_word(word, a) if stored is None else stored

    def a_values(self) -> list[float]:
        """Return the values of a in the catalogue."""
        if self.catalogue is None:
            return []
        with self.catalogue.moment() as moment:
            return moment.a_values()

    def certificate(self, orbit: Orbit) -> Certificate:
        """Return the stored proof of an orbit, if there is one."""
        if self.catalogue is None or not orbit.stored or orbit.length is None:
            return None
        with self.catalogue.moment() as moment:
            return certificate_of(driver(moment.connection), orbit.representative, orbit.a)

    # filling

    @property
    def fills(self) -> bool:
        """Whether a fill is running."""
        return self.fill_state is not None and self.fill_state.runs

    def begin_fill(self, wish: Wish) -> None:
        """Begin a fill, unless one runs."""
        if not self.fills:
            self.fill_state = FillState(wish)
            self._main.go_along(wish.a)
            self._fill(self.fill_state)

    @work(thread=True, group="fill")
    def _fill(self, state: FillState) -> None:
        worker, end, message = get_current_worker(), "done", ""
        self.take_in_hand()
        try:
            with closing(fill_steps(self.path, state)) as steps:
                for state in steps:
                    if worker.is_cancelled:
                        end = "stopped"
                        break
                    self.call_later(self._take_step, state)
        except (InputError, StoreError) as error:
            end, message = "failed", str(error)
        self.call_later(self._take_step, replace(state, state=end, message=message))

    def _take_step(self, state: FillState) -> None:
        """Show the stored data, not more often than one can read."""
        stopping = self.fill_state is not None and self.fill_state.state == "stopping" and state.runs
        if not stopping:
            self.fill_state = state
        if self.leaving:
            return
        self._main.say_choices()
        rested = time.monotonic() - self._shown_at > _SECONDS_BETWEEN_LOOKS
        if not state.runs or (rested and not self._main.rows.reads):
            self._shown_at = time.monotonic()
            self._main.refresh_catalogue()
        if not state.runs:
            severity = "error" if state.state == "failed" else "information"
            self.notify(f"fill {state.sentence()}", severity=severity)

    def leave(self) -> None:
        """Stop the fill, if one runs, and leave."""
        self.action_stop_fill()
        super().leave()

    def action_stop_fill(self) -> None:
        """Stop the fill after the current batch."""
        if self.fill_state is not None and self.fills:
            self.fill_state = replace(self.fill_state, state="stopping")
            self.workers.cancel_group(self, "fill")

    # habits

    def notify(self, message: str, **options: Any) -> None:
        """Show a message without markup, because errors and paths can look like it."""
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
        """Leave; ask first if a fill runs or an export is being written."""
        if not (self.fills or self.exports):
            self.exit()
            return
        question = "A fill is running. What is stored is kept, and you can resume it later."
        if not self.fills:
            question = "An export is being written. If you quit now, there will be no file."
        dialog = QuestionDialog(question, "Stop it and quit", "Stay")
        self.push_screen(dialog, lambda sure: self.leave() if sure else None)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Give every action of the screen, and the other actions of Textual, each once."""
        own: dict[str, SystemCommand] = {}
        for active in screen.active_bindings.values():
            binding = active.binding
            if active.enabled and binding.description and not binding.system:
                title = binding.description[:1].upper() + binding.description[1:]
                run = partial(self.call_later, self.run_action, binding.action, active.node)
                own.setdefault(title, SystemCommand(title, f"key {self.get_key_display(binding)}", run))
        yield from own.values()
        yield from (each for each in super().get_system_commands(screen) if each.title not in own)


def _opened(path: Path) -> Reader | None:
    return None if check_file(path) is None else Reader(path)
