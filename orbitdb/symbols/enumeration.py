"""Enumerate the primitive cyclic words of a period, or only the representatives of symmetry classes.

The words of a period are in the order of their packed codes, which is also the order of their texts. A `Span`
is a stretch of this order. The spans of a period can be enumerated independently, in several processes.

A word is a representative if none of its images under the eight elements, in any rotation, is less than the
word itself. A prefix is dropped as soon as its image under the mirror x is less. About five words remain for
each class; they are compared with their other images one by one.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Indices, Integers, Marks, Masks, Words
from orbitdb.symbols.pruning import automaton
from orbitdb.symbols.symmetry import SIZES, mirrored, packed_images
from orbitdb.symbols.words import BITS, SYMBOLS, least_rotations, unpack

MAX_PERIOD = 20
"""The highest period that can be enumerated; it has more than 10^9 words."""

CHUNK = 1 << 14

_ANY = np.tile(np.arange(6, dtype=np.int8), (6, 1))
"""Transition table without rules: every symbol may follow every other."""


class Span(NamedTuple):
    """The words of period p that come after one packed word, up to and including another."""

    p: int
    after: int  # the packed word after which the span begins; -1 for the first word of the period
    upto: int  # the last packed word of the span

    @classmethod
    def of_period(cls, p: int, after: int = -1) -> "Span":
        """Return the span of all words of period p, or of all that come after a given one."""
        return cls(p, after, (1 << BITS * p) - 1)


def primitive_words(span: Span) -> Iterator[Words]:
    """Generate the primitive cyclic words in a span in order, pruned or not, as least rotations.

    Yields arrays of shape (n, p). To limit the memory, n is at most a few times `CHUNK`.
    """
    for codes, lyndon, _ in prefixes(span, span.p):
        whole = (lyndon == span.p) & (codes > span.after)
        if whole.any():
            yield unpack(codes[whole], span.p)


def prefixes(
    span: Span, length: int, table: NDArray[np.int8] = _ANY, keep: Callable[[Integers], Marks] | None = None
) -> Iterator[tuple[Integers, Integers, NDArray[np.int8]]]:
    """Generate the prefixes of the codes in a span, in order.

    Parameters
    ----------
    length : int
        Number of symbols of a prefix, 1..p.
    table : ndarray of int8, shape (S, 6), optional
        The state that follows each state and symbol, or -1 if that symbol is forbidden. The state of a word's
        first symbol is the symbol itself.
    keep : callable, optional
        Tells which of the given packed prefixes, which may have any length, to extend.

    Yields
    ------
    codes, lyndon : ndarray of int64, shape (n,)
        The packed prefixes, and the lengths of their longest Lyndon prefixes, which are p for primitive
        words.
    states : ndarray of int8, shape (n,)
        The states reached.

    Notes
    -----
    Codes of primitive words are Lyndon words. Their prefixes are extended by one symbol at a time, thousands
    at once, by the rule of Fredricksen, Kessler and Maiorana: if the longest Lyndon prefix of a prefix has m
    symbols, the next symbol must not be less than the symbol m positions before it.
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
"""Number of final symbols left open when a period is cut into spans; a prefix has a few hundred words."""

_CLASSES = {0o0103: 100, 0o0110: 40, 0o0112: 75, 0o0120: 45, 0o0200: 13, 0o10000: 2}
"""Approximate number of representatives per prefix, keyed by an upper bound on its first four symbols."""


class LeastWords(NamedTuple):
    """Symmetry classes, given by their representatives, as arrays of shape (N,)."""

    codes: Integers  # the packed representatives
    stabiliser: Masks  # bit g is set if element g maps the cyclic word to itself


def least_words(span: Span) -> Iterator[LeastWords]:
    """Generate the representatives of the admissible symmetry classes in a span, in order.

    To limit the memory, at most a few times `CHUNK` are yielded at once.
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
    """Return the representatives in a span as a single batch."""
    none = LeastWords(np.zeros(0, np.int64), np.zeros(0, np.uint8))
    return LeastWords(*map(np.concatenate, zip(none, *least_words(span), strict=True)))


def representatives(p: int) -> tuple[Words, Integers]:
    """Return the admissible representatives of period p, shape (N, p), and the sizes of their classes."""
    classes = all_least_words(Span.of_period(p))
    return unpack(classes.codes, p), SIZES[classes.stabiliser]


def class_spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut the words of a period after a given packed word into spans of about ``size`` representatives.

    The spans are adjacent and in order, and end at places that do not depend on `after`. The last one ends
    with the last word; it may be shorter, and is empty if no words are left.
    """
    return _spans(p, _ends(p, size), after)


def primitive_spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut the words of a period as `class_spans` does, into spans of at most ``size`` primitive words.

    There may be more if ``size`` is below 6^5, and are usually half as many.
    """
    length, most = p - _LAST_SYMBOLS, len(SYMBOLS) ** _LAST_SYMBOLS
    step = max(size // most, 1)
    parts = prefixes(Span.of_period(p), length) if length > 0 else iter(())
    every = chain.from_iterable((codes << BITS * _LAST_SYMBOLS).tolist() for codes, *_ in parts)
    return _spans(p, (first - 1 for first in islice(every, step, None, step)), after)


def _spans(p: int, ends: Iterable[int], after: int) -> Iterator[Span]:
    """Yield the spans between the places where a period is cut, from a packed word on."""
    start, last = -1, Span.of_period(p).upto
    for end in ends:
        if end > after:
            yield Span(p, max(start, after), end)
        start = end
    yield Span(p, max(start, after), last)


def _ends(p: int, size: int) -> Iterator[int]:
    """Yield the packed words after which a period is cut, in order; the last word is not among them."""
    length, start, held = p - _LAST_SYMBOLS, -1, 0
    below, classes = list(_CLASSES), list(_CLASSES.values())
    for codes, *_ in _prefixes(Span.of_period(p), length) if length > 0 else ():
        kinds = np.searchsorted(below, codes * 8.0 ** (4 - length), side="right")
        befores = (codes << BITS * _LAST_SYMBOLS) - 1
        for before, kind in zip(befores.tolist(), kinds.tolist(), strict=True):
            if held >= size and before > start:
                yield before
                start, held = before, 0
            held += classes[kind]


def _prefixes(span: Span, length: int) -> Iterator[tuple[Integers, Integers, NDArray[np.int8]]]:
    """Generate the prefixes in a span that representatives can have; their first symbol is 0 or 1."""
    below = span._replace(upto=min(span.upto, 2 << BITS * (span.p - 1)))
    return prefixes(below, length, automaton()[1], lambda codes: codes <= mirrored(codes))


def _closes(codes: Integers, states: NDArray[np.int8], p: int) -> Indices:
    """Return the indices of the packed words that obey the rules as cyclic words too, given their states."""
    kept, table = automaton()
    rooted = np.array([state.left is not None for state in kept])  # never for 02, which rule 3 forbids
    state = states.astype(np.intp)
    alive = rooted[state] if p > 1 else np.zeros(len(state), np.bool_)  # one symbol stays on one side
    places = np.flatnonzero(alive)
    codes, state = codes[places], state[places]
    for place in range(p - 1, -1, -1):
        state = table[state, codes >> BITS * place & 7].astype(np.intp)
        alive = state >= 0
        if not alive.all():
            places, codes, state = places[alive], codes[alive], state[alive]
    return places
