"""Rows as they must be; those of a file that was altered by hand, or made by somebody else, may not."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import EXISTING, NUMBERS, Status
from orbitdb.plaintext import printable
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.symmetry import ELEMENTS
from orbitdb.symbols.words import from_strings, is_primitive

Row = Mapping[str, Any]

_BOUNDS = ("error", "length_error", "lyapunov_error")
_SOLVERS = {"newton", "relaxation"}
_WORD = re.compile("[0-5]+")
_SHOWN = 40
_FAR = 1e7


def unsound(what: str, value: object) -> StoreError:
    """Return the error that tells of a value that no catalogue of this program has."""
    text = printable(str(value))
    shown = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
    return StoreError(f"the catalogue was altered: {what} {shown!r}; 'orbitdb verify' tells what is wrong")


def is_whole(row: Row, p: int) -> bool:
    """Tell whether a row of `orbit` has what its status demands."""
    if row["solver"] not in _SOLVERS:
        return False
    if row["status"] in EXISTING:
        return _has_numbers(row, p)
    empty = all(row[name] is None for name in (*NUMBERS, "coordinates") if name != "margin")
    return empty and (
        row["status"] == Status.UNRESOLVED
        or (row["status"] == Status.DYNAMICAL and row["margin"] is not None)
    )


def _has_numbers(row: Row, p: int) -> bool:
    """Tell whether a row has sound coordinates and numbers; the relaxation knows no error bounds."""
    blob = row["coordinates"]
    bare = row["solver"] == "relaxation" and all(row[name] is None for name in _BOUNDS)
    numbers = [row[name] for name in NUMBERS if not (bare and name in _BOUNDS)]
    if blob is None or len(blob) != 8 * p or any(value is None for value in numbers):
        return False
    sound = bare or min(row[name] for name in _BOUNDS) >= 0
    sound = sound and row["residual"] >= 0 and min(row["length"], row["lyapunov"]) > 0
    places = np.frombuffer(blob, dtype="<f8")
    return bool(sound and np.isfinite(numbers).all() and are_places(places))


def is_written(word: str, p: int) -> bool:
    """Tell whether a text is a word of order p."""
    return len(word) == p and _WORD.fullmatch(word) is not None


def sound_words(words: Sequence[str], p: int) -> NDArray[np.intp]:
    """Return the places of those words that are admissible, primitive, and of order p."""
    written = [i for i, word in enumerate(words) if is_written(word, p)]
    if not written:
        return np.zeros(0, dtype=np.intp)
    fine = rules_broken(from_strings([words[i] for i in written])) == 0
    return np.array(
        [i for i, ok in zip(written, fine, strict=True) if ok and is_primitive(words[i])], np.intp
    )


def need_words(words: Sequence[str], orders: Sequence[int]) -> None:
    """Raise unless all texts are words of their orders.

    Raises
    ------
    StoreError
        With the first that is none.
    """
    if list(map(len, words)) == list(orders) and _WORD.fullmatch("".join(words) or "0"):
        return
    wrong = next(word for word, p in zip(words, orders, strict=True) if not is_written(word, p))
    raise unsound("a word that is none:", wrong)


def need_elements(elements: Iterable[int | None]) -> None:
    """Raise unless all numbers are those of symmetry elements, or None.

    Raises
    ------
    StoreError
        With the first that is none.
    """
    for element in elements:
        if element is not None and element not in ELEMENTS:
            raise unsound("a symmetry element that is none:", element)


def coordinates_of(blobs: Sequence[bytes], p: int) -> NDArray[np.float64]:
    """Return the coordinates that BLOBs hold, shape (N, p).

    Raises
    ------
    StoreError
        If one of them does not hold p coordinates.
    """
    for blob in blobs:
        if len(blob) != 8 * p:
            raise unsound(f"coordinates of {p} bounces in bytes:", len(blob))
    places = np.frombuffer(b"".join(blobs), dtype="<f8").reshape(-1, p)
    if not are_places(places):
        raise unsound("coordinates that no stadium has, of orbits of period", p)
    return places


def are_places(coordinates: NDArray[np.float64]) -> bool:
    """Tell whether coordinates could be in some stadium of `orbitdb.billiard.stadium`."""
    return bool((np.abs(coordinates) < _FAR).all())
