"""Orders of single words by their text or their element, and the places of words in an order."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.asking.confinement import never
from orbitdb.store.file.schema import LONG
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.chosen import ALL, BITS_OF, Chosen, Integers, orders_of
from orbitdb.store.reading.fitting import fitting, long_words, stabilisers_of_classes
from orbitdb.symbols.members import ELEMENT_OF, packed_members, places_of_elements
from orbitdb.symbols.patterns import Like
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import ELEMENTS, class_of, members
from orbitdb.symbols.words import BITS, MAX_KEYED, from_strings, key, pack, packed

if TYPE_CHECKING:
    from orbitdb.store.reading.lives import Standings

_TEXTS = ("code", "word")
_HEAD = 3
"""First symbols of words that are sorted together, so that the order of all is never there at once."""

Texts = NDArray[np.int64]


def in_order_of_words(
    connection: sa.Connection, chosen: Chosen, keys: Mapping[str, bool]
) -> NDArray[np.uint32]:
    """Return the order of the words of a subset.

    Parameters
    ----------
    connection : Connection
        Asked for the words that are too long for a key.
    chosen : Chosen
        In the natural order, with the values of all keys that are of classes.
    keys : mapping of str to bool
        Columns to sort by, at least one of them of single words, and whether they fall.
    """
    arrays: list[NDArray[np.generic]] = []
    for name, falls in keys.items():
        if name in _TEXTS:
            texts, later = _texts(connection, chosen)
            if not arrays and not len(later):
                return _by_text(texts)[:: -1 if falls else 1]
            arrays += [-part if falls else part for part in (texts, later) if len(part)]
            break  # no two words are the same
        if name == "element":
            arrays.append(_elements(connection, chosen, falls))
        else:
            arrays.append(np.repeat(_ranks(chosen.values[name], falls), chosen.counts))
    return np.lexsort(arrays[::-1]).astype(np.uint32)


def _ranks(values: NDArray[np.generic], falling: bool) -> NDArray[np.int64]:
    """Return the places of values among all different ones; none comes last."""
    missing = np.array([value is None or value != value for value in values.tolist()], dtype=np.bool_)
    ranks = np.full(len(values), len(values), dtype=np.int64)
    _, found = np.unique(values[~missing], return_inverse=True)
    ranks[~missing] = -found if falling else found
    return ranks


def _by_text(texts: Texts) -> NDArray[np.uint32]:
    """Return the order of words by their texts, a piece at a time."""
    heads = np.empty(len(texts), dtype=np.int16)
    np.right_shift(texts, BITS * (MAX_KEYED - _HEAD), out=heads, casting="unsafe")
    order = np.empty(len(texts), dtype=np.uint32)
    done = 0
    for head in np.unique(heads).tolist():
        here = np.flatnonzero(heads == head).astype(np.uint32)
        order[done : done + len(here)] = here[np.argsort(texts[here], kind="stable")]
        done += len(here)
    return order


def _texts(connection: sa.Connection, chosen: Chosen) -> tuple[Texts, NDArray[np.int64]]:
    """Return numbers that sort as the texts of words do, and ranks of those that are equal up to there.

    A number holds the first `MAX_KEYED` symbols, each one more than it is, so that a word comes before those
    that it begins.
    """
    orders, ends = orders_of(chosen.ids), chosen.ends
    texts = np.zeros(len(chosen), dtype=np.int64)
    later = np.zeros(len(chosen) if (orders > MAX_KEYED).any() else 0, dtype=np.int64)
    for p in np.unique(orders).tolist():  # in the natural order those of one order are one behind the other
        of_order = np.flatnonzero(orders == p)
        done = int(ends[of_order[0]]) - int(chosen.counts[of_order[0]])
        ids, masks = chosen.ids[of_order], chosen.masks[of_order]
        if p > MAX_KEYED:
            words = _long_words(connection, ids, masks)
            ranks = {word: rank for rank, word in enumerate(sorted(words), 1)}
            texts[done:] = [_text(word) for word in words]
            later[done:] = [ranks[word] for word in words]
            continue
        stabilisers = stabilisers_of_classes(connection, ids, masks == ALL)
        for codes in packed_members(packed(np.abs(ids), p), p, masks, stabilisers):
            texts[done : done + len(codes)] = _raised(codes, p)
            done += len(codes)
    return texts, later


def _raised(codes: NDArray[np.int64], p: int) -> Texts:
    return (codes + int("1" * p, 8)) << BITS * (MAX_KEYED - p)


def _text(word: str) -> int:
    return int(_raised(pack(from_strings([word[:MAX_KEYED]])), min(len(word), MAX_KEYED))[0])


def _long_words(connection: sa.Connection, ids: NDArray[np.int64], masks: NDArray[np.uint8]) -> list[str]:
    found = []
    for number, mask in zip(ids.tolist(), masks.tolist(), strict=True):
        words, _ = long_words(connection, number)
        found += [word for n, word in enumerate(words) if mask >> n & 1]
    return found


def _elements(connection: sa.Connection, chosen: Chosen, falling: bool) -> NDArray[np.int8]:
    """Return what sorts words by the elements that lead to them; pruned words, of none, come last."""
    stabilisers = stabilisers_of_classes(connection, chosen.ids, chosen.masks == ALL)
    elements = ELEMENT_OF.astype(np.int8)[stabilisers] * (-1 if falling else 1)
    elements[chosen.ids < 0] = len(ELEMENTS)
    return elements[BITS_OF[chosen.masks].astype(np.bool_)]


def position_of(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    """Return in which row a word, a least rotation, stands; None if in none."""
    if len(word) > MAX_KEYED:
        return _position_of_long(connection, chosen, word) if (np.abs(chosen.ids) >= LONG).any() else None
    if rules_of(word):
        return chosen.position(-key(word), 0)
    least = class_of(word).representative
    return chosen.position(key(least), list(members(least)).index(word))


def _position_of_long(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    p = len(word)
    known = sa.select(cycle.c.id, cycle.c.words).where(cycle.c.id >= LONG, cycle.c.p == p)
    queries = (
        known.where(sa.func.instr(cycle.c.words, word) > 0),
        sa.select(pruned.c.id, pruned.c.word).where(pruned.c.p == p, pruned.c.word == word),
    )
    for number, words in (row for query in queries for row in connection.execute(query)):
        for place in range(len(words) // p):
            if words.startswith(word, place * p):
                return chosen.position(number, place)
    return None


def periods_of(connection: sa.Connection, ids: Integers) -> Integers:
    """Return the periods of classes and pruned words, shape (C,)."""
    found = orders_of(ids)
    if (found > MAX_KEYED).any():
        rows = connection.execute(
            sa.select(cycle.c.id, cycle.c.p)
            .where(cycle.c.id >= LONG)
            .union_all(sa.select(pruned.c.id, pruned.c.p).where(pruned.c.id <= -LONG))
        )
        known = {row.id: row.p for row in rows}
        for place in np.flatnonzero(found > MAX_KEYED).tolist():
            found[place] = known[int(ids[place])]
    return found


def periods_without(connection: sa.Connection, ids: Integers, standings: "Standings") -> list[int]:
    """Return the periods of classes of which no births are stored."""
    return np.unique(periods_of(connection, ids[standings.places == len(standings.cycles)])).tolist()


def first_of_period(connection: sa.Connection, chosen: Chosen, p: int) -> int | None:
    """Return the first row of a period; None if there is none."""
    here = periods_of(connection, chosen.ids) == p
    return chosen.first(np.where(here, 0xFF, 0).astype(np.uint8))


def first_beginning(
    connection: sa.Connection, chosen: Chosen, code: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the first row whose code begins with some symbols; None if there is none.

    Raises
    ------
    CancelledError
        If nobody waits any more.
    """
    elements = fitting(connection, chosen.ids, (Like(f"{code}%", True),), cancelled)
    stabilisers = stabilisers_of_classes(connection, chosen.ids, chosen.masks == ALL)
    return chosen.first(places_of_elements(elements, stabilisers))
