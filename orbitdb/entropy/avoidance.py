"""Edge words that avoid a set of patterns, as paths in a graph: the automaton of Aho and Corasick.

A state is the longest end of what has been read that begins a pattern. What is avoided is avoided in the
mirror too, so a word and its mirror image are one state: the *upright* one of the two, whose first letter
with a sign has a positive one, stands for both, and every step notes whether it turns the word over. As
many paths leave a state as words go on from it, so the growth rate is that of the words.

Source: Aho and Corasick, "Efficient string matching", Commun. ACM 18 (1975) 333.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.entropy.windows import LETTERS, MIRROR, SIGN, WAYS, Letters, X, reverse
from orbitdb.equality import ByValue

_NOTHING = np.uint8(255)
_UPRIGHT = np.flatnonzero(SIGN >= 0).astype(np.uint8)

_MOST_WAYS = max(map(len, WAYS.values()))
_WAYS_OF = np.array([len(WAYS[letter]) for letter in LETTERS], dtype=np.uint8)
_PLACE = np.array([[max(WAYS[one].find(two), 0) for two in LETTERS] for one in LETTERS], dtype=np.uint8)
_FOLLOWER = np.array([[LETTERS.index((WAYS[one] * 3)[k]) for k in range(_MOST_WAYS)] for one in LETTERS])
_X_MIRRORED = _PLACE[X, MIRROR[_FOLLOWER[X]]]
"""Where the images of the letters behind X stand."""

_CHUNK = 1 << 18
"""States that are looked at together, for the memory."""


def upright(words: Letters) -> Letters:
    """Return of each edge word, shape (N, L), and its mirror image the one that counts as upright."""
    signs = SIGN[words]
    first = (signs != 0).argmax(axis=1)
    turned = signs[np.arange(len(words)), first] < 0
    return np.where(turned[:, None], MIRROR[words], words)


@dataclass(frozen=True, eq=False)
class Automaton(ByValue):
    """The states and steps of an automaton that looks for patterns; state 0 has read nothing.

    Attributes
    ----------
    first : ndarray of int32, shape (9,)
        The state behind each first letter, times 2, plus 1 where the word is turned over.
    step : ndarray of int32, shape (n, 5)
        The same behind each state and each letter that may follow there, in an order of its own (`move`).
    last : ndarray of uint8, shape (n,)
        The last letter of each upright word; of state 0 none, it says 255.
    found : ndarray of uint8, shape (n,)
        The kinds (bits) of the patterns that a state's word ends with.
    """

    first: NDArray[np.int32]
    step: NDArray[np.int32]
    last: NDArray[np.uint8]
    found: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.last)

    def move(self, state: NDArray[np.intp], letter: Letters) -> NDArray[np.int32]:
        """Return the states behind states other than 0, as `step` has them, with letters that may follow."""
        found: NDArray[np.int32] = self.step[state, _PLACE[self.last[state], letter]]
        return found

    def follow(self, words: Letters) -> NDArray[np.uint8]:
        """Return the kinds of patterns, in either sense of the mirror, that are in each word, shape (N,)."""
        move = self.first[words[:, 0]]
        seen = self.found[move >> 1]
        turned = (move & 1).astype(np.bool_)
        for letter in words.T[1:]:
            move = self.move(move >> 1, np.where(turned, MIRROR[letter], letter))
            turned ^= (move & 1).astype(np.bool_)
            seen |= self.found[move >> 1]
        return seen

    def edges(self, avoided: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the steps, from and to, between states whose words have none of some kinds of patterns."""
        free = (self.found & avoided) == 0
        free[0] = False
        origins, targets = [], []
        for start in range(0, len(self), _CHUNK):
            states = start + np.flatnonzero(free[start : start + _CHUNK]).astype(np.int32)
            target = self.step[states] >> 1
            ways = (np.arange(_MOST_WAYS) < _WAYS_OF[self.last[states]][:, None]) & free[target]
            origins.append(np.repeat(states, ways.sum(axis=1)))
            targets.append(target[ways])
        return np.concatenate(origins), np.concatenate(targets)


def automaton(patterns: list[tuple[Letters, int]]) -> Automaton:
    """Build the automaton of patterns, their mirror images and reversals.

    Parameters
    ----------
    patterns : list of (ndarray of uint8, shape (N, L), int)
        Edge words of one length, and their kind: a power of 2 below 256.
    """
    tree = _Tree.of(patterns)
    size = len(tree.letter)
    step = np.zeros((size, _MOST_WAYS), dtype=np.int32)
    singles, *deeper = tree.levels
    first = np.zeros(len(LETTERS), dtype=np.int32)
    first[MIRROR[tree.letter[singles]]] = 2 * singles + 1
    first[tree.letter[singles]] = 2 * singles
    step[singles] = first[_FOLLOWER[tree.letter[singles]]]
    for children in deeper:
        parent, letter = tree.parent[children], tree.letter[children]
        place = _PLACE[tree.letter[parent], letter]
        fail = step[parent, place]  # what has been read, less its first letter, goes the same way
        mirrored = tree.unsigned[parent] & (letter != X)
        step[parent, place] = 2 * children
        step[parent[mirrored], _X_MIRRORED[place[mirrored]]] = 2 * children[mirrored] + 1
        tree.found[children] |= tree.found[fail >> 1]
        # until they have children of their own, they go where their ends go
        ways, over = step[fail >> 1], fail & 1
        swapped = np.flatnonzero((letter == X) & (over == 1))
        ways[swapped] = ways[swapped][:, _X_MIRRORED]
        step[children] = ways ^ over[:, None]
    return Automaton(first, step, tree.letter, tree.found)


@dataclass(frozen=True)
class _Tree:
    """The beginnings of patterns: for each its parent, its last letter, and the patterns that end there."""

    parent: NDArray[np.int32]
    letter: NDArray[np.uint8]
    unsigned: NDArray[np.bool_]
    found: NDArray[np.uint8]
    levels: list[NDArray[np.int32]]

    @classmethod
    def of(cls, patterns: list[tuple[Letters, int]]) -> "_Tree":
        """Grow the tree one letter at a time, all patterns together, which stand sorted."""
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
        found = np.zeros(size, dtype=np.uint8)
        np.bitwise_or.at(found, node, kinds)
        return cls(
            parent=np.concatenate([np.zeros(1, np.int32), *parents]),
            letter=np.concatenate([np.full(1, _NOTHING), *letters]),
            unsigned=np.concatenate([np.ones(1, np.bool_), *unsigned]),
            found=found,
            levels=levels,
        )


def _sorted(patterns: list[tuple[Letters, int]]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return all patterns upright, run both ways, in order, 255 behind the last letter; and their kinds."""
    # a state knows its last letter at least
    given = [(_UPRIGHT[:, None], 0), *patterns]
    longest = max(words.shape[1] for words, _ in given)
    # letters from 1 on and 0 behind them, so that a beginning comes before what it begins
    words = np.concatenate([
        np.pad(upright(way) + np.uint8(1), ((0, 0), (0, longest - words.shape[1])))
        for words, _ in given for way in (words, reverse(words))
    ])  # fmt: skip
    kinds = np.repeat(
        np.array([kind for _, kind in given], dtype=np.uint8), [2 * len(words) for words, _ in given]
    )
    order = np.lexsort(words.T[::-1])
    return words[order] - np.uint8(1), kinds[order]
