"""The program ``orbitdb``, and how it reports failures.

The commands are imported after the handlers for Ctrl-C are set, because importing them takes a few tenths of
a second.
"""

import errno
import gc
import os
import signal
import sys
import threading
import time
from contextlib import suppress
from io import TextIOWrapper, UnsupportedOperation
from types import FrameType
from typing import NoReturn

from orbitdb.cli.advice import completed, remember
from orbitdb.errors import DISK_TROUBLE, InputError, NotStoredError, StoreError, WorkError
from orbitdb.text import line

DONE, FAILED, USAGE, NO_DATABASE, SIGNALLED, INTERRUPTED, UNREAD = 0, 1, 2, 3, 128, 130, 141
"""Exit codes; the number of a signal is added to `SIGNALLED`."""

_LOADED = 100_000
"""Objects that may be created before garbage is collected: more than any command needs to start."""

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_ALARM = [signal.SIGALRM] if hasattr(signal, "SIGALRM") else []
_PATIENCE = 1.0
"""Seconds during which further signals are ignored, so that they do not disturb the cleanup. After that time,
the alarm raises the exception again if it was lost."""

_signalled: list[tuple[int, float]] = []
"""Number and time of the signals that arrived."""

_RESUMES = ("fill", "sweep", "births", "levels")


def run() -> None:
    """Run the command line; report a failure as one line on stderr and an exit code.

    NumPy's linear algebra gets a single thread. More threads would cost a tenth of a second of processor time
    at every start for no benefit, because parallel work runs in processes and no matrices are large.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(_LOADED)  # garbage collection takes a tenth of the time of a short command
    for number in _SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:  # as with nohup
            signal.signal(number, _end)
    for number in _ALARM:
        signal.signal(number, _end_after_all)
    sys.unraisablehook = _unraisable
    for name, mode in (("stdin", "r"), ("stdout", "r"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed; without stdout, a command that has data then fails
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115, until the end
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # for characters outside its encoding, as on stderr
    leave(execute(sys.argv[1:] or ["--help"]))


def _end(number: int, frame: FrameType | None) -> None:
    """Raise an exception where the command is, so that everything is cleaned up as after a failure."""
    now = time.monotonic()
    if not _signalled or now - _signalled[-1][1] >= _PATIENCE:
        _signalled.append((number, now))
        if _ALARM:
            signal.setitimer(signal.ITIMER_REAL, _PATIENCE, _PATIENCE)
        raise _exception_of(number)


def _exception_of(number: int) -> BaseException:
    return KeyboardInterrupt() if number == signal.SIGINT else SystemExit(SIGNALLED + number)


def _end_after_all(number: int, frame: FrameType | None) -> None:
    """Raise the exception of the last signal again unless it is on its way.

    It gets lost if it is raised in a callback, such as those of Python's imports, and in compiled code that
    clears all errors.
    """
    error = sys.exception()
    while error is not None:
        if isinstance(error, KeyboardInterrupt | SystemExit):
            return
        error = error.__context__
    raise _exception_of(_signalled[-1][0])


def _unraisable(lost: "sys.UnraisableHookArgs") -> None:
    """Report an exception in a callback, but not that of a signal, which is raised again."""
    if not isinstance(lost.exc_value, KeyboardInterrupt | SystemExit):
        sys.__unraisablehook__(lost)


def leave(code: int) -> NoReturn:
    """End the process with an exit code, undisturbed by further signals and by streams that nobody reads."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):  # Python would try again at its end, and change the exit code
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    if threading.active_count() > 1:  # Python would wait for threads of the screen that still read
        os._exit(code)
    sys.exit(code)


def execute(arguments: list[str]) -> int:
    """Run one command in this process; return its exit code. Only bugs in the program raise."""
    if arguments[0] == "help":
        arguments = [*arguments[1:2], "--help"]
    remember(arguments)
    try:
        from orbitdb.cli.app import call
        from orbitdb.cli.notes import show_warnings

        show_warnings()
        result = call(arguments)
        sys.stdout.flush()
    except KeyboardInterrupt:
        result = INTERRUPTED
    except SystemExit as end:
        result = end.code
    except Exception as error:
        if not _signalled:
            return _failed(error)
        result = SIGNALLED + _signalled[0][0]
    finally:
        for number in _ALARM:
            signal.signal(number, signal.SIG_IGN)
    code = result if isinstance(result, int) else DONE
    if code == INTERRUPTED and _signalled:  # SQLite turns every signal into a KeyboardInterrupt
        code = SIGNALLED + _signalled[0][0]
    return _ended(code, arguments) if code > SIGNALLED and code != UNREAD else code


def _ended(code: int, arguments: list[str]) -> int:
    """Report a command that a signal ended."""
    resumes = arguments[0] in _RESUMES or "--prove" in arguments
    safe = "; nothing that was stored is lost, and the same command continues from there" if resumes else ""
    return _say(f"{'interrupted' if code == INTERRUPTED else 'terminated'}{safe}", code)


def _failed(error: Exception) -> int:
    """Report a failure and return its exit code; raise the error again if it is a bug in the program."""
    from orbitdb.cli.app import ParsingError, refusal

    match error:
        case NotStoredError() | WorkError() | ModuleNotFoundError():
            return _say(str(error), FAILED)
        case InputError():
            return _say(str(error), USAGE)
        case StoreError():
            return _say(str(error), NO_DATABASE)
        case ParsingError():
            return _say(refusal(error), USAGE)
        case UnsupportedOperation():
            return _say("the output cannot be written (it is closed)", NO_DATABASE)
        case MemoryError():
            return _say("not enough memory: choose fewer periods, rows or processes (--jobs)", FAILED)
        case OSError():
            return _unwritten(error)
    raise error


def _unwritten(error: OSError) -> int:
    """Report what could not be written, unless the output is no longer read, as with ``| head``."""
    if isinstance(error, BrokenPipeError):
        return UNREAD
    if error.filename is None and error.errno == errno.ENOENT:
        return _say("the current folder no longer exists: change to another", NO_DATABASE)
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return _say("too many open files: raise the limit of the shell, 'ulimit -n'", NO_DATABASE)
    where = error.filename or "the output"
    if error.errno in DISK_TROUBLE:
        return _say(f"{where} cannot be written ({error.strerror})", NO_DATABASE)
    return _say(f"{where} cannot be read or written ({error.strerror})", FAILED)


def _say(message: str, code: int) -> int:
    over = "\r" if code == INTERRUPTED and sys.stderr.isatty() else ""  # the terminal wrote ^C here
    with suppress(OSError):
        print(over + line(f"orbitdb: {completed(message)}"), file=sys.stderr)
    return code
