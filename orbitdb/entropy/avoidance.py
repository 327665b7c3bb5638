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

from orbitdb.entropy.letters import LETTERS, MAY_FOLLOW, MIRROR, SIGN, Letters, X, reverse
from orbitdb.equality import ByValue

_LETTERS = len(LETTERS)
_NOTHING = np.uint8(255)
_UPRIGHT = np.flatnonzero(SIGN >= 0).astype(np.uint8)


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
    step : ndarray of int32, shape (n, 9)
        The state behind each state and letter, times 2, plus 1 where the word is turned over.
    last : ndarray of uint8, shape (n,)
        The last letter of each upright word; of state 0 none, it says 255.
    found : ndarray of uint8, shape (n,)
        The kinds (bits) of the patterns that a state's word ends with.
    """

    step: NDArray[np.int32]
    last: NDArray[np.uint8]
    found: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.last)

    def follow(self, words: Letters) -> NDArray[np.uint8]:
        """Return the kinds of patterns, in either sense of the mirror, that are in each word, shape (N,)."""
        state = np.zeros(len(words), dtype=np.int64)
        turned = np.zeros(len(words), dtype=np.bool_)
        seen = np.zeros(len(words), dtype=np.uint8)
        for letter in words.T:
            move = self.step[state, np.where(turned, MIRROR[letter], letter)]
            state = move >> 1
            turned ^= (move & 1).astype(np.bool_)
            seen |= self.found[state]
        return seen

    def edges(self, avoided: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the steps, from and to, between states whose words have none of some kinds of patterns."""
        free = (self.found & avoided) == 0
        free[0] = False
        states = np.flatnonzero(free)
        target = self.step[states] >> 1
        row, letter = np.nonzero(MAY_FOLLOW[self.last[states]] & free[target])
        return states[row].astype(np.int32), target[row, letter]


def automaton(patterns: list[tuple[Letters, int]]) -> Automaton:
    """Build the automaton of patterns, their mirror images and reversals.

    Parameters
    ----------
    patterns : list of (ndarray of uint8, shape (N, L), int)
        Edge words of one length, and their kind: a power of 2 below 256.
    """
    tree = _Tree.of(patterns)
    size = len(tree.letter)
    step = np.zeros((size, _LETTERS), dtype=np.int32)
    fail = np.zeros(size, dtype=np.int32)
    found = tree.found
    for children in tree.levels:
        parent, letter = tree.parent[children], tree.letter[children]
        # what has been read, less its first letter, goes the same way
        fail[children] = step[parent, letter] if parent[0] else 0
        mirrored = tree.unsigned[parent] & (letter != X)
        step[parent, letter] = 2 * children
        step[parent[mirrored], MIRROR[letter[mirrored]]] = 2 * children[mirrored] + 1
        found[children] |= found[fail[children] >> 1]
        # until they have children of their own, they go where their ends go
        over = (fail[children] & 1)[:, None]
        letters = np.where(over == 1, MIRROR, np.arange(_LETTERS))
        step[children] = step[(fail[children] >> 1)[:, None], letters] ^ over
    return Automaton(step, tree.letter, found)


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
        node, plain = np.zeros(len(words), dtype=np.int32), np.ones(len(words), dtype=np.bool_)
        fresh = np.zeros(len(words), dtype=np.bool_)
        size = 1
        for letter in words.T:
            fresh |= np.append(True, letter[1:] != letter[:-1])
            there = letter != _NOTHING
            new = np.flatnonzero(fresh & there)
            plain &= letter == X
            parents.append(node[new])
            letters.append(letter[new])
            unsigned.append(plain[new])
            levels.append(np.arange(size, size + len(new), dtype=np.int32))
            node = np.where(there, size - 1 + (fresh & there).cumsum(), node).astype(np.int32)
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


def _sorted(patterns: list[tuple[Letters, int]]) -> tuple[Letters, NDArray[np.uint8]]:
    """Return all patterns upright and run both ways, filled up behind, in order; and their kinds."""
    both = [(upright(way), kind) for words, kind in patterns if len(words) for way in (words, reverse(words))]
    both.append((_UPRIGHT[:, None], 0))  # a state knows its last letter at least
    longest = max(words.shape[1] for words, _ in both)
    filled = (
        np.pad(words, ((0, 0), (0, longest - words.shape[1])), constant_values=_NOTHING) for words, _ in both
    )
    words = np.concatenate(list(filled))
    kinds = np.concatenate([np.full(len(words), kind, dtype=np.uint8) for words, kind in both])
    order = np.lexsort(_packed(words))
    return words[order], kinds[order]


def _packed(words: Letters) -> list[NDArray[np.uint64]]:
    """Return words as integers that sort as they do, 16 letters each, the last letters first."""
    codes = []
    for start in range(0, words.shape[1], 16):
        code = np.zeros(len(words), dtype=np.uint64)
        for letter in words.T[start : start + 16]:
            code = code << np.uint64(4) | ((letter + 1) & 15)
        codes.append(code)
    return codes[::-1]
