"""What a subset asks of the classes, and what of the texts of their words, as far as patterns say it."""

import re
from dataclasses import dataclass

from orbitdb.store.asking.confinement import LONGEST_PATTERN
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tokens import Token, meaningful
from orbitdb.store.reading.class_view import class_part, parts_of, same_for_classes
from orbitdb.symbols.patterns import Factor, Like, Pattern

_NAMES = ("CODE", "WORD")
_WILDCARDS = {"LIKE": ("%", "_"), "GLOB": ("*", "?")}
"""What stands for any symbols or none, and for one."""


@dataclass(frozen=True)
class TextParts:
    """A subset as conditions on classes and patterns that words must fit.

    Attributes
    ----------
    classes : Selection
        It takes all words of a class or none.
    patterns : tuple of Pattern
    """

    classes: Selection
    patterns: tuple[Pattern, ...]


def text_parts(selection: Selection) -> TextParts | None:
    """Return the parts of a subset, None if it asks for anything else of single words.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    """
    patterns: list[Pattern] = [] if selection.contains is None else [Factor(selection.contains)]
    if not same_for_classes(selection):
        parts = [part for part in parts_of(selection) if not same_for_classes(part)]
        found = [pattern for part in parts if (pattern := _pattern(part)) is not None]
        if len(found) < len(parts):
            return None
        patterns += found
    return TextParts(class_part(selection), tuple(patterns))


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
