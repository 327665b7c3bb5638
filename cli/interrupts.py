"""End a command early, after Ctrl-C or a termination signal.

Both raise an exception at whatever point the command has reached, so that processes and files are cleaned up
as after any other failure. `last_words` gives the message for the user.
"""

import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from types import FrameType
from typing import NoReturn

_PATIENCE = 1.0
"""Seconds during which a second Ctrl-C is ignored, so that it does not disturb the cleaning up."""

TERMINATING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that ask a process to end."""

INTERRUPTED, SIGNALLED = 130, 128
"""The exit code after Ctrl-C, and the number to add to that of a signal to get its exit code."""

_KEPT = "nothing that was stored is lost"


class Terminated(BaseException):
    """Raised when a signal asks the process to end, so that everything is closed first."""

    def __init__(self, number: int) -> None:
        self.number = number


def leave(code: int) -> NoReturn:
    """End the process, even if other threads are still running.

    Python would wait for these threads, or shut down while they run, which can crash their libraries. A
    library whose import was interrupted can crash, too.
    """
    alone = threading.active_count() == 1
    if alone and ending() is None:
        sys.exit(code)
    if alone:
        atexit._run_exitfuncs()
    sys.stderr.flush()
    os._exit(code)


_pressed: list[float] = []
"""Times at which Ctrl-C was handled, in seconds."""

_told: list[int] = []
"""The number of the signal that asked the process to end, once there is one."""

_heeded: list[int] = []
"""The signals to terminate that this process does not ignore."""


def end_as_users_expect() -> None:
    """Let Ctrl-C and the signals to terminate raise exceptions; repeated Ctrl-C counts once.

    Signals that the process was started to ignore, as with ``nohup``, stay ignored.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    _heeded[:] = [number for number in TERMINATING if signal.getsignal(number) == signal.SIG_DFL]
    _act_on_terminating(_terminate)
    sys.unraisablehook = _unraisable


def end_undisturbed() -> None:
    """Stop turning signals into exceptions, because only the interpreter remains to be shut down.

    Ctrl-C is ignored. A termination signal ends the process at once, even while it is blocked writing its
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
    """Do not report an interruption that cannot be raised, as during garbage collection.

    `ending` returns it later. Objects that it left half open can fail in turn, which is not reported either.
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


def last_words(end: KeyboardInterrupt | Terminated, arguments: Sequence[str]) -> tuple[str, int]:
    """Return the message and the exit code of a command that was ended early."""
    if isinstance(end, Terminated):
        return f"terminated{_consolation(arguments)}", SIGNALLED + end.number
    return f"interrupted{_consolation(arguments)}", INTERRUPTED


def _consolation(arguments: Sequence[str]) -> str:
    """Return what an early end means for stored data; empty if the command stores nothing."""
    match arguments[0]:
        case "births" if not any(argument.startswith("--p") for argument in arguments):
            return ""
        case "verify" if "--rigorous" not in arguments:
            return ""
        case "fill" | "sweep" | "births" | "verify" if "--again" not in arguments:
            return f"; {_KEPT}, and the same command continues from there"
        case "fill" | "verify" | "simulate" | "bounds" | "browse" | "tui":
            return f"; {_KEPT}"
    return ""
