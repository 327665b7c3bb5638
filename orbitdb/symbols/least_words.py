"""The least words of the symmetry classes, about an eighth of all words, without the others.

A word is the least of its class if none of its images under the eight elements, in any rotation, is less.
Prefixes are extended a symbol at a time, thousands at once, as in `orbitdb.symbols.enumeration`, and left as
soon as an image of a part of them is less than their beginning:

* The mirrors keep the order in time. Of all stretches of the image at a prefix's end that are equal to its
  beginning only the longest counts, as for rotations: what follows a shorter one is compared with a symbol
  that is not above the one at the longer one's end. One number for each mirror says how long it is.
* The elements that reverse time are read backwards from each wall to the prefix's beginning, as one integer.

What only shows where a word closes is left to `orbitdb.symbols.symmetry.classify`, which decides about the
words that are left, fewer than two for each class.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.automaton import STRAIGHT_SYMBOLS, automaton
from orbitdb.symbols.enumeration import CHUNK, Span, closes
from orbitdb.symbols.symmetry import SIZES, classify, mirrored
from orbitdb.symbols.words import BITS, unpack

Integers = NDArray[np.int64]

_MIRRORED = np.array([0, 3, 2, 1, 5, 4])
_UPSIDE_DOWN = np.array([[2, 4, 0, 5, 1, 3], [2, 1, 0, 3, 1, 3]])
"""The mirror y of each symbol; the second row is of single bounces."""

_BACK_IN_TIME = np.array([[0, 4, 2, 5, 1, 3], [0, 1, 2, 3, 1, 3]])
"""Time reversal, likewise."""

_BOTH = np.array([2, 1, 0, 3, 4, 5])
"""Mirror y and time reversal: no run changes its sense."""

_STRAIGHT = np.isin(np.arange(8), STRAIGHT_SYMBOLS)

_LAST_SYMBOLS = 5
"""Symbols that a prefix leaves open when a period is cut into spans: some hundred words a prefix."""

_CONTINUATIONS = 4.0
"""Admissible continuations of prefixes for each that is the least word of a class, about."""


class LeastWords(NamedTuple):
    """Classes by their least words.

    Attributes
    ----------
    codes : ndarray of int64, shape (N,)
        The packed words.
    stabiliser : ndarray of uint8, shape (N,)
        Bit g is set where element g maps the cyclic word to itself.
    """

    codes: Integers
    stabiliser: NDArray[np.uint8]


def least_words(span: Span) -> Iterator[LeastWords]:
    """Generate the least words of the symmetry classes of admissible words in a span, in order.

    Parameters
    ----------
    span : Span

    Yields
    ------
    LeastWords
        A few times `CHUNK` at most, so that memory is bounded.
    """
    for prefixes in _prefixes(span, span.p):
        whole = prefixes.rows((prefixes.lyndon == span.p) & (prefixes.codes > span.after))
        whole = whole.rows(closes(whole.codes, whole.states, span.p))
        whole = whole.rows(_no_image_less(whole, span.p))
        if len(whole.codes):
            classes = classify(whole.codes, span.p)
            least = classes.representative == whole.codes
            if least.any():
                yield LeastWords(whole.codes[least], classes.stabiliser[least])


def all_least_words(span: Span) -> LeastWords:
    """Return all of them at once."""
    none = LeastWords(np.zeros(0, np.int64), np.zeros(0, np.uint8))
    return LeastWords(*map(np.concatenate, zip(none, *least_words(span), strict=True)))


def representatives(p: int) -> tuple[NDArray[np.uint8], Integers]:
    """Return the admissible classes of order p: least words, shape (N, p), and class sizes, shape (N,)."""
    found = all_least_words(Span.whole(p))
    return unpack(found.codes, p), SIZES[found.stabiliser]


def class_spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut the order of words so that each span has about ``size`` least words of classes or less.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    size : int
        Wanted size. What is counted are the admissible words that continue a prefix, of which a part are
        least words; a span of more than so many of them has but one prefix.
    after : int, optional
        Begin behind this packed word.

    Yields
    ------
    Span
        In order, one behind the other; the last one ends with the last word.
    """
    whole = Span.whole(p, after)
    depth, start = p - _LAST_SYMBOLS, after
    if depth < 1:
        yield whole
        return
    _, table = automaton()
    weights = _continuations(table, _LAST_SYMBOLS)
    shift = BITS * _LAST_SYMBOLS
    room = continuations = _CONTINUATIONS * size
    for part in _prefixes(whole, depth):
        for code, weight in zip(part.codes.tolist(), weights[part.states].tolist(), strict=True):
            before = (code << shift) - 1
            if before + (1 << shift) <= after:
                continue  # so that a span cut off before is cut on as if it had not been
            if weight > room and before > start:
                yield Span(p, start, before)
                start, room = before, continuations
            room -= weight
    yield Span(p, start, whole.upto)


def _continuations(table: NDArray[np.int8], symbols: int) -> NDArray[np.int64]:
    """Return how many words of so many symbols may follow each state."""
    steps = np.zeros((len(table), len(table)), dtype=np.int64)
    for state, after in zip(*np.nonzero(table >= 0), strict=True):
        steps[state, table[state, after]] += 1
    counts: NDArray[np.int64] = np.linalg.matrix_power(steps, symbols).sum(axis=1)
    return counts


def _no_image_less(words: "_Prefixes", p: int) -> NDArray[np.bool_]:
    """Tell for which words no image is less that is easily found: it spares most of those with one.

    These are the mirror image x from where it may be less, and the word read backwards from its first wall.
    """
    codes, x = words.codes, words.matches[0]
    last = codes & 7
    single = (last != (codes >> BITS) & 7).astype(np.intp)
    reverse = (_BACK_IN_TIME[single, last] << BITS * (p - 1) | words.backwards[0]) >> BITS
    sound = np.minimum(reverse, mirrored(reverse)) >= codes
    sound |= codes >> BITS * (p - 1) > 0
    return sound & (mirrored(codes) >> BITS * x >= codes & ((1 << BITS * (p - x)) - 1))


class _Prefixes(NamedTuple):
    """N prefixes of n symbols.

    The rows of ``matches`` are of the mirrors x, y and xy: how long a stretch at the end has an image that is
    the prefix's beginning. Those of ``backwards``, packed from the end, are of T and yT. But for x the images
    are without the last symbol: whether a bounce on a semicircle is single shows one symbol later.
    """

    codes: Integers
    lyndon: NDArray[np.int8]
    states: NDArray[np.int8]
    matches: Integers
    backwards: Integers

    def rows(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> "_Prefixes":
        places = np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen
        return _Prefixes._make(column.take(places, axis=-1) for column in self)

    def chunk(self, begin: int) -> "_Prefixes":
        return _Prefixes._make(column[..., begin : begin + CHUNK] for column in self)


def _prefixes(span: Span, length: int) -> Iterator[_Prefixes]:
    """Generate the prefixes of a length that least words of a span may begin with."""
    _, table = automaton()
    walls = np.isin(np.arange(table.shape[1]), STRAIGHT_SYMBOLS)
    yield from _grown(span, length, 0, table)
    yield from _grown(
        span, length, 1, np.where(walls, np.int8(-1), table)
    )  # with a wall, an image begins with 0


def _grown(span: Span, length: int, first: int, table: NDArray[np.int8]) -> Iterator[_Prefixes]:
    """Generate those that begin with one symbol."""
    one = np.full(1, first)
    matches, backwards = np.zeros((3, 1), dtype=np.int64), np.zeros((2, 1), dtype=np.int64)
    matches[0] = first == 0
    stack = [(1, _Prefixes(one, np.ones(1, np.int8), one.astype(np.int8), matches, backwards))]
    while stack:
        n, prefixes = stack.pop()
        rest = BITS * (span.p - n)
        inside = (prefixes.codes >= span.after >> rest) & (prefixes.codes <= span.upto >> rest)
        if not inside.all():
            prefixes = prefixes.rows(inside)
        if n == length:
            yield prefixes
        elif len(prefixes.codes) > CHUNK:
            starts = range(0, len(prefixes.codes), CHUNK)
            stack += [(n, prefixes.chunk(begin)) for begin in reversed(starts)]
        elif len(prefixes.codes):
            stack.append((n + 1, _extend(prefixes, n, table)))


def _extend(prefixes: _Prefixes, n: int, table: NDArray[np.int8]) -> _Prefixes:
    """Return all prefixes of n + 1 symbols that grow from those of n symbols, in order."""
    codes, lyndon, states = prefixes[:3]
    back = (codes >> (BITS * (lyndon.astype(np.int64) - 1))) & 7
    after = table[states]
    parent, symbol = np.nonzero((after >= 0) & (np.arange(6) >= back[:, None]))
    longer = codes[parent] << BITS | symbol
    grown = np.where(symbol == back[parent], lyndon[parent], np.int8(n + 1))
    found = _Prefixes(
        longer,
        grown,
        after[parent, symbol],
        prefixes.matches.take(parent, axis=1),
        prefixes.backwards.take(parent, axis=1),
    )
    if len(codes) and codes[0] >> BITS * (n - 1):  # few words have no wall: let `classify` compare them
        return found
    return found.rows(_compare(found, n))


def _compare(prefixes: _Prefixes, n: int) -> NDArray[np.intp]:
    """Take the last symbol of prefixes of n + 1 into their images; return which are not above an image."""
    codes, _, _, matches, backwards = prefixes
    symbol, last = codes & 7, (codes >> BITS) & 7
    single = ((symbol != last) & (last != (codes >> 2 * BITS) & 7)).astype(np.intp)
    down = _UPSIDE_DOWN[single, last]
    keep = np.ones(len(codes), dtype=bool)
    for match, image in zip(matches, (_MIRRORED[symbol], down, _MIRRORED[down]), strict=True):
        against = (codes >> BITS * (n - match)) & 7
        keep &= image >= against
        match += 1
        match *= image == against
    place = BITS * (n - 1)
    backwards |= np.stack([_BACK_IN_TIME[single, last], _BOTH[last]]) << place
    from_here = np.where(symbol == 2, backwards[1], backwards[0])  # behind its wall, whose image is 0
    behind = codes & ((1 << BITS * n) - 1)
    keep &= ~_STRAIGHT[symbol] | (np.minimum(from_here, mirrored(from_here)) >= behind)
    return np.flatnonzero(keep)
