"""Enumerate cyclic words: the primitive ones of a period, or the representatives of the symmetry classes.

Words of one period are in the order of their packed codes, which is also that of their texts. A `Span` is a
piece of this order. The pieces of a period can be enumerated independently, by several processes.

A word is a representative if none of its images under the eight elements, in any rotation, is less. A prefix
is dropped as soon as its mirror image x is less. The other words, about five for each class, are compared
with one image after another.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Integers, Marks, Masks, Places, Words
from orbitdb.symbols.pruning import automaton
from orbitdb.symbols.symmetry import SIZES, mirrored, packed_images
from orbitdb.symbols.words import BITS, least_rotations, unpack

MAX_PERIOD = 20
"""The highest period to enumerate, with more than 10^9 words."""

CHUNK = 1 << 14

_ANY = np.tile(np.arange(6, dtype=np.int8), (6, 1))
"""Transitions if every symbol may follow every other."""


class Span(NamedTuple):
    """The words of period p after one packed word and up to another."""

    p: int
    after: int  # the packed word after which the span begins; -1 for the beginning
    upto: int  # its last packed word

    @classmethod
    def whole(cls, p: int, after: int = -1) -> "Span":
        """Return all words of period p, or those after one."""
        return cls(p, after, (1 << BITS * p) - 1)


def primitive_words(p: int) -> Iterator[Words]:
    """Generate all primitive cyclic words of period p, pruned or not, as codes in order.

    Yields arrays of shape (n, p), with n at most a few times `CHUNK`, which bounds the memory.
    """
    for codes, lyndon, _ in prefixes(Span.whole(p), p):
        whole = lyndon == p
        if whole.any():
            yield unpack(codes[whole], p)


def prefixes(
    span: Span, length: int, table: NDArray[np.int8] = _ANY, keep: Callable[[Integers], Marks] | None = None
) -> Iterator[tuple[Integers, Integers, NDArray[np.int8]]]:
    """Generate the prefixes of the codes in a span, in order.

    Parameters
    ----------
    length : int
        Symbols of a prefix, 1..p.
    table : ndarray of int8, shape (S, 6), optional
        The state after each state and symbol, -1 for none; a word begins in the state of its first symbol.
    keep : callable, optional
        Tells which packed prefixes, of any length, to extend.

    Yields
    ------
    codes, lyndon : ndarray of int64, shape (n,)
        The packed prefixes, and the lengths of their longest Lyndon prefixes: p for a primitive word.
    states : ndarray of int8, shape (n,)
        Their states.

    Notes
    -----
    Codes of primitive words are Lyndon words. Their prefixes are extended by one symbol at a time, thousands
    at once, by the rule of Fredricksen, Kessler and Maiorana: a prefix whose longest Lyndon prefix has m
    symbols continues with a symbol not below the one m places back.
    """
    stack = [(1, np.arange(6), np.ones(6, np.int64), np.arange(6, dtype=np.int8))]
    while stack:
        n, codes, lyndon, states = stack.pop()
        rest = BITS * (span.p - n)
        inside = (codes >= span.after >> rest) & (codes <= span.upto >> rest)
        kept = np.flatnonzero(inside if keep is None else inside & keep(codes))
        codes, lyndon, states = codes[kept], lyndon[kept], states[kept]
        if n == length:
            yield codes, lyndon, states
            continue
        for start in reversed(range(0, len(codes), CHUNK)):
            part = slice(start, start + CHUNK)
            back = codes[part] >> BITS * (lyndon[part] - 1) & 7
            after = table[states[part]]
            parent, symbol = np.nonzero((after >= 0) & (np.arange(6) >= back[:, None]))
            longest = np.where(symbol == back[parent], lyndon[part][parent], n + 1)
            stack.append((n + 1, codes[part][parent] << BITS | symbol, longest, after[parent, symbol]))


_LAST_SYMBOLS = 5
"""Symbols left open by a prefix when a period is cut into spans; some hundred words per prefix."""

_CLASSES = {0o0103: 100, 0o0110: 40, 0o0112: 75, 0o0120: 45, 0o0200: 13, 0o10000: 2}
"""Approximate number of representatives per prefix, by an upper bound on its first four symbols."""


class LeastWords(NamedTuple):
    """Symmetry classes, given by their representatives."""

    codes: Integers  # the packed words, shape (N,)
    stabiliser: Masks  # bit g is set if element g maps the cyclic word to itself


def least_words(span: Span) -> Iterator[LeastWords]:
    """Generate the representatives of the admissible symmetry classes in a span, in order.

    At most a few times `CHUNK` at once, which bounds the memory.
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
    """Return all representatives in a span at once."""
    none = LeastWords(np.zeros(0, np.int64), np.zeros(0, np.uint8))
    return LeastWords(*map(np.concatenate, zip(none, *least_words(span), strict=True)))


def representatives(p: int) -> tuple[Words, Integers]:
    """Return the admissible classes of period p: representatives, shape (N, p), and sizes, shape (N,)."""
    found = all_least_words(Span.whole(p))
    return unpack(found.codes, p), SIZES[found.stabiliser]


def class_spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut a period, after a packed word, into spans with about ``size`` representatives each.

    The spans are adjacent and in order. The last one may be shorter; it ends with the last word.
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
    """Generate the possible prefixes of representatives in a span; the first symbol is 0 or 1."""
    below = span._replace(upto=min(span.upto, 2 << BITS * (span.p - 1)))
    return prefixes(below, length, automaton()[1], lambda codes: codes <= mirrored(codes))


def _closes(codes: Integers, states: NDArray[np.int8], p: int) -> Places:
    """Return the places of the packed words that the rules also allow as cycles, given their states."""
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
