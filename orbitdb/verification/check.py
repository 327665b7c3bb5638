"""Check: how one promise of a catalogue fares over many rows."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Check:
    """How one promise fares over some rows.

    Attributes
    ----------
    name : str
        Which promise.
    rows, failures : int
        Rows looked at, and those of them that are wrong.
    worst : float or None
        The deviation of the row with the largest share.
    share : float or None
        That deviation over what is allowed in its row; above 1 is a failure.
    first : str or None
        The first row that is wrong.
    """

    name: str
    rows: int
    failures: int = 0
    worst: float | None = None
    share: float | None = None
    first: str | None = None

    def joined(self, other: "Check") -> "Check":
        """Return the same check over both sets of rows."""
        larger = max((self, other), key=lambda part: -1.0 if part.share is None else part.share)
        return replace(
            larger,
            rows=self.rows + other.rows,
            failures=self.failures + other.failures,
            first=self.first or other.first,
        )


@dataclass(frozen=True)
class Step:
    """What one step of a verification has found.

    Attributes
    ----------
    stage : str
        What is at work.
    done, total : int
        How far the stage has come, in classes.
    checks : tuple of Check
        Over the rows of this step; joined by name they are the report.
    """

    stage: str
    done: int
    total: int
    checks: tuple[Check, ...]


def judged(name: str, labels: Sequence[str], wrong: NDArray[np.bool_] | Sequence[bool]) -> Check:
    """Return a check that each row, named by its word or another label, passes or fails."""
    marks = np.asarray(wrong, dtype=bool)
    first = shown(labels[int(marks.argmax())]) if marks.any() else None
    return Check(name, len(marks), int(marks.sum()), first=first)


def listed(name: str, rows: int, wrong: Sequence[str]) -> Check:
    """Return a check of so many rows, given the labels of the wrong ones."""
    return Check(name, rows, len(wrong), first=wrong[0] if wrong else None)


def single(name: str, label: str, wrong: Iterable[str]) -> Check:
    """Return a check of one row, and say the first of what is wrong with it."""
    first = next(iter(wrong), None)
    return Check(name, 1, int(first is not None), first=None if first is None else f"{label}: {first}")


def shares(deviation: NDArray[np.float64], allowed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return deviations over those that are allowed: 0 where there is none, infinite for NaN."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(deviation == 0, 0.0, deviation / allowed)
    return np.where(np.isnan(share), np.inf, share)


def measured(
    name: str, labels: Sequence[str], deviation: NDArray[np.float64], allowed: NDArray[np.float64]
) -> Check:
    """Return a check of deviations against those that are allowed, shape (N,) each; NaN fails."""
    share = shares(deviation, allowed)
    found = judged(name, labels, share > 1)
    if not len(share):
        return found
    worst = int(share.argmax())
    return replace(found, worst=float(deviation[worst]), share=float(share[worst]))


def shown(word: str) -> str:
    """Return a word as the label of a row."""
    return word if len(word) <= 40 else f"{word[:37]}..."
