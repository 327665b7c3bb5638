"""Check rows as they are read, because somebody may have altered the file with another program."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from orbitdb.arrays import Floats, Marks, Places
from orbitdb.errors import AlteredError
from orbitdb.orbits.status import EXISTING, NUMBERS, Status
from orbitdb.plaintext import printable, shortened
from orbitdb.symbols.pruning import RULES, rules_broken
from orbitdb.symbols.symmetry import STABILISER_OF
from orbitdb.symbols.words import are_primitive, from_strings

StoredRow = Mapping[str, Any]
StoredColumns = Mapping[str, Sequence[Any]]

_BOUNDS = ("error", "length_error", "lyapunov_error")
_SOLVERS = {"newton", "relaxation"}
_WORD = re.compile("[0-5]+")
_RULES = {str(rule.number) for rule in RULES}
_FAR = 1e7
"""Larger than all coordinates in all stadiums."""


def unsound(what: str, value: object) -> AlteredError:
    """Return the error for a value that cannot occur in a catalogue."""
    text = printable(str(value))
    return AlteredError(f"{what} {shortened(text)!r}")


def is_whole(row: StoredRow, p: int) -> bool:
    """Tell whether a row of `orbit` has the values that its status requires."""
    return bool(are_whole({name: [value] for name, value in row.items()}, p)[0])


def are_whole(columns: StoredColumns, p: int) -> Marks:
    """Tell which rows of `orbit`, given as columns, have the values that their statuses require.

    The rows must have the same period p.
    """
    solvers, statuses, blobs = (columns[name] for name in ("solver", "status", "coordinates"))
    numbers = {name: _numbers(columns[name]) for name in NUMBERS}
    without = [np.isnan(numbers[name]) for name in NUMBERS if name != "margin"]
    empty = np.all([*without, _marks(blob is None for blob in blobs)], axis=0)
    unresolved = _marks(status == Status.UNRESOLVED for status in statuses)
    dynamical = _marks(status == Status.DYNAMICAL for status in statuses)
    pruned = empty & (unresolved | (dynamical & ~np.isnan(numbers["margin"])))
    existing = _marks(status in EXISTING for status in statuses)
    relaxed = _marks(solver == "relaxation" for solver in solvers)
    whole = (existing & _have_numbers(numbers, relaxed) & _have_places(blobs, p)) | (pruned & ~existing)
    return whole & _marks(solver in _SOLVERS for solver in solvers)


def _marks(answers: Iterable[bool]) -> Marks:
    return np.fromiter(answers, np.bool_)


def _numbers(values: Sequence[Any]) -> Floats:
    """Return an array of numbers, with NaN for None and infinity for values that are not numbers."""
    if not set(map(type, values)) <= {float, int, type(None)}:
        values = [value if isinstance(value, float | int | None) else np.inf for value in values]
    return np.array(values, dtype=np.float64)


def _have_numbers(numbers: Mapping[str, Floats], relaxed: Marks) -> Marks:
    """Tell which rows of orbits have all numbers, with possible values; relaxation gives no error bounds."""
    bare = relaxed & np.all([np.isnan(numbers[name]) for name in _BOUNDS], axis=0)
    bounded = np.all([np.isfinite(numbers[name]) & (numbers[name] >= 0) for name in _BOUNDS], axis=0)
    sound = [np.isfinite(values) for name, values in numbers.items() if name not in _BOUNDS]
    positive = [numbers[name] > 0 for name in ("length", "lyapunov")]
    return np.all([bare | bounded, *sound, *positive, numbers["residual"] >= 0], axis=0)


def _have_places(blobs: Sequence[Any], p: int) -> Marks:
    """Tell which BLOBs contain p possible coordinates."""
    found = _marks(isinstance(blob, bytes) and len(blob) == 8 * p for blob in blobs)
    kept = b"".join(blobs[i] for i in np.flatnonzero(found).tolist())
    places = np.frombuffer(kept, dtype="<f8").reshape(-1, p)
    found[found] = (np.abs(places) < _FAR).all(axis=1)
    return found


def is_written(word: str, p: int) -> bool:
    """Tell whether a text is a word of period p."""
    return len(word) == p and _WORD.fullmatch(word) is not None


def sound_words(words: Sequence[str], p: int) -> Places:
    """Return the indices of the words that are admissible, primitive, and of period p."""
    all_written = set(map(len, words)) == {p} and _WORD.fullmatch("".join(words))
    written = [i for i, word in enumerate(words) if all_written or is_written(word, p)]
    if not written:
        return np.zeros(0, dtype=np.intp)
    symbols = from_strings([words[i] for i in written])
    return np.array(written, np.intp)[(rules_broken(symbols) == 0) & are_primitive(symbols)]


def need_words(words: Sequence[str], orders: Sequence[int]) -> None:
    """Raise `StoreError`, with the first invalid text, unless every text is a word of its period."""
    if list(map(len, words)) == list(orders) and _WORD.fullmatch("".join(words) or "0"):
        return
    wrong = next(word for word, p in zip(words, orders, strict=True) if not is_written(word, p))
    raise unsound("not a word:", wrong)


def coordinates_of(blobs: Sequence[bytes], p: int) -> Floats:
    """Return the coordinates in BLOBs, shape (N, p).

    Raises `StoreError` unless each BLOB contains p possible coordinates.
    """
    for blob in blobs:
        if len(blob) != 8 * p:
            raise unsound(f"coordinates of {p} bounces with a wrong size in bytes:", len(blob))
    places = np.frombuffer(b"".join(blobs), dtype="<f8").reshape(-1, p)
    if not (np.abs(places) < _FAR).all():
        raise unsound("impossible coordinates of an orbit of period", p)
    return places


def read_rules(text: str | None) -> list[int]:
    """Return the rules listed in the column ``rules``; raise `StoreError` if it contains anything else."""
    parts = text.split(",") if text else []
    if not all(part in _RULES for part in parts):
        raise unsound("rules", text)
    return [int(part) for part in parts]


def stabiliser_of(symmetry: str) -> int:
    """Return the stabiliser with a given symmetry label; raise `StoreError` if there is none."""
    if symmetry not in STABILISER_OF:
        raise unsound("not a symmetry:", symmetry)
    return STABILISER_OF[symmetry]
