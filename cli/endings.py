"""How a command ends before its time: Ctrl-C, a signal to terminate, a pipe that nobody reads."""

import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TypeVar

_PATIENCE = 1.0
"""Seconds in which a further Ctrl-C does not disturb what the first one has set going."""

TERMINATING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that tell a process to end."""

Step = TypeVar("Step")


class Terminated(BaseException):
    """The process has been told to end; everything is to be closed on the way.

    Attributes
    ----------
    number : int
        Of the signal.
    """

    def __init__(self, number: int) -> None:
        self.number = number


def end_as_users_expect() -> None:
    """Take Ctrl-C once however often it is pressed, and end quietly before ``| head``."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    sys.unraisablehook = _unraisable


def end_undisturbed() -> None:
    """Be deaf to Ctrl-C from here on: all is said, and only the interpreter is still to close."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class _InterruptOnce:
    def __init__(self) -> None:
        self.last = -_PATIENCE
        self.pressed = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if now - self.last >= _PATIENCE:
            self.last = now
            self.pressed = True
            raise KeyboardInterrupt


_interrupt = _InterruptOnce()


class _TerminateOnce:
    def __init__(self) -> None:
        self.number: int | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_IGN)
        self.number = number
        raise Terminated(number)


_terminate = _TerminateOnce()


def _unraisable(told: "sys.UnraisableHookArgs") -> None:
    """Say nothing of an end that came where nothing can be raised, as while objects are collected.

    It is remembered (`ending`).
    """
    if not issubclass(told.exc_type, KeyboardInterrupt | Terminated):
        sys.__unraisablehook__(told)


def ending() -> KeyboardInterrupt | Terminated | None:
    """Return what ends the command if Ctrl-C has been pressed, or a signal has told it to terminate.

    Either may be lost on its way: NumPy clears whatever is raised while it looks for attributes, and Python
    what is raised while objects are collected.
    """
    if _terminate.number is not None:
        return Terminated(_terminate.number)
    return KeyboardInterrupt() if _interrupt.pressed else None


def until_ended(steps: Iterable[Step]) -> Iterator[Step]:
    """Pass steps on until the command is ended from outside, even if that was lost on its way."""
    for step in steps:
        if (end := ending()) is not None:
            raise end
        yield step


@contextmanager
def with_other_processes() -> Iterator[None]:
    """Close other processes when this one is told to end, and survive their deaths.

    Raises
    ------
    Terminated
        On a signal to terminate.
    """
    pipes = [signal.SIGPIPE] if hasattr(signal, "SIGPIPE") else []
    with told_to_end(), _unless_handled(pipes, signal.SIG_IGN):
        yield


@contextmanager
def told_to_end() -> Iterator[None]:
    """Close what is open when a signal says to end.

    Raises
    ------
    Terminated
        On a signal to terminate.
    """
    with _unless_handled(TERMINATING, _terminate):
        yield


@contextmanager
def _unless_handled(
    signals: Iterable[int], action: Callable[[int, FrameType | None], None] | signal.Handlers
) -> Iterator[None]:
    """Handle those signals that do what they do by default."""
    ours = [number for number in signals if signal.getsignal(number) == signal.SIG_DFL]
    for number in ours:
        signal.signal(number, action)
    try:
        yield
    finally:
        for number in ours:
            with suppress(ValueError):
                signal.signal(number, signal.SIG_DFL)
