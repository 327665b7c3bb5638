"""The command ``orbitdb``, and its failures.

The commands are imported after the handlers for Ctrl-C are set, which takes some tenths of a second.
"""

import errno
import gc
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from io import TextIOWrapper, UnsupportedOperation
from typing import TYPE_CHECKING

from orbitdb.cli.advice import completed, remember
from orbitdb.cli.interrupts import SIGNALLED, Terminated, end_as_users_expect, end_undisturbed, ending, leave
from orbitdb.errors import DISK_TROUBLE, InputError, StoreError, WorkError
from orbitdb.plaintext import line

if TYPE_CHECKING:
    from orbitdb.cli.app import ParsingError

DONE, FAILED, USAGE, NO_DATABASE, INTERRUPTED, UNREAD = 0, 1, 2, 3, 130, 141
_KEPT = "nothing that was stored is lost"
_STREAMS = 3
_LOADED = 100_000
"""More objects than any command loads."""


def run() -> None:
    """Run the command line; every failure becomes one line on stderr and an exit code.

    Parallel work runs in processes. Threads of NumPy's linear algebra would cost a tenth of a second of
    processor time at each start, and there are no products of large matrices.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(_LOADED)  # garbage collection takes a tenth of the time of a short command
    end_as_users_expect()
    stand_in_for_closed()
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # for characters outside its encoding, as on stderr
    code = execute(sys.argv[1:] or ["--help"])
    end_undisturbed()
    if (database := sys.modules.get("orbitdb.store.file.database")) is not None:
        database.close_connections()
    gc.freeze()  # the end of the process frees everything
    try:
        sys.stdout.flush()
    except OSError as error:
        code = code or _unwritten(error)
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
        )  # for the flush at the end of the process
    leave(code)


def execute(arguments: list[str]) -> int:
    """Run one command in this process; return its exit code, whatever happens."""
    if any("\0" in argument for argument in arguments):
        return _say("an argument contains a NUL character", USAGE)
    if arguments[0] == "help":
        arguments = [*arguments[1:2], "--help"]
    remember(arguments)
    try:
        from orbitdb.cli.app import call

        result = call(arguments)
    except Terminated as end:
        return _ended(end, arguments)
    except KeyboardInterrupt:
        result = INTERRUPTED
    except Exception as error:
        lost = ending()  # a library may have replaced it
        return _failed(error) if lost is None else _ended(lost, arguments)
    if result == INTERRUPTED:  # SQLite, for example, does not say what interrupted it
        return _ended(ending() or KeyboardInterrupt(), arguments)
    return result if isinstance(result, int) else DONE


def _ended(end: KeyboardInterrupt | Terminated, arguments: Sequence[str]) -> int:
    """Say that the command was ended from outside, and that stored data is safe."""
    if isinstance(end, Terminated):
        return _say(f"terminated{_consolation(arguments)}", SIGNALLED + end.number)
    return _say(f"interrupted{_consolation(arguments)}", INTERRUPTED)


def _consolation(arguments: Sequence[str]) -> str:
    """Say what an early end means for stored data, if the command stores any."""
    match arguments[0]:
        case "births" if not any(argument.startswith("--p") for argument in arguments):
            return ""
        case "verify" if "--rigorous" not in arguments:
            return ""
        case "fill" | "sweep" | "births" | "verify" if "--again" not in arguments:
            return f"; {_KEPT}, and the same command goes on from there"
        case "fill" | "verify" | "simulate" | "bounds" | "browse" | "tui":
            return f"; {_KEPT}"
    return ""


def _failed(error: Exception) -> int:
    """Say what was wrong; raise a fault of the program again."""
    from orbitdb.cli.app import ParsingError

    match error:
        case InputError():
            return _say(str(error), USAGE)
        case StoreError():
            return _say(str(error), NO_DATABASE)
        case WorkError() | ModuleNotFoundError():
            return _say(str(error), FAILED)
        case ParsingError():
            return _say(f"{' '.join(error.format_message().split())} ({_advice(error)})", USAGE)
        case UnsupportedOperation():
            return _say("the output cannot be written (it is closed)", NO_DATABASE)
        case OSError():
            return _unwritten(error)
    raise error


def _advice(error: "ParsingError") -> str:
    """Return advice on unreadable arguments."""
    context = getattr(error, "ctx", None)
    if context is not None and context.parent is None and hasattr(error, "option_name"):
        return "options go after the command, as in 'orbitdb table --db PATH'"
    mistyped = getattr(error, "option_name", None)
    if context is not None and mistyped and not getattr(error, "possibilities", None):
        known = [name for each in context.command.params for name in each.opts if name.startswith("--")]
        if meant := [name for name in known if mistyped.startswith(name) or name.startswith(mistyped)]:
            return f"did you mean {' or '.join(meant)}? --help shows the options"
    return "--help shows the options"


def _unwritten(error: OSError) -> int:
    """Say what could not be written; nothing if nobody reads any more, as with ``| head``."""
    if isinstance(error, BrokenPipeError):
        return UNREAD
    if error.filename is None and error.errno == errno.ENOENT:
        return _say("the current folder no longer exists: change to another", NO_DATABASE)
    where = error.filename or "the output"
    if error.errno in DISK_TROUBLE:
        return _say(f"{where} cannot be written ({error.strerror})", NO_DATABASE)
    return _say(f"{where} cannot be read or written ({error.strerror})", FAILED)


def _say(message: str, code: int) -> int:
    over = "\r" if code == INTERRUPTED and sys.stderr.isatty() else ""  # the terminal wrote ^C here
    with suppress(OSError):
        print(over + line(f"orbitdb: {completed(message)}"), file=sys.stderr)
    return code


def stand_in_for_closed() -> None:
    """Give the process its three standard streams; Python sets closed ones to None.

    Their file numbers are also taken, so that no other file gets one and is written to by mistake. A closed
    stdout refuses data; a command that writes none does not notice.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) < _STREAMS:
        pass
    os.close(number)
    for name, mode in (("stdin", "r"), ("stdout", "r"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115, until the end
