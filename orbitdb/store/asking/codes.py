"""Words in SQL expressions: ``code('1232131')`` finds a word in any rotation.

Rows contain the least rotation of a word. So ``code('...')`` is replaced, before SQLite sees it, by a
condition that SQLite can look up.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise, takewhile

from orbitdb.store.file.ids import LONG
from orbitdb.store.file.tokens import Token, meaningful, tokens
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import (
    MAX_KEYED,
    SYMBOLS,
    WordError,
    key,
    least_rotation,
    parse_primitive,
    primitive_root,
)

_CALL = "CODE"
_NAMED_BY_LEAST_ROTATION = ("CODE", "WORD")
_COMPARING = ("=", "<", ">", "!", "IN", "IS", "LIKE", "GLOB", "BETWEEN")
_EQUAL = {"=", "IN", "(", ","}


def spelled_out(where: str, parameters: Mapping[str, str | int | float]) -> str:
    """Replace every ``code('...')`` in an expression by a condition on class and least rotation.

    The brackets take quoted words or names (``:name``) of parameters, separated by commas; the condition is
    true for each of these words. Raises `ValueError` if the brackets contain anything else, or if the
    condition is compared with a value.
    """
    found = tokens(where)
    solid = [place for place, token in enumerate(found) if token.kind != "blank"]
    said = [found[place] for place in solid]
    parts, done = [], 0
    for rank, (token, opening) in enumerate(pairwise(said)):
        place = solid[rank]
        if place < done or token.keyword != _CALL or opening.text != "(":
            continue
        closing = next((k for k in range(rank + 2, len(said)) if said[k].text == ")"), None)
        if closing is None:
            break  # SQLite will say what is missing
        _check_alone(said[max(rank - 1, 0) : rank] + said[closing + 1 : closing + 2])
        parts += [token.text for token in found[done:place]]
        parts.append(_condition(said[rank + 2 : closing], parameters))
        done = solid[closing] + 1
    return "".join([*parts, *(token.text for token in found[done:])])


def _check_alone(beside: Sequence[Token]) -> None:
    """Raise `ValueError` if ``code(...)``, which is true or false by itself, is compared with a value."""
    if any(token.text in _COMPARING or token.keyword in _COMPARING for token in beside):
        raise ValueError("code('...') is a condition by itself: write it without a comparison")


def _condition(inner: Sequence[Token], parameters: Mapping[str, str | int | float]) -> str:
    words = [_word(token, parameters) for token in inner[::2]]
    if not words or len(inner) != 2 * len(words) - 1 or any(token.text != "," for token in inner[1::2]):
        raise ValueError("code() takes words in quotes with commas between, such as code('1232131')")
    listed = ", ".join(f"'{word}'" for word in words)
    classes = " OR ".join(f"cycle {number}" for number in _classes(words))
    return f"(({classes}) AND code IN ({listed}))"


def _classes(words: Sequence[str]) -> list[str]:
    """Return conditions on the class ids of the words, which SQLite can look up directly."""
    kinds = [(len(word) > MAX_KEYED, bool(rules_of(word))) for word in words]
    short = [word for word, kind in zip(words, kinds, strict=True) if kind == (False, False)]
    numbers = sorted({key(class_of(word).representative) for word in short})
    found = [f"IN ({', '.join(map(str, numbers))})"] if numbers else []
    found += [f">= {LONG}"] if (True, False) in kinds else []
    return found + (["IS NULL"] if any(pruned for _, pruned in kinds) else [])


def _word(token: Token, parameters: Mapping[str, str | int | float]) -> str:
    """Return the least rotation of a word given in quotes or by the name of a parameter."""
    if token.kind == "value" and token.text[1:] not in parameters:
        raise ValueError(f"binding {token.text} has no value")
    given = parameters[token.text[1:]] if token.kind == "value" else token.text[1:-1]
    if token.kind not in ("string", "value"):
        raise ValueError(f"code({token.text}): write the word in quotes, as in code('1232131')")
    try:
        return least_rotation(parse_primitive(str(given)))
    except WordError as error:
        raise ValueError(f"code(): {error}") from error


def hint(where: str) -> str | None:
    """Return a hint if an expression compares a code with a word that is not a least rotation, else None."""
    found = meaningful(where)
    for place, (column, sign) in enumerate(pairwise(found)):
        if column.keyword not in _NAMED_BY_LEAST_ROTATION or sign.text == "(":
            continue
        beside = takewhile(
            lambda each: each.kind == "string" or each.text.upper() in _EQUAL, found[place + 1 :]
        )
        for word in (each.text[1:-1] for each in beside if each.kind == "string"):
            if word and set(word) <= set(SYMBOLS) and least_rotation(root := primitive_root(word)) != word:
                return (
                    f"no row has {column.text} = '{word}', as codes are least rotations: write code('{root}')"
                )
    return None
