"""Measure the processor time of questions about chosen rows, and of the pages of the screen.

Run it as ``python tests/benchmarks/bench_questions.py CATALOGUE [REPETITIONS]`` with orbitdb installed; the
catalogue needs periods up to 13 or more at a = 1.6, such as ``orbitdb fill --p 13`` stores. Each question is
asked several times, by default 3, and the least time counts.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from orbitdb import Catalogue, Selection
from orbitdb.cli.tui.stored import USUAL, Ordering, Pages

A = 1.6
EVERY = Selection(A)
"""The words of every status but `geometric`."""

WITH_PRUNED = Selection.from_criteria(a=A, status="all")


def page_of_lengths(catalogue: Catalogue) -> None:
    """Read the shortest orbits, with all that a command says about them."""
    listing = catalogue.rows(EVERY, order="length", limit=20, columns=USUAL)
    assert len(list(listing)) <= listing.total
    assert listing.complete
    assert listing.notes is not None


def hundred_words(catalogue: Catalogue) -> None:
    """Look up a word a hundred times."""
    for _ in range(100):
        assert catalogue[WORD].stored


def hundred_words_at_one_moment(catalogue: Catalogue) -> None:
    """Look up a word a hundred times in a snapshot."""
    with catalogue.snapshot() as then:
        hundred_words(then)


def last_page(pages: Pages) -> None:
    """Read the last row, as if no page had been read."""
    replace(pages).row(len(pages) - 1)


WORD = "1232131"

QUESTIONS: dict[str, Callable[[Catalogue], object]] = {
    "count()": lambda catalogue: catalogue.count(EVERY),
    'rows(order="length", limit=20), total, notes': page_of_lengths,
    'rows(order="length", limit=20)': lambda c: [*c.rows(EVERY, order="length", limit=20, columns=USUAL)],
    'rows(order="code", limit=20)': lambda c: [*c.rows(EVERY, order="code", limit=20, columns=USUAL)],
    "rows(where=\"code like '%0202%'\", limit=20)": lambda c: [
        *c.rows(replace(EVERY, where="code like '%0202%'"), limit=20, columns=USUAL)
    ],
    'rows(order="length", limit=20, status="all")': lambda c: [
        *c.rows(WITH_PRUNED, order="length", limit=20, columns=USUAL)
    ],
    "rows()": lambda c: sum(1 for _ in c.rows(EVERY, columns=USUAL)),
    'rows(order="code")': lambda c: sum(1 for _ in c.rows(EVERY, order="code", columns=USUAL)),
    "select(p=12)": lambda catalogue: catalogue.select(replace(EVERY, periods=((12, 12),))),
    f'catalogue["{WORD}"], 100 times': hundred_words,
    "the same in a snapshot": hundred_words_at_one_moment,
    "lyapunov()": lambda catalogue: catalogue.lyapunov(a=A),
}


def measured(question: Callable[[], object], repetitions: int) -> float:
    """Return the least processor time in milliseconds."""
    times = []
    for _ in range(repetitions):
        clock = time.process_time()
        question()
        times.append(time.process_time() - clock)
    return min(times) * 1e3


def report(name: str, milliseconds: float) -> None:
    """Print the line of a question."""
    print(f"{name:46} {milliseconds:10.1f}", flush=True)


def main() -> None:
    """Print the processor time of each question."""
    path, repetitions = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    catalogue = Catalogue(path)
    print(f"{'milliseconds of processor time':46} {catalogue.count(EVERY):>10,} words")
    for name, question in QUESTIONS.items():
        report(name, measured(partial(question, catalogue), repetitions))
    for order in ("p", "length", "code"):
        ask = partial(Pages.read, catalogue, EVERY, Ordering(order), USUAL, catalogue)
        report(f"the screen by {order}", measured(ask, repetitions))
        pages = ask()
        report("  its last page", measured(partial(last_page, pages), repetitions))
        report("  the row of 0103155", measured(partial(pages.position, "0103155"), repetitions))


if __name__ == "__main__":
    main()
