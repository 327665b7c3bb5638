"""The application: it holds the catalogue and the fill, and shows the screens."""

import asyncio
import gc
import os
import signal
import threading
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from rich.console import RenderableType
from textual import work
from textual.app import App, SystemCommand
from textual.binding import Binding, BindingType
from textual.notifications import SeverityLevel
from textual.reactive import reactive
from textual.screen import Screen
from textual.worker import get_current_worker

from orbitdb.cli.interrupts import TERMINATING, Terminated
from orbitdb.cli.tui.dialogs.basic import KeysDialog, QuestionDialog
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.filling import FillState, Wish
from orbitdb.cli.tui.dialogs.filling import work as fill_steps
from orbitdb.cli.tui.ending import LooseThreads, listen_to_signals, written_down
from orbitdb.cli.tui.kept import Kept, state_path
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.orbit.facts import Certificate
from orbitdb.cli.tui.screens import ActionsDialog
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.reading.lookup import Lives

_SECONDS_BETWEEN_LOOKS = 2.0
_RESTS = 5
"""Times that the last look took until the next one, at least."""
_SECONDS_TO_PUT_AWAY = 1.0
_WIDTHS = [(0, "-slim"), (76, "-narrow"), (140, "-wide")]
_HEIGHTS = [(0, "-short"), (36, "-tall")]


class BrowseApp(App[None]):
    """Browse a catalogue.

    Parameters
    ----------
    path : Path
        The catalogue; it need not exist.
    selection : Selection
        The subset to begin with.
    code : str, optional
        The word to begin with.
    state : Path, optional
        The file that keeps columns, filters and marked words; by default they last for this session.
    """

    TITLE = "orbitdb"
    CSS_PATH = "style.tcss"
    HORIZONTAL_BREAKPOINTS = _WIDTHS
    VERTICAL_BREAKPOINTS = _HEIGHTS
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark", "keys", "keys", key_display="?"),
        Binding("q", "quit", "quit"),
        Binding("ctrl+q,ctrl+c", "quit", show=False),
    ]

    fill_state: reactive[FillState | None] = reactive(None, repaint=False)

    def __init__(
        self, path: Path, selection: Selection, code: str | None = None, state: Path | None = None
    ) -> None:
        super().__init__()
        self.path, self.kept = path, Kept(state)
        self.title = printable(f"orbitdb {path.name}")
        self.catalogue = _opened(path)
        self._selection, self._code = selection, code
        self._shown_at = 0.0
        self._in_hand: list[threading.Thread] = []
        self.leaving = False
        self.failure: BaseException | None = None

    def on_load(self) -> None:
        """Begin no thread that the end of the process would wait for."""
        asyncio.get_running_loop().set_default_executor(LooseThreads())

    def on_mount(self) -> None:
        """Restore the terminal, too, when a signal says to end."""
        gc.freeze()  # to go through all that stands by now keeps every key waiting for long
        if threading.current_thread() is threading.main_thread():
            listen_to_signals(self._end)

    def _end(self, number: int) -> None:
        if not self.is_web:  # there the server is told, too, and says so
            self.failure = KeyboardInterrupt() if number == signal.SIGINT else Terminated(number)
        self.action_stop_fill()
        self.leaving = True
        self.exit()

    def take_in_hand(self) -> None:
        """Let the process not end before this thread, which has something to put away."""
        self._in_hand.append(threading.current_thread())

    def close(self) -> None:
        """Wait for what is in hand once the screen has gone, for a moment only if a signal said to end.

        Raises
        ------
        BaseException
            Whatever ended the screen before its time.
        """
        told = isinstance(self.failure, Terminated | KeyboardInterrupt)
        for thread in self._in_hand:
            thread.join(_SECONDS_TO_PUT_AWAY if told else None)
        match self.failure:
            case None:
                return
            case StoreError() | Terminated() | KeyboardInterrupt():
                raise self.failure
        raise written_down(self.failure, state_path().parent)

    def get_default_screen(self) -> Screen[None]:
        """Begin with the main screen."""
        return MainScreen(self._selection, self._code)

    @property
    def _main(self) -> MainScreen:
        main = self.screen_stack[0]
        assert isinstance(main, MainScreen)
        return main

    # the catalogue, for the screens

    def look_again(self) -> None:
        """Read the file anew."""
        if self.catalogue is None:
            self.catalogue = _opened(self.path)
        self._main.refresh_catalogue()

    def find(self, word: str, a: float) -> Orbit:
        """Return what is stored of a word, or solve it."""
        from orbitdb.billiard.stadium import Stadium
        from orbitdb.orbits.newton import solve_word

        stored = self.catalogue.find(word, a) if self.catalogue is not None else None
        return solve_word(word, Stadium(a)) if stored is None else stored

    def follow(self, orbit: Orbit, steps: Sequence[bool], home: float) -> Orbit:
        """Return what becomes of an orbit some steps up or down in a, with its lives; ``home`` is a stop."""
        from orbitdb.cli.tui.orbit.lives import next_a
        from orbitdb.store.reading.lookup import with_existence

        if not steps:
            return orbit
        lives, a = with_existence(orbit).exists, orbit.a
        for up in steps:
            a = next_a(lives or (), a, up, home)
        return self.find_at(orbit.code, a, lives)

    def find_at(self, word: str, a: float, lives: "Lives | None") -> Orbit:
        """Return what is stored of a word, or solve it; its lives are known."""
        return replace(self.find(word, a), exists=lives)

    def certificate(self, orbit: Orbit) -> Certificate:
        """Return the stored proof of an orbit, if there is one."""
        if self.catalogue is None or not orbit.stored or orbit.length is None:
            return None
        from orbitdb.store.file.engines import driver
        from orbitdb.store.reading.lookup import certificate_of

        with self.catalogue.reading() as connection:
            return certificate_of(driver(connection), orbit.representative, orbit.a)

    def check_filter(self, where: str, parameters: dict[str, str | int | float]) -> None:
        """Refuse a filter that cannot be used."""
        from orbitdb.store.asking.expressions import check

        check(where, parameters)

    def writable(self) -> bool:
        """Tell whether the file can be written."""
        if self.path.exists():
            return os.access(self.path, os.W_OK) and os.access(self.path.parent, os.W_OK)
        return True

    # filling

    def on_fill_dialog_begun(self, message: FillDialog.Begun) -> None:
        """Begin a fill, unless one runs."""
        if self.fill_state is None or not self.fill_state.runs:
            self.fill_state = FillState(message.wish)
            self._main.go_along(message.wish.a)
            self._fill(message.wish)

    @work(thread=True, group="fill")
    def _fill(self, wish: Wish) -> None:
        worker = get_current_worker()
        self.take_in_hand()
        state = FillState(wish)
        steps = fill_steps(self.path, state)
        try:
            for state in steps:
                if worker.is_cancelled:
                    break
                self.call_later(self._take_step, state)
            steps.close()
        except (InputError, StoreError) as error:
            self.call_later(self._take_step, replace(state, state="failed", message=str(error)))
            return
        end = "stopped" if worker.is_cancelled else "done"
        self.call_later(self._take_step, replace(state, state=end))

    def _take_step(self, state: FillState) -> None:
        """Show what has been stored, not more often than can be read."""
        now = time.monotonic()
        if self.catalogue is None:
            self.catalogue = _opened(self.path)
        stopping = self.fill_state is not None and self.fill_state.state == "stopping" and state.runs
        if not stopping:
            self.fill_state = state
        if self.leaving:
            return
        self._main.follow_fill(state)
        rest = max(_SECONDS_BETWEEN_LOOKS, _RESTS * self._main.rows.seconds_of_reading)
        if not state.runs or now - self._shown_at > rest:
            self._shown_at = now
            self._main.refresh_catalogue()
        if not state.runs:
            self.notify(
                f"fill {state.sentence()}",
                severity="error" if state.state == "failed" else "information",
            )

    def action_stop_fill(self) -> None:
        """Stop the fill behind the batch at work."""
        if self.fill_state is not None and self.fill_state.runs:
            self.fill_state = replace(self.fill_state, state="stopping")
            self.workers.cancel_group(self, "fill")

    # habits

    def _handle_exception(self, error: Exception) -> None:
        """Leave in good order if something fails; the command says what."""
        self.failure = self.failure or error
        if isinstance(error, StoreError):
            self._close_messages_no_wait()
        else:
            super()._handle_exception(error)

    def _fatal_error(self) -> None:
        """Leave, without a traceback on the terminal."""
        self._close_messages_no_wait()

    def panic(self, *renderables: RenderableType) -> None:
        """Leave when keys can no longer be read: the terminal is gone."""
        self._end(TERMINATING[-1])

    def notify(
        self,
        message: str,
        *,
        title: str = "",
        severity: SeverityLevel = "information",
        timeout: float | None = None,
        markup: bool = True,
    ) -> None:
        """Say something, never as markup: errors and paths may look like it."""
        super().notify(printable(message), title=title, severity=severity, timeout=timeout, markup=False)

    def tell(self, text: str) -> None:
        """Say something, from any thread."""
        self.call_later(self.notify, text)

    def action_keys(self) -> None:
        """Show the keys that matter here."""
        from orbitdb.cli.tui.keys import columns_for, groups_for

        if not isinstance(self.screen, KeysDialog):
            self.push_screen(KeysDialog(groups_for(self.screen), columns_for(self.screen)))

    def action_command_palette(self) -> None:
        """Show all actions by name."""
        if not isinstance(self.screen, ActionsDialog):
            self.push_screen(ActionsDialog(id="--command-palette"))

    async def action_quit(self) -> None:
        """Leave; ask first if a fill runs."""
        if self.fill_state is None or not self.fill_state.runs:
            self.exit()
            return

        def take(sure: bool | None) -> None:
            if sure:
                self.action_stop_fill()
                self.leaving = True
                self.exit()

        question = "A fill is running. What is stored stays; it can go on later."
        self.push_screen(QuestionDialog(question, "Stop it and quit", "Stay"), take)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Give every action of the screen, and those of Textual's own that are none of these, each once."""
        own: dict[str, SystemCommand] = {}
        for command in self._actions_of(screen):
            own.setdefault(command.title, command)  # an action may have several keys
        yield from own.values()
        for command in super().get_system_commands(screen):
            if command.title not in own:
                yield command

    def _actions_of(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        for active in screen.active_bindings.values():
            binding = active.binding
            useful = binding.description and "command_palette" not in binding.action
            if useful and active.enabled and not binding.system:
                action, node = binding.action, active.node
                yield SystemCommand(
                    binding.description[:1].upper() + binding.description[1:],
                    f"key {self.get_key_display(binding)}",
                    lambda action=action, node=node: self.call_later(self.run_action, action, node),
                )


def _opened(path: Path) -> "Catalogue | None":
    """Open a catalogue if there is one."""
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.file.database import check_file

    return None if check_file(path) is None else Catalogue(path)
