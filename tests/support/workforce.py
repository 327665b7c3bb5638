"""Fills by given workers, and blocks that kill their worker, fail, or wait before they answer."""

import os
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orbitdb.filling.fill import fill_periods
from orbitdb.filling.workers import Processes, Task, Workers
from orbitdb.store.file.migrate import migrate


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


@dataclass(frozen=True)
class Waiting:
    """A block that records the process that solved it, and answers when a file in the folder allows it."""

    block: Task[Any]
    number: int
    folder: Path

    def __call__(self) -> Any:
        found = self.block()
        with (self.folder / f"solved-{self.number}").open("a") as file:
            file.write(f"{os.getpid()}\n")
        while not (self.folder / "go").exists():
            time.sleep(0.01)
        return found


@dataclass
class WaitingProcesses(Workers):
    """Worker processes whose blocks wait (`Waiting`)."""

    workers: Processes
    folder: Path
    jobs: int = 2

    def solved(self, blocks: Iterable[Task[Any]]) -> Iterator[Any]:
        return self.workers.solved(Waiting(block, n, self.folder) for n, block in enumerate(blocks))


def fill_when_let(path: str, period: str) -> None:
    with Processes(2) as workers:
        filled_by(WaitingProcesses(workers, Path(path).parent), Path(path), periods=[int(period)])
