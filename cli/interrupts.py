"""End a command early: Ctrl-C, or a signal to terminate.

For every command, both become exceptions at the current place, so that processes and files are cleaned up as
after any other failure. `orbitdb.cli.main` writes the one-line message.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import NoReturn

_PATIENCE = 1.0
"""Seconds during which a second Ctrl-C does not disturb the work started by the first."""

TERMINATING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that ask a process to end."""

SIGNALLED = 128
"""The exit code after a signal, less the number of the signal."""


class Terminated(BaseException):
    """A signal with this number asked the process to end; everything is closed on the way."""

    def __init__(self, number: int) -> None:
        self.number = number


def leave(code: int) -> NoReturn:
    """Flush all output and end the process, whatever other threads still do.

    Python would wait for them, or shut down under them, which their libraries may not survive.
    """
    if threading.active_count() > 1:
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


_pressed: list[float] = []
"""Time of the last handled Ctrl-C, in seconds."""

_told: list[int] = []
"""The signal that asked the process to end."""

_heeded: list[int] = []
"""The signals that can ask it to end."""


def end_as_users_expect() -> None:
    """Handle repeated Ctrl-C once, and SIGTERM.

    Signals ignored from the start of the process, as with ``nohup``, stay ignored.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    _heeded[:] = [number for number in TERMINATING if signal.getsignal(number) == signal.SIG_DFL]
    _act_on_terminating(_terminate)
    sys.unraisablehook = _unraisable


def end_undisturbed() -> None:
    """Raise nothing from here on, because only the interpreter is left to close.

    Ctrl-C is ignored. A signal ends the process at once, even while it waits for a reader of its
    output.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _act_on_terminating(signal.SIG_DFL)


def _interrupt(number: int, frame: FrameType | None) -> None:
    now = time.monotonic()
    if not _pressed or now - _pressed[-1] >= _PATIENCE:
        _pressed.append(now)
        raise KeyboardInterrupt


def _terminate(number: int, frame: FrameType | None) -> None:
    _act_on_terminating(signal.SIG_IGN)
    _told.append(number)
    raise Terminated(number)


def _act_on_terminating(action: Callable[[int, FrameType | None], None] | signal.Handlers) -> None:
    for number in _heeded:
        signal.signal(number, action)


def _unraisable(told: "sys.UnraisableHookArgs") -> None:
    """Keep quiet about an end where nothing can be raised, as during garbage collection, and what follows.

    `ending` remembers it. Objects that it left half open can fail in turn.
    """
    if ending() is None:
        sys.__unraisablehook__(told)


def ending() -> KeyboardInterrupt | Terminated | None:
    """Return the exception that ends the command after Ctrl-C or a signal to terminate, or None.

    Either exception can get lost: NumPy clears exceptions during attribute lookup, and Python during garbage
    collection.
    """
    if _told:
        return Terminated(_told[0])
    return KeyboardInterrupt() if _pressed else None


def go_on() -> None:
    """Raise the exception that ends the command (`ending`), if there is one."""
    if (end := ending()) is not None:
        raise end
