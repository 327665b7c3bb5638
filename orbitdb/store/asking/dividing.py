"""Dividing the conditions of a subset: those on classes, on the text of words, and on single words."""

import re
from dataclasses import dataclass, replace

from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.confinement import LONGEST_PATTERN
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import SHARED
from orbitdb.store.file.tokens import Token, meaningful, tokens
from orbitdb.symbols.patterns import Factor, Like, Pattern

_NAMES = ("CODE", "WORD")
_WILDCARDS = {"LIKE": ("%", "_"), "GLOB": ("*", "?")}
"""What stands for any symbols or none, and for one."""


@dataclass(frozen=True)
class Divided:
    """A subset as conditions that SQL decides, and patterns that the packed words must fit.

    The conditions are `of_words` if they may hold for some words of a class and not for others.
    """

    conditions: Selection
    patterns: tuple[Pattern, ...]
    of_words: bool


def divide(selection: Selection) -> Divided:
    """Divide a subset; a `SelectionError` refuses its expression."""
    factors = () if selection.contains is None else (Factor(selection.contains),)
    plain = replace(selection, contains=None)
    if _is_of_classes(plain):
        return Divided(plain, factors, False)
    parts = [(part, _is_of_classes(part)) for part in _parts_of(plain)]
    patterns = [_pattern(part) for part, of_classes in parts if not of_classes]
    known = tuple(pattern for pattern in patterns if pattern is not None)
    if len(known) < len(patterns):
        return Divided(plain, factors, True)
    return Divided(_joined(plain, [part for part, of_classes in parts if of_classes]), factors + known, False)


def _is_of_classes(selection: Selection) -> bool:
    """Tell whether the expression of a subset has one value for all words of a class."""
    if selection.where is None:
        return True
    parameters = dict(selection.parameters)
    free.check(selection.where, parameters)
    return free.same_for_class(selection.where, parameters, SHARED.keys() - {"cycle"})


def _joined(selection: Selection, parts: list[Selection]) -> Selection:
    """Return a subset with some parts of its expression."""
    where = " AND ".join(f"(\n{part.where}\n)" for part in parts) or None
    used = {name: value for part in parts for name, value in part.parameters.items()}
    return replace(selection, where=where, parameters=used)


def _parts_of(selection: Selection) -> list[Selection]:
    """Return a subset for each of the conditions that its expression joins by AND, be it a single one.

    Each has the values that its part uses.
    """
    found, given = [], selection.parameters
    for part in _joined_by_and(selection.where or "") or [selection.where or ""]:
        values = {name: given[name] for name in given.keys() & free.names_in(part)}
        found.append(replace(selection, where=part, parameters=values))
    return found


def _joined_by_and(where: str) -> list[str]:
    """Return the conditions that an expression joins by AND; none where it is not plain that it does."""
    parts, depth = [""], 0
    for token in tokens(where):
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and token.keyword in ("OR", "BETWEEN", "CASE"):
            return []
        if depth == 0 and token.keyword == "AND":
            parts.append("")
        else:
            parts[-1] += token.text
    return parts if depth == 0 and len(parts) > 1 and all(map(str.strip, parts)) else []


def _pattern(part: Selection) -> Like | None:
    """Return what a condition such as ``code NOT LIKE '13%'`` asks for, None if it is another one."""
    found = meaningful(part.where or "")
    wanted = [token.keyword for token in found[1:2]] != ["NOT"]
    if not wanted:
        del found[1]
    if len(found) != 3 or found[0].keyword not in _NAMES or found[1].keyword not in _WILDCARDS:
        return None
    text, (many, one) = _text(found[2], part), _WILDCARDS[found[1].keyword]
    plain = text is not None and re.fullmatch(rf"[0-9{re.escape(many + one)}]*", text) is not None
    if text is None or not plain or len(text) > LONGEST_PATTERN:
        return None
    return Like(text.replace(many, "%").replace(one, "_"), wanted)


def _text(token: Token, part: Selection) -> str | None:
    """Return the text in quotes, or that a name stands for."""
    value = part.parameters.get(token.text[1:]) if token.kind == "value" else None
    return token.text[1:-1] if token.kind == "string" else value if isinstance(value, str) else None
