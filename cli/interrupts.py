"""How a command ends before its time: Ctrl-C, or a signal to terminate.

Both signals become exceptions in whatever the command does, for all commands alike, so that processes and
files are cleared away as after any other failure. `orbitdb.cli.main` says the one line.
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
"""Seconds in which a further Ctrl-C does not disturb what the first one has set going."""

TERMINATING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that ask a process to end."""

SIGNALLED = 128
"""The exit code after a signal, less the number of the signal."""


class Terminated(BaseException):
    """A signal, of this number, has asked the process to end; everything is to be closed on the way."""

    def __init__(self, number: int) -> None:
        self.number = number


def leave(code: int) -> NoReturn:
    """End the process, all that it has written being flushed, whatever other threads still do.

    Python would wait for them, or take itself apart, which libraries that they work in may not survive.
    """
    if threading.active_count() > 1:
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


_pressed: list[float] = []
"""When Ctrl-C was heeded, in seconds."""

_told: list[int] = []
"""The signal that has asked the process to end."""

_heeded: list[int] = []
"""The signals that may do so."""


def end_as_users_expect() -> None:
    """Take Ctrl-C once however often it is pressed, and heed SIGTERM.

    Signals that the process was started to ignore, as by ``nohup``, stay ignored.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    _heeded[:] = [number for number in TERMINATING if signal.getsignal(number) == signal.SIG_DFL]
    _act_on_terminating(_terminate)
    sys.unraisablehook = _unraisable


def end_undisturbed() -> None:
    """Raise nothing from here on: all is said and cleared away, and only the interpreter is still to close.

    Ctrl-C is not heard any more. What tells to end ends the process at once, which may still wait for whoever
    reads its output.
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
    """Say nothing of an end that came where nothing can be raised, as while objects are collected.

    It is remembered (`ending`).
    """
    if not issubclass(told.exc_type, KeyboardInterrupt | Terminated):
        sys.__unraisablehook__(told)


def ending() -> KeyboardInterrupt | Terminated | None:
    """Return what ends the command if Ctrl-C has been pressed, or a signal has asked it to terminate.

    Either may be lost on its way: NumPy clears whatever is raised while it looks for attributes, and Python
    what is raised while objects are collected.
    """
    if _told:
        return Terminated(_told[0])
    return KeyboardInterrupt() if _pressed else None


def go_on() -> None:
    """Raise what ends the command (`ending`), if it has been ended from outside."""
    if (end := ending()) is not None:
        raise end
