"""The least words of the symmetry classes, about an eighth of all words.

A word is the least of its class if none of its images under the eight elements, in any rotation, is less.
Words are enumerated as in `orbitdb.symbols.enumeration`, and left as soon as the mirror image x of their
beginning is less; the others, some five for each class, are compared with one image after the other.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.counting import automaton
from orbitdb.symbols.enumeration import Span, prefixes
from orbitdb.symbols.symmetry import SIZES, mirrored, packed_images
from orbitdb.symbols.words import BITS, least_rotations, unpack

Integers = NDArray[np.int64]

_LAST_SYMBOLS = 5
"""Symbols that a prefix leaves open when a period is cut into spans: some hundred words a prefix."""

_CLASSES = {0o0103: 100, 0o0110: 40, 0o0112: 75, 0o0120: 45, 0o0200: 13, 0o10000: 2}
"""That a prefix goes on to, about, if its first four symbols are below a number."""


class LeastWords(NamedTuple):
    """Classes by their least words."""

    codes: Integers  # the packed words, shape (N,)
    stabiliser: NDArray[np.uint8]  # bit g is set where element g maps the cyclic word to itself


def least_words(span: Span) -> Iterator[LeastWords]:
    """Generate the least words of the symmetry classes of admissible words in a span, in order.

    Parameters
    ----------
    span : Span

    Yields
    ------
    LeastWords
        A few times `orbitdb.symbols.enumeration.CHUNK` at most, so that memory is bounded.
    """
    for codes, lyndon, states in _prefixes(span, span.p):
        whole = np.flatnonzero((lyndon == span.p) & (codes > span.after))
        codes = codes[whole]
        codes = codes[_closes(codes, states[whole], span.p)]
        left, stabiliser = np.arange(len(codes)), np.ones(len(codes), dtype=np.uint8)
        for g, images in enumerate(packed_images(codes, span.p)[1:], 1):
            own, image = codes[left], least_rotations(images[left], span.p)
            stabiliser[left] |= (image == own) << np.uint8(g)
            left = left[image >= own]
        if len(left):
            yield LeastWords(codes[left], stabiliser[left])


def all_least_words(span: Span) -> LeastWords:
    """Return all of them at once."""
    none = LeastWords(np.zeros(0, np.int64), np.zeros(0, np.uint8))
    return LeastWords(*map(np.concatenate, zip(none, *least_words(span), strict=True)))


def representatives(p: int) -> tuple[NDArray[np.uint8], Integers]:
    """Return the admissible classes of order p: least words, shape (N, p), and class sizes, shape (N,)."""
    found = all_least_words(Span.whole(p))
    return unpack(found.codes, p), SIZES[found.stabiliser]


def class_spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut the order of words so that each span has about ``size`` least words of classes, but the last.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    size : int
    after : int, optional
        Begin behind this packed word.

    Yields
    ------
    Span
        In order, one behind the other; the last one ends with the last word.
    """
    whole, length = Span.whole(p, after), p - _LAST_SYMBOLS
    below, classes = list(_CLASSES), list(_CLASSES.values())
    start, held = after, 0
    for codes, *_ in _prefixes(whole, length) if length > 0 else ():
        kinds = np.searchsorted(below, codes * 8.0 ** (4 - length), side="right")
        befores = (codes << BITS * _LAST_SYMBOLS) - 1
        for before, kind in zip(befores.tolist(), kinds.tolist(), strict=True):
            if held >= size and before > start:
                yield Span(p, start, before)
                start, held = before, 0
            held += classes[kind]
    yield Span(p, start, whole.upto)


def _prefixes(span: Span, length: int) -> Iterator[tuple[Integers, Integers, NDArray[np.int8]]]:
    """Generate the prefixes that least words of a span may begin with: the first symbol is 0 or 1."""
    below = span._replace(upto=min(span.upto, 2 << BITS * (span.p - 1)))
    return prefixes(below, length, automaton()[1], lambda codes: codes <= mirrored(codes))


def _closes(codes: NDArray[np.int64], states: NDArray[np.int8], p: int) -> NDArray[np.intp]:
    """Return the places of packed words, which lead to some states, that the rules allow as cycles, too."""
    kept, table = automaton()
    rooted = np.array([state.left is not None for state in kept])  # 02 is not, and rule 3 forbids it
    state = states.astype(np.intp)
    alive = rooted[state] if p > 1 else np.zeros(len(state), np.bool_)  # 1, 3, 4 and 5 stay on one side
    places = np.flatnonzero(alive)
    codes, state = codes[places], state[places]
    for place in range(p - 1, -1, -1):
        state = table[state, codes >> BITS * place & 7].astype(np.intp)
        alive = state >= 0
        if not alive.all():
            places, codes, state = places[alive], codes[alive], state[alive]
    return places
