"""Check rows as they are read, because somebody may have altered the file with another program."""

import re
from collections.abc import Sequence

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.errors import AlteredError
from orbitdb.plaintext import printable, shortened
from orbitdb.symbols.pruning import RULES
from orbitdb.symbols.symmetry import STABILISER_OF

_WORD = re.compile("[0-5]+")
_RULES = {str(rule.number) for rule in RULES}
_FAR = 1e7
"""Larger than all coordinates in all stadiums."""


def unsound(what: str, value: object) -> AlteredError:
    """Return the error for a value that cannot occur in a catalogue."""
    text = printable(str(value))
    return AlteredError(f"{what} {shortened(text)!r}")


def is_written(word: str, p: int) -> bool:
    """Tell whether a text is a word of period p."""
    return len(word) == p and _WORD.fullmatch(word) is not None


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
