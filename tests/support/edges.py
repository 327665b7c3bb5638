"""Convert edge words and windows to text and back, and edge words to codes."""

import numpy as np

from orbitdb.entropy_bounds.windows import IN_RUN, STARTS_LEG, Letters, Windows, letters_of
from orbitdb.symbols.edges import DOWN_LEG, ENDS_LEG, FROM_TOP, LETTERS, MAY_FOLLOW, D
from orbitdb.symbols.words import to_strings

_EDGES = np.full((6, 6), 255, dtype=np.uint8)
for _start, _end, _letter in (
    *(("11", "11", "U"), ("33", "33", "U"), ("44", "44", "D"), ("55", "55", "D")),
    *(("14", "35", "X"), ("35", "14", "X"), ("1435", "2", "a"), ("1435", "0", "b")),
    *(("2", "0", "w"), ("0", "2", "v"), ("2", "1435", "A"), ("0", "1435", "B")),
):
    _EDGES[np.ix_([int(x) for x in _start], [int(y) for y in _end])] = LETTERS.index(_letter)


def text_of(letters: Letters) -> str:
    """Return an edge word as text."""
    return "".join(LETTERS[letter] for letter in letters)


def edge_words(words: np.ndarray) -> Letters:
    """Return the edges of admissible words, shape (N, p); edge i leads from bounce i to the next.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Symbols, cyclic.
    """
    return _EDGES[words, np.roll(words, -1, axis=1)]


def code_of(edges: str) -> str:
    """Return the code of a cyclic edge word, starting with the bounce before its first edge.

    The first run of the code is on the left. An edge word with an odd number of legs ends on the other
    semicircle, so the code contains it twice.
    """
    word = letters_of(edges)
    assert MAY_FOLLOW[word, np.roll(word, -1)].all()
    legs = int(ENDS_LEG[word].sum())
    assert legs
    word = np.tile(word, 1 + legs % 2)
    before = np.roll(word, 1)
    on_run = IN_RUN[word] | STARTS_LEG[word]
    passed = np.cumsum(ENDS_LEG[before]) - ENDS_LEG[before][0]
    downward = (word == D) | (before == D)
    right = passed % 2 == 1
    semicircle = np.where(right, np.where(downward, 5, 3), np.where(downward, 4, 1))
    wall = np.where(np.isin(word, (DOWN_LEG, FROM_TOP)), 2, 0)
    return to_strings(np.where(on_run, semicircle, wall).astype(np.uint8)[None])[0]


def windows_of(*texts: str) -> Windows:
    """Parse windows of equal length, each with a bar at its mark."""
    marks = np.array([text.index("|") for text in texts], dtype=np.intp)
    return Windows(np.array([letters_of(text.replace("|", "")) for text in texts]), marks)


def texts_of(windows: Windows) -> list[str]:
    """Return windows as text with a bar at the mark."""
    marked = zip(map(text_of, windows.letters), windows.mark, strict=True)
    return [f"{text[:mark]}|{text[mark:]}" for text, mark in marked]
