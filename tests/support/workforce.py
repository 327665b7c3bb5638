"""Fills by given workers, and a block that kills them."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orbitdb.filling.periods import fill_periods
from orbitdb.filling.workers import Workers
from orbitdb.store.file.migrate import migrate


def filled_by(workers: Workers, path: Path, a: float = 1.6, periods: Sequence[int] = (7, 8)) -> Path:
    migrate(path)
    for _ in fill_periods(path, a, periods, workers=workers):
        pass
    return path


class Deadly:
    """Ends every process that receives it."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (7,)


class Failing:
    """A block that cannot be solved."""

    def solved(self) -> None:
        raise ZeroDivisionError("by nothing\nat all")
