"""What the screen needs of signals."""

import signal

SIGNALLED = 128
"""Added to the number of a signal, it gives the exit code."""

TERMINATING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that ask a process to end."""


class Terminated(SystemExit):
    """Raised when a signal asks the process to end."""

    def __init__(self, number: int) -> None:
        super().__init__(SIGNALLED + number)
