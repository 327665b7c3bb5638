"""The words of classes, in their order, without reading a word: as they are when each is written out."""

import numpy as np
import pytest
from quick import slow_but

from orbitdb.store.reading import fitting_words, period_words
from orbitdb.store.reading.fitting_words import count_images, fitting_images, words_between
from orbitdb.store.reading.period_words import HEAD, expand, keys_of_classes
from orbitdb.symbols.patterns import Factor, Like
from orbitdb.symbols.symmetry import images_of, members
from orbitdb.symbols.words import MAX_KEYED, from_strings, is_primitive, key, least_rotation, pack, word_of

PERIODS = (2, 4, 5, 6, 8, 9, 11, 12, 16, 17, MAX_KEYED)


@pytest.fixture
def tiny(monkeypatch):
    for module, sizes in ((period_words, {"_PIECE": 9, "_BATCH": 3}), (fitting_words, {"_BATCH": 4})):
        for name, size in sizes.items():
            monkeypatch.setattr(module, name, size)


def some_word(rng, p):
    """Return runs with walls between, p symbols in all."""
    while True:
        blocks = []
        while sum(map(len, blocks)) < p:
            run, walls = rng.integers(1, 4), rng.integers(1, 3)
            sense, first = rng.choice(list("13" if run == 1 else "1345")), rng.integers(2)
            blocks.append(str(sense) * run + "0202"[first : first + walls])
        if len("".join(blocks)) == p:
            return "".join(blocks)


def some_classes(p):
    """Return the least words of classes of several sizes."""
    rng = np.random.default_rng(p)
    words = [some_word(rng, p) for _ in range(6)]
    words += [f"{'1' * (p - 1)}3", f"1{'02' * p}"[:p], f"{'1' * (p // 2)}{'3' * (p - p // 2)}"]
    return sorted({min(members(least_rotation(word))) for word in filter(is_primitive, words)})


@pytest.mark.parametrize("p", slow_but([6, 12], PERIODS))
@pytest.mark.usefixtures("tiny")
def test_words_of_classes_are_those_of_each_in_their_order(p):
    least = some_classes(p)
    numbers = np.array([key(word) for word in least], dtype=np.int64)
    told = {word: (place, g) for place, of in enumerate(least) for word, g in members(of).items()}
    words = sorted(told)
    found = expand(numbers, p)
    assert [word_of(each) for each in found.keys(slice(None)).tolist()] == words
    assert [*zip(*(each.tolist() for each in found.told(slice(None))), strict=True)] == [
        told[word] for word in words
    ]
    assert [found.lower(key(word) + more) for word in words for more in (0, 1)] == [
        k + more for k in range(len(words)) for more in (0, 1)
    ]
    heads = [word[:HEAD].ljust(HEAD, "0") for word in words]
    assert [f"{head:0{HEAD}o}" for head in found.heads.tolist()] == sorted(set(heads))
    assert found.head_starts.tolist() == [heads.index(head) for head in sorted(set(heads))]
    of_classes = zip(*(each.tolist() for each in keys_of_classes(numbers, p)), strict=True)
    assert sorted((word_of(each), place) for each, place in of_classes) == [(w, told[w][0]) for w in words]


@pytest.mark.parametrize("p", slow_but([5, 11], PERIODS[::2]))
@pytest.mark.parametrize("patterns", [(), (Factor("13"),), (Like("%1_%"), Factor("3")), (Like("0%", False),)])
@pytest.mark.usefixtures("tiny")
def test_words_that_fit_are_those_of_each(p, patterns):
    least = some_classes(p)
    numbers = np.array([key(word) for word in least], dtype=np.int64)
    masks = fitting_images(numbers, p, patterns)
    images = [[least_rotation(image) for image in images_of(word)] for word in least]
    fits = [[all(each.fits(image) for each in patterns) for image in of_one] for of_one in images]
    assert masks.tolist() == [sum(fit << g for g, fit in enumerate(each)) for each in fits]
    words = sorted(w for of in least for w in members(of) if all(each.fits(w) for each in patterns))
    assert count_images(masks, np.array([len(members(word)) for word in least])) == len(words)
    codes = pack(from_strings(words)).tolist() if words else []
    for first, last in ((0, len(words)), *((k, k + 2) for k in range(0, len(words) - 1, 5)), (1, 1)):
        if last <= len(words):
            assert words_between(numbers, p, masks, first, last).tolist() == codes[first:last]
