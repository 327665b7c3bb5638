"""A pool of workers that come and go and finish in any order; its results in the order of the blocks."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Future
from typing import Protocol

from orbitdb.errors import WorkError
from orbitdb.filling.blocks import Result, Result_co, Task
from orbitdb.version import __version__

_DEATHS = 3
"""How often workers may die on one block."""


class Promise(Protocol[Result_co]):
    """What becomes of a block, once it is known."""

    def result(self) -> Result_co:
        """Wait for it and return it."""


class Pool(Protocol):
    """Something that takes blocks and promises their results."""

    def submit(self, block: Task[Result]) -> Promise[Result]:
        """Begin with a block."""

    def renew(self) -> None:
        """Make ready for new blocks after workers have died."""


def in_order(pool: Pool, blocks: Iterable[Task[Result]], ahead: Callable[[], int]) -> Iterator[Result]:
    """Solve blocks in a pool; yield the results in the order of the blocks.

    Parameters
    ----------
    pool : Pool
    blocks : iterable of Task
    ahead : callable
        Says how many blocks may be under way beside the one that is waited for; it is asked before
        every block, as a pool may grow.

    Raises
    ------
    WorkError
        If workers die again and again on one block, or are of another version.

    Notes
    -----
    Blocks under way are not cancelled when nobody wants them any more: the executor of Python 3.11 fails
    if one of its processes dies while it holds a cancelled future.
    """
    waiting: deque[tuple[Task[Result], Promise[Result]]] = deque()
    for block in blocks:
        waiting.append((block, _submit(pool, block)))
        while len(waiting) > ahead():
            yield _first_result(pool, waiting)
    while waiting:
        yield _first_result(pool, waiting)


def _submit(pool: Pool, block: Task[Result]) -> Promise[Result]:
    """Begin with a block; if workers have died unnoticed, promise what tells so."""
    try:
        return pool.submit(block)
    except (BrokenExecutor, BrokenPipeError) as error:
        broken: Future[Result] = Future()
        broken.set_exception(error)
        return broken


def _first_result(pool: Pool, waiting: deque[tuple[Task[Result], Promise[Result]]]) -> Result:
    """Wait for the first block under way; begin anew with all of them if a worker has died."""
    for _ in range(_DEATHS):
        try:
            result = waiting[0][1].result()
        except (BrokenExecutor, BrokenPipeError):
            pool.renew()
            blocks = [block for block, _ in waiting]
            waiting.clear()
            waiting.extend((block, _submit(pool, block)) for block in blocks)
        else:
            waiting.popleft()
            if result.version != __version__:
                raise WorkError(f"a worker runs orbitdb {result.version}: install {__version__} there, too")
            return result
    raise WorkError(
        f"worker processes died {_DEATHS} times on one block: if memory is short, try fewer with --jobs"
    )
