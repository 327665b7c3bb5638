"""Make text from other people harmless for terminals and spreadsheets.

In a catalogue that somebody else made, a status or a label can be any text.
"""

from collections.abc import Iterable

_FORMULA = tuple("=+-@＝＋－＠")
"""Characters that begin a formula in a spreadsheet, including the full-width ones."""

_LONGEST, _END = 1000, 300


def printable(text: str) -> str:
    """Return a text on one line, with control characters escaped.

    The result cannot move the cursor, change colours, hide anything, or run from right to left.
    """
    if text.isprintable():
        return text
    return "".join(
        symbol if symbol.isprintable() else symbol.encode("unicode_escape").decode("ascii") for symbol in text
    )


def line(text: str) -> str:
    """Shorten a message to one line that fits on a screen, but keep its end, which may say what to do."""
    shown = printable(text)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - _END]} ... {shown[-_END:]}"


def shortened(text: str, most: int = 40) -> str:
    """Return a text, cut to at most `most` characters."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def several(count: int, one: str, many: str | None = None) -> str:
    """Return a count with its noun, such as ``1 orbit`` or ``2 orbits``."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def cell(value: object) -> object:
    """Return a value as it is written in a cell of a csv or tsv file.

    A text that a spreadsheet would read as a formula gets a leading apostrophe. A list becomes its items
    separated by blanks. Numbers do not change, and None makes an empty cell.
    """
    if isinstance(value, list | tuple):
        return " ".join(str(cell(item)) for item in value)
    if isinstance(value, float):
        return value + 0.0  # -0.0 becomes 0.0
    if not isinstance(value, str):
        return value
    text = printable(value)
    return f"'{text}" if text.startswith(_FORMULA) else text


def guess(name: str, known: Iterable[str]) -> str:
    """Return a question that suggests the known name closest to a wrong one; empty if none is similar."""
    from difflib import get_close_matches  # seldom needed

    return "".join(f"did you mean {meant}? " for meant in get_close_matches(name, list(known), 1))
