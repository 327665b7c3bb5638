"""Standard streams that are closed (``>&-``), or that cannot write every character."""

import errno
import io
import os
import sys

_STREAMS = 3


class _ClosedOutput(io.TextIOBase):
    """An output that nothing can be written to: who has data for it is told, who has none need not know."""

    def write(self, text: str, /) -> int:
        """Refuse what is written, as a disk that is full does."""
        raise OSError(errno.EIO, "it is closed")


def stand_in_for_closed() -> None:
    """Give the process its three standard streams; Python has None for one that is closed.

    Their numbers are taken as well, so that no file gets one of them and is written to by mistake.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) < _STREAMS:
        pass
    os.close(number)
    if sys.stdin is None:
        sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115, for as long as the process lives
    if sys.stdout is None:
        sys.stdout = _ClosedOutput()
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def escape_what_has_no_code() -> None:
    """Let stdout escape characters that its encoding has not, such as those of a path, as stderr does."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")
