"""Find bounds on the topological entropy, and store them."""

import logging
import math
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import EntropyBounds, enclose, search, search_in_balls
from orbitdb.errors import InputError, check_number
from orbitdb.filling.estimate import about
from orbitdb.filling.workers import at_work
from orbitdb.progress import Tell, nobody
from orbitdb.store.storing import keep_bounds
from orbitdb.store.writer import Writer
from orbitdb.text import format_float

_FEWEST, MOST_EDGES = 2, 40
_USUAL_WINDOW = 14
"""Default number of edges of the longest windows for entropy bounds."""
_SECONDS_OF_BOUNDS = 0.4
"""Approximate time to find entropy bounds at a single a with the default windows."""

_TIMES_LONGER = 1.8
"""Factor by which each further edge lengthens this."""

_LONG = 60.0
"""Searches that may take this long, in seconds, say so first."""

Limits = tuple[int | None, float, float]
"""Limits that end a search for bounds: edges of the longest windows, width of the bounds, time in seconds."""


def find_bounds(
    path: Path | None,
    values: Sequence[float],
    edges: int | None,
    width: float | None = None,
    seconds: float | None = None,
    prove: bool = False,
    jobs: int | None = None,
    tell: Tell = nobody,
) -> Generator[EntropyBounds]:
    """Bound the topological entropy with longer and longer windows, and store the bounds.

    Wrong limits are refused at once, before the first bounds are asked for.

    Parameters
    ----------
    path : Path or None
        The catalogue; None to store nothing.
    values : sequence of float
        Values of a; if there are several, they are divided among processes.
    edges, width, seconds : optional
        Limits that end the search, as in `Catalogue.prove_bounds`.
    prove : bool, optional
        Whether ball arithmetic checks each decision.
    jobs, tell : optional

    Returns
    -------
    generator of EntropyBounds
        Bounds for each a and length of windows, in ascending order.
    """
    limits = _limits(edges, width, seconds)
    parameters = {
        "command": "bounds",
        "a": values,
        "edges": limits[0],
        "width": width,
        "seconds": seconds,
        "prove": prove,
    }
    return _stored(path, parameters, _enclosed(values, limits, prove, jobs, tell))


def _stored(
    path: Path | None,
    parameters: dict[str, Any],
    levels: Iterable[tuple[EntropyBounds, str | None]],
) -> Generator[EntropyBounds]:
    """Store bounds one by one, unless there is no path, and yield each one."""
    with nullcontext() if path is None else closing(Writer(path, parameters)) as writer:
        for level, computed in levels:
            if writer is not None:
                keep_bounds(writer, level, computed)
            yield level


def _enclosed(
    values: Sequence[float], limits: Limits, prove: bool, jobs: int | None, tell: Tell
) -> Iterator[tuple[EntropyBounds, str | None]]:
    """Yield bounds, each time with the arithmetic that computed them, or None if this process did."""
    if limits[0] and limits[-1] == math.inf and (takes := len(values) * _time_at_one_a(limits[0])) >= _LONG:
        logging.getLogger("orbitdb").warning(
            "windows of %s edges take %s of processor time", limits[0], about(takes)
        )
    if len(values) == 1:
        find = search_in_balls if prove else search
        yield from ((level, None) for level in find(Stadium(values[0]), *limits, tell))
        return
    seconds = _time_at_one_a(limits[0])
    tasks = [partial(enclose, a, *limits, prove) for a in values]
    with at_work(len(tasks) * seconds, jobs) as workers:
        for done, solved in enumerate(workers.solved(tasks), 1):
            yield from ((level, solved.arithmetic) for level in solved.levels)
            tell(done, len(tasks), f"a = {format_float(solved.levels[-1].a)}")


def _time_at_one_a(edges: int | None) -> float:
    """Estimate the processor time, in seconds, for bounds at one a from windows of up to `edges` edges."""
    return _SECONDS_OF_BOUNDS * _TIMES_LONGER ** ((edges or _USUAL_WINDOW) - _USUAL_WINDOW)


def _limits(edges: int | None, width: float | None, seconds: float | None) -> Limits:
    """Return the limits of a search for bounds, which stops at the first limit that it reaches.

    Raises `InputError` unless width and time are above 0, and the windows have 2 to 40 edges.
    """
    if edges is not None and edges not in range(_FEWEST, MOST_EDGES + 1):
        raise InputError(f"windows of {edges} edges: give a whole number from {_FEWEST} to {MOST_EDGES}")
    for name, limit in (("width", width), ("seconds", seconds)):
        check_number(name, limit or 0)
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"{name} {limit:g}: give a number above 0")
    most = int(edges) if edges else _USUAL_WINDOW if width is None and seconds is None else None
    return most, width or 0.0, seconds or math.inf
