"""Progress reports for long computations."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TypeAlias

Tell: TypeAlias = Callable[[float, float, str], object]
"""Called with the amount done, the total (0 if unknown), and a text."""


def nobody(done: float, total: float, text: str) -> None:
    """Ignore a progress report."""


@contextmanager
def telling(progress: Tell | None, text: str) -> Iterator[Tell]:
    """Yield the function that receives progress reports: the given one, a bar in a notebook, or `nobody`."""
    if progress is not None or not _in_notebook():
        yield progress or nobody
    elif find_spec("tqdm") is not None:
        with _tqdm(text) as tell:
            yield tell
    else:
        with _rich(text) as tell:
            yield tell


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    return ipython is not None and type(ipython.get_ipython()).__name__ == "ZMQInteractiveShell"


@contextmanager
def _tqdm(text: str) -> Iterator[Tell]:
    from tqdm.auto import tqdm

    with tqdm(desc=text, unit_scale=True) as bar:

        def tell(done: float, total: float, text: str) -> None:
            bar.total, bar.n = total or None, done
            bar.set_description(text)

        yield tell


@contextmanager
def _rich(text: str) -> Iterator[Tell]:
    from rich.progress import Progress

    with Progress() as bars:
        bar = bars.add_task(text)
        yield lambda done, total, text: bars.update(
            bar, completed=done, total=total or None, description=text
        )
