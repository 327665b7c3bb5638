"""Growth rates of the edge words that avoid a set of patterns: an automaton, and bounds on its paths.

The words are paths in the graph of an Aho-Corasick automaton.

A state is the longest suffix of the letters read so far that is a prefix of a pattern. The mirror image of an
avoided pattern is avoided too, so a word and its mirror image share a state. It is represented by the
*upright* one of the two, whose first letter with a sign is positive, and every step records whether it
mirrors the word. A path can be continued in as many ways as a word, so paths and words have the same growth
rate.

The growth rate of paths in a graph is bounded after Collatz and Wielandt, rounded outward. For the matrix A
of steps within strongly connected components and any v > 0,

    max over components of min (Av)_i / v_i  <=  spectral radius  <=  max (Av)_i / v_i .

Power iteration provides v.

Sources: Aho and Corasick, Commun. ACM 18 (1975) 333; Collatz, Math. Z. 48 (1942) 221; Wielandt, Math. Z. 52
(1950) 642.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Indices, Marks, Masks
from orbitdb.entropy_bounds.windows import MIRROR, SIGN, Letters, reverse
from orbitdb.symbols.edges import LETTERS, MAY_FOLLOW, X

if TYPE_CHECKING:
    from scipy.sparse import csr_array  # slow to import


_NOTHING = np.uint8(255)
_UPRIGHT = np.flatnonzero(SIGN >= 0).astype(np.uint8)

_CHUNK = 1 << 18
"""Number of states treated at a time, which limits the memory."""


def upright(words: Letters) -> Letters:
    """Return each edge word, shape (N, L), or its mirror image: whichever of the two is upright."""
    signs = SIGN[words]
    first = (signs != 0).argmax(axis=1)
    turned = signs[np.arange(len(words)), first] < 0
    return np.where(turned[:, None], MIRROR[words], words)


@dataclass(frozen=True, eq=False)
class Automaton:
    """The states and steps of an automaton that searches for patterns; in state 0 it has read nothing."""

    # twice the state after each first letter, plus 1 if the word is mirrored, shape (9,)
    first: NDArray[np.int32]
    # the same after each state and letter, shape (n, 9); meaningless if the letter may not follow
    step: NDArray[np.int32]
    last: Letters  # the last letter of the upright word of each state, shape (n,); 255 for state 0
    matches: Masks  # the kinds (bits) of the patterns with which the word of each state ends, shape (n,)

    def __len__(self) -> int:
        return len(self.last)

    def patterns_in(self, words: Letters) -> Masks:
        """Return the kinds of the patterns that each word contains, mirrored or not, shape (N,)."""
        move = self.first[words[:, 0]]
        seen = self.matches[move >> 1]
        turned = (move & 1).astype(np.bool_)
        for letter in words.T[1:]:
            move = self.step[move >> 1, np.where(turned, MIRROR[letter], letter)]
            turned ^= (move & 1).astype(np.bool_)
            seen |= self.matches[move >> 1]
        return seen

    def edges(self, avoided: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the steps that avoid patterns of the given kinds (bits), as origins and targets."""
        free = (self.matches & avoided) == 0
        free[0] = False
        origins, targets = [], []
        for start in range(0, len(self), _CHUNK):
            states = start + np.flatnonzero(free[start : start + _CHUNK]).astype(np.int32)
            target = self.step[states] >> 1
            ways = MAY_FOLLOW[self.last[states]] & free[target]
            origins.append(np.repeat(states, ways.sum(axis=1)))
            targets.append(target[ways])
        return np.concatenate(origins), np.concatenate(targets)


def automaton(patterns: list[tuple[Letters, int]]) -> Automaton:
    """Build the automaton that finds the given patterns, their mirror images and their reversals.

    Each item contains edge words of equal length, shape (N, L), and their kind, a power of 2 below 256.
    """
    tree = _Tree.of(patterns)
    size = len(tree.letter)
    step = np.zeros((size, len(LETTERS)), dtype=np.int32)
    singles, *deeper = tree.levels
    first = np.zeros(len(LETTERS), dtype=np.int32)
    first[MIRROR[tree.letter[singles]]] = 2 * singles + 1
    first[tree.letter[singles]] = 2 * singles
    step[singles] = first
    for children in deeper:
        parent, letter = tree.parent[children], tree.letter[children]
        fail = step[parent, letter]  # the state of the word without its first letter
        mirrored = tree.unsigned[parent] & (letter != X)
        step[parent, letter] = 2 * children
        step[parent[mirrored], MIRROR[letter[mirrored]]] = 2 * children[mirrored] + 1
        tree.matches[children] |= tree.matches[fail >> 1]
        # as long as a state has no children, it takes the steps of its longest proper suffix
        ways, over = step[fail >> 1], fail & 1 == 1
        ways[over] = ways[over][:, MIRROR] ^ 1
        step[children] = ways
    return Automaton(first, step, tree.letter, tree.matches)


@dataclass(frozen=True)
class _Tree:
    """The prefixes of patterns as a tree, with the parent, last letter and ending patterns of each prefix."""

    parent: NDArray[np.int32]
    letter: Letters
    unsigned: Marks
    matches: Masks
    levels: list[NDArray[np.int32]]

    @classmethod
    def of(cls, patterns: list[tuple[Letters, int]]) -> "_Tree":
        """Build the tree of sorted patterns, one letter at a time for all patterns together."""
        words, kinds = _sorted(patterns)
        parents, letters, unsigned, levels = [], [], [], []
        node, plain = np.zeros(len(kinds), dtype=np.int32), np.ones(len(kinds), dtype=np.bool_)
        fresh = np.zeros(len(kinds), dtype=np.bool_)
        size = 1
        for letter in words.T:
            fresh |= np.append(True, letter[1:] != letter[:-1])
            there = letter != _NOTHING
            new = np.flatnonzero(fresh & there)
            if not len(new):
                break
            plain &= letter == X
            parents.append(node[new])
            letters.append(letter[new])
            unsigned.append(plain[new])
            levels.append(np.arange(size, size + len(new), dtype=np.int32))
            node = np.where(there, size - 1 + (fresh & there).cumsum(dtype=np.int32), node)
            size += len(new)
        matches = np.zeros(size, dtype=np.uint8)
        np.bitwise_or.at(matches, node, kinds)
        return cls(
            parent=np.concatenate([np.zeros(1, np.int32), *parents]),
            letter=np.concatenate([np.full(1, _NOTHING), *letters]),
            unsigned=np.concatenate([np.ones(1, np.bool_), *unsigned]),
            matches=matches,
            levels=levels,
        )


def _sorted(patterns: list[tuple[Letters, int]]) -> tuple[Letters, Masks]:
    """Return all patterns and their reversals, upright, padded with 255 and sorted, and also their kinds."""
    # every state must know its last letter, so single letters are added as patterns without a kind
    given = [(_UPRIGHT[:, None], 0), *patterns]
    longest = max(words.shape[1] for words, _ in given)
    # letters count from 1 and are padded with 0, so that a prefix sorts before its continuations
    words = np.concatenate([
        np.pad(upright(way) + np.uint8(1), ((0, 0), (0, longest - words.shape[1])))
        for words, _ in given for way in (words, reverse(words))
    ])  # fmt: skip
    kinds = np.repeat(
        np.array([kind for _, kind in given], dtype=np.uint8), [2 * len(words) for words, _ in given]
    )
    order = np.lexsort(words.T[::-1])
    return words[order] - np.uint8(1), kinds[order]


TOLERANCE = 1e-10
"""Relative width of the enclosure at which the power iteration stops."""

MAX_STEPS = 4000

_ROUNDING = 2.0**-48
"""Bound on the rounding errors of a row of at most 9 steps, of the quotient and of the logarithm.

The sum and the quotient lose 10 half units; the logarithm (below 4) and its printed digits lose 2 units.
"""

_SHIFT = 0.5
"""Added to the diagonal in the power iteration, so that periodic components do not oscillate."""

_LEAST = 1e-280
"""Lower limit on the entries of v, which keeps them positive."""


@dataclass(frozen=True)
class Growth:
    """Bounds on the logarithm of a growth rate; both are -inf if the graph has no cycle."""

    lower: float
    upper: float


def growth(origin: NDArray[np.int32], target: NDArray[np.int32], states: int) -> Growth:
    """Enclose the growth rate of the paths in a graph.

    Parameters
    ----------
    origin, target : ndarray of int32, shape (E,)
        The states that each step connects, with at most 9 steps from each state. Two steps between the same
        states count as two.
    states : int
        Number of states.
    """
    matrix, first = _components(origin, target, states)
    if not len(first):
        return Growth(-math.inf, -math.inf)
    sizes = np.diff(first, append=matrix.shape[0])
    v = np.ones(matrix.shape[0])
    lower, upper = 0.0, math.inf
    for _ in range(MAX_STEPS):
        image = matrix @ v
        ratio = image / v
        lower = max(lower, float(np.minimum.reduceat(ratio, first).max()))
        upper = min(upper, float(ratio.max()))
        if upper - lower <= TOLERANCE * lower:
            break
        image += _SHIFT * v
        v = np.maximum(image / np.repeat(np.maximum.reduceat(image, first), sizes), _LEAST)
    return Growth(
        math.log(lower * (1 - _ROUNDING)) - _ROUNDING, math.log(upper * (1 + _ROUNDING)) + _ROUNDING
    )


def _components(
    origin: NDArray[np.int32], target: NDArray[np.int32], states: int
) -> tuple["csr_array", Indices]:
    """Return the matrix of all strongly connected components with a cycle, and the first row of each."""
    from scipy.sparse.csgraph import connected_components

    _, label = connected_components(_matrix(origin, target, states), connection="strong")
    inside = label[origin] == label[target]
    origin, target = origin[inside], target[inside]
    cyclic = np.zeros(states, dtype=np.bool_)
    cyclic[origin] = True  # every state of a component with a cycle has a step inside the component
    kept = np.flatnonzero(cyclic)
    kept = kept[np.argsort(label[kept], kind="stable")]
    place = np.empty(len(label), dtype=np.int32)
    place[kept] = np.arange(len(kept), dtype=np.int32)
    first = np.flatnonzero(np.diff(label[kept], prepend=-1))
    return _matrix(place[origin], place[target], len(kept)), first


def _matrix(origin: NDArray[np.int32], target: NDArray[np.int32], states: int) -> "csr_array":
    from scipy.sparse import csr_array

    return csr_array((np.ones(len(origin)), (origin, target)), shape=(states, states))
