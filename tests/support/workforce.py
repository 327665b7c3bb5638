"""Fills by given workers, and blocks that kill their worker or fail."""

import os
import pickle
import signal
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orbitdb.filling.fill import fill_periods
from orbitdb.filling.workers import Workers
from orbitdb.store.file import migrate


def filled_by(workers: Workers, path: Path, a: float = 1.6, periods: Sequence[int] = (7, 8)) -> Path:
    migrate(path)
    list(fill_periods(path, a, periods, workers=workers))
    return path


class Deadly:
    """A block that ends every process to which it is sent."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (7,)

    def __call__(self) -> None:
        raise AssertionError("it was not sent to another process")


class Failing:
    """A block that raises."""

    def __call__(self) -> None:
        raise ZeroDivisionError("by nothing\nat all")


def killed_while_sending(part: float) -> None:
    """A block whose process dies after it has sent part of a result of a megabyte."""
    result = pickle.dumps((True, bytes(1 << 20)))
    sent = result[: int(part * len(result))]
    while sent:
        sent = sent[os.write(1, sent) :]
    os.kill(os.getpid(), signal.SIGKILL)


def later(seconds: float, answer: int) -> int:
    """A block that takes some time."""
    time.sleep(seconds)
    return answer
