"""Words: the symbol sequences of the stadium billiard, as strings, arrays and packed integers.

A word is a cyclic sequence of the symbols 0..5 (0 bottom wall, 2 top wall, 1 and 4 left semicircle, 3 and 5
right semicircle). A single word is a ``str`` of digits. Many words of the same period are an ``(N, p)`` array
of ``uint8`` or, if p <= `MAX_PACKED`, N integers that sort in the same order.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from orbitdb.arrays import Integers, Marks, Words
from orbitdb.errors import InputError
from orbitdb.text import shortened

SYMBOLS = "012345"
MAX_ORDER = 1_000_000
MAX_PACKED = 21
MAX_KEYED = 20
"""The highest period whose words have keys."""

BITS = 3

_RUN = re.compile(r"(.{1,8}?)\1{2,}")
_TOKEN = re.compile(r"\s*(?:([0-5]+(?!\s*\^)|[0-5])|(\()|(\))|\^\s*([0-9]+))")


class WordError(InputError):
    """The text is not a word; the message gives the position and the reason."""


def parse(text: str) -> str:
    """Read a word written as digits or in run notation, such as ``1^20 (02)^5 3``.

    Parameters
    ----------
    text : str
        Symbols 0..5; ``^k`` repeats the preceding symbol or bracket k times. Spaces are ignored.

    Returns
    -------
    str
        The word as written, one digit per bounce, not rotated.

    Raises
    ------
    WordError
        If the argument is not a string, is empty, contains any other character, an unmatched bracket or a
        misplaced power, or expands to more than `MAX_ORDER` symbols.
    """
    if not isinstance(text, str):
        raise WordError(f"a code is a string such as '1232131', not {text!r:.40}")
    stack: list[list[str]] = [[]]
    size = 0
    place = len(text) - len(text.lstrip())
    end = len(text.rstrip())
    while place < end:
        token = _TOKEN.match(text, place)
        if token is None:
            raise WordError(_complaint(text, place))
        symbols, opening, closing, power = token.groups()
        if symbols:
            stack[-1].append(symbols)
            size += len(symbols)
        elif opening:
            stack.append([])
        elif closing:
            group = "".join(stack.pop())
            if not stack:
                raise WordError(f"unmatched ')' at position {token.end()} of {shortened(text)!r}")
            if not group:
                raise WordError(f"empty brackets at position {token.end()} of {shortened(text)!r}")
            stack[-1].append(group)
        else:
            where = f"position {text.index('^', place) + 1} of {shortened(text)!r}"
            size += _repeat_last(stack[-1], power, size, where)
        place = token.end()
    if len(stack) > 1:
        raise WordError(f"unmatched '(' in {shortened(text)!r}")
    word = "".join(stack[0])
    if not word:
        raise WordError("the code is empty: write symbols 0 to 5, such as 1232131")
    if len(word) > MAX_ORDER:
        raise WordError(f"the code has {len(word)} symbols, more than {MAX_ORDER}")
    return word


def _repeat_last(terms: list[str], power: str, size: int, where: str) -> int:
    """Repeat the last term in place, and return the number of symbols added."""
    if not terms:
        raise WordError(f"'^' at {where} has nothing before it to repeat")
    count = int(power) if len(power) <= len(str(MAX_ORDER)) else MAX_ORDER + 1
    if count == 0:
        raise WordError(f"'^0' at {where}: repeat at least once")
    growth = (count - 1) * len(terms[-1])
    if size + growth > MAX_ORDER:
        raise WordError(
            f"the power ^{shortened(power)} at {where} makes the code more than {MAX_ORDER} symbols long"
        )
    terms[-1] *= count
    return growth


def _complaint(text: str, place: int) -> str:
    while text[place].isspace():
        place += 1
    bad = text[place]
    if bad == "^":
        return f"'^' at position {place + 1} of {shortened(text)!r} needs a number after it, as in 1^20"
    return f"symbol {bad!r} at position {place + 1} of {shortened(text)!r} is not one of 0 1 2 3 4 5"


def run_notation(word: str) -> str:
    """Return a word with repetitions written as powers, such as ``1^20(02)^5 3``, which `parse` can read.

    Only three or more repetitions of the same group of up to eight symbols become a power. A blank separates
    a power from a digit after it.
    """
    terms: list[str] = []
    place, ends_in_power = 0, False
    while place < len(word):
        power = _RUN.match(word, place)
        unit = power[1] if power else word[place]
        if ends_in_power and len(unit) == 1:
            terms.append(" ")
        count = len(power[0]) // len(unit) if power else 1
        terms.append(unit if count == 1 else f"{unit}^{count}" if len(unit) == 1 else f"({unit})^{count}")
        place, ends_in_power = place + count * len(unit), count > 1
    return "".join(terms)


def least_rotation(word: str) -> str:
    """Return the code of a word: the least of its rotations."""
    start = _least_start(word)
    return word[start:] + word[:start]


def _least_start(word: str) -> int:
    """Return the index at which the least rotation of a word begins.

    The least rotation begins with a run of the least symbol. The word is therefore cut where such runs begin,
    the pieces are replaced by their ranks, and the word of ranks, which is at most half as long, is treated
    in the same way. A piece that is a prefix of another ranks below it, because it is followed by the least
    symbol. A million symbols take at most half a second.
    """
    least = re.escape(min(word))
    first = re.compile(f"(?<!{least}){least}").search(word[-1] + word, 1)
    if first is None:
        return 0  # only one distinct symbol
    start = first.start() - 1
    pieces = re.findall(f"{least}+[^{least}]+", word[start:] + word[:start])
    if len(pieces) == 1:
        return start
    names = {piece: chr(rank) for rank, piece in enumerate(sorted(set(pieces)))}
    before = _least_start("".join(map(names.__getitem__, pieces)))
    return (start + sum(map(len, pieces[:before]))) % len(word)


def primitive_root(word: str) -> str:
    """Return the shortest word that the given word repeats."""
    return word[: (word + word).find(word, 1)]


def is_primitive(word: str) -> bool:
    """Tell whether a word is not a repetition of a shorter word."""
    return len(primitive_root(word)) == len(word)


def are_primitive(words: Words) -> Marks:
    """Tell which words, shape (N, p), are not repetitions of shorter words, shape (N,)."""
    p = words.shape[1]
    primitive = np.ones(len(words), dtype=np.bool_)
    for shift in (n for n in range(1, p) if p % n == 0):
        primitive &= (words != np.roll(words, shift, axis=1)).any(axis=1)
    return primitive


def parse_primitive(text: str) -> str:
    """Read a word as `parse` does, but refuse a repetition of a shorter word.

    Raises
    ------
    WordError
        If the text is not a word, or if it is a repetition; the message then gives the shorter word.
    """
    word = parse(text)
    root = primitive_root(word)
    if root != word:
        times = len(word) // len(root)
        given, once = shortened(word), shortened(root)
        raise WordError(f"{given!r} is {once!r} repeated {times} times: give {once!r}")
    return word


def read_words(
    texts: Iterable[Any], errors: str = "raise", read: Callable[[Any], str] = parse_primitive
) -> list[str]:
    """Read many words, by default primitive ones.

    Parameters
    ----------
    texts : iterable of str
    errors : str, optional
        ``raise`` to refuse them all if some cannot be read, ``skip`` to leave these out.
    read : callable, optional
        Reads one of them, or raises `InputError`.

    Raises
    ------
    WordError
        If some texts cannot be read; the message names all of them by their places, counted from 1, and says
        why the first cannot.
    """
    if errors not in ("raise", "skip"):
        raise InputError(f"errors = {errors!r:.40}: use raise or skip")
    found, wrong = [], dict[int, InputError]()
    for place, text in enumerate(texts, 1):
        try:
            found.append(read(text))
        except InputError as error:
            wrong[place] = error
    if not wrong or errors == "skip":
        return found
    if len(found) + len(wrong) == 1:
        raise wrong[1]
    reasons = [f"word {place}: {error}" for place, error in [*wrong.items()][:_REASONS]]
    others = [*wrong][_REASONS:]
    more = f"; and word{'s' * (len(others) > 1)} {', '.join(map(str, others))}" if others else ""
    raise WordError(
        f"{len(wrong)} of {len(found) + len(wrong)} words cannot be read: {'; '.join(reasons)}{more}"
    )


_REASONS = 5
"""Number of words that cannot be read for which a message says why."""


def contains_cyclic(word: str, pattern: str) -> bool:
    """Tell whether a pattern of consecutive symbols occurs in a cyclic word, which it may wrap around.

    Examples
    --------
    >>> contains_cyclic("0220", "0022"), contains_cyclic("13", "131"), contains_cyclic("0123", "02")
    (True, True, False)
    """
    return pattern in word * (2 + len(pattern) // len(word))


def from_strings(words: Sequence[str]) -> Words:
    """Return words of the same period as an ``(N, p)`` array of symbols."""
    flat = np.frombuffer("".join(words).encode("ascii"), dtype=np.uint8) - np.uint8(ord("0"))
    return flat.reshape(len(words), len(words[0]) if words else 0)


def to_strings(words: Words) -> list[str]:
    """Return the rows of an ``(N, p)`` array of symbols as strings of digits."""
    if len(words) == 0:
        return []
    characters = np.ascontiguousarray(words, dtype=np.uint32) + np.uint32(ord("0"))
    return characters.view(f"U{words.shape[1]}")[:, 0].tolist()


def symbols_before(words: Words) -> Words:
    """Return the symbol before each symbol of words, shape (N, p); `np.roll` takes ten times as long."""
    return np.concatenate([words[:, -1:], words[:, :-1]], axis=1)


def symbols_after(words: Words) -> Words:
    """Return the symbol after each symbol of words, shape (N, p)."""
    return np.concatenate([words[:, 1:], words[:, :1]], axis=1)


def pack(words: Words) -> Integers:
    """Return words of period p <= `MAX_PACKED` as integers, three bits per symbol, the first highest."""
    codes = np.zeros(len(words), dtype=np.int64)
    for symbols in words.T:
        codes <<= BITS
        codes |= symbols
    return codes


def unpack(codes: Integers, p: int) -> Words:
    """Return packed words of period p as an ``(N, p)`` array of symbols."""
    shifts = BITS * np.arange(p - 1, -1, -1, dtype=np.int64)
    return ((codes[:, None] >> shifts) & 7).astype(np.uint8)


def least_rotations(codes: Integers, p: int) -> Integers:
    """Return the least rotation of each packed word of period p."""
    spare = 64 - BITS * p  # number of unused low bits, which do not affect the order
    whole = codes.astype(np.uint64) << np.uint64(spare)
    least, head, tail = whole.copy(), np.empty_like(whole), np.empty_like(whole)
    for shift in range(BITS, BITS * p, BITS):
        np.left_shift(whole, np.uint64(shift), out=head)
        np.right_shift(whole, np.uint64(BITS * p - shift), out=tail)
        np.bitwise_or(head, tail, out=head)
        np.minimum(least, head, out=least)
    return (least >> np.uint64(spare)).astype(np.int64)


def key(word: str) -> int:
    """Return a word of any period up to `MAX_KEYED` as one integer.

    The octal digits of this key are a 1 followed by the symbols. Keys sort by period first, then by word.
    """
    return int("1" + word, 8)


def word_of(key: int) -> str:
    """Return the word with the given key."""
    return f"{key:o}"[1:]


def keys(codes: Integers, p: int) -> Integers:
    """Return the keys of packed words of period p <= `MAX_KEYED`."""
    return codes | np.int64(1 << BITS * p)


def packed(keys: Integers, p: int) -> Integers:
    """Return the packed words of period p with the given keys."""
    return keys ^ np.int64(1 << BITS * p)


def keys_of_period(p: int) -> tuple[int, int]:
    """Return a range of keys, both ends included, that contains all words of period p.

    The ids of classes without a key (`orbitdb.store.tables.LONG`) are above all of them.
    """
    return key("0" * p), key(SYMBOLS[-1] * p)
