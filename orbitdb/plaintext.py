"""Text that others may have written, made harmless for terminals and spreadsheets.

A catalogue from elsewhere holds what its maker put there: a status or a label may be any text.
"""

_FORMULA = tuple("=+-@＝＋－＠")
"""What a spreadsheet takes for the beginning of a formula, in full width, too."""

_LONGEST, _END = 1000, 300


def printable(text: str) -> str:
    """Return a text in one line without control characters, which stand there as escapes.

    So no text moves the cursor of a terminal, colours or hides anything, or runs from right to left.
    """
    if text.isprintable():
        return text
    return "".join(
        symbol if symbol.isprintable() else symbol.encode("unicode_escape").decode("ascii") for symbol in text
    )


def line(text: str) -> str:
    """Return a message as one line that a screen can hold; its end, which may say what to do, stays."""
    shown = printable(text)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - _END]} ... {shown[-_END:]}"


def shortened(text: str, most: int = 40) -> str:
    """Return a text, cut if it has more symbols than `most`."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def several(count: int, one: str, many: str | None = None) -> str:
    """Return a count and what is counted, such as ``1 orbit`` or ``2 orbits``."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def cell(value: object) -> object:
    """Return a value for a cell of a csv or tsv file.

    A text that a spreadsheet would take for a formula gets an apostrophe before it; numbers stay
    numbers, lists become numbers with blanks between, and None stays empty.
    """
    if isinstance(value, list | tuple):
        return " ".join(str(cell(item)) for item in value)
    if not isinstance(value, str):
        return value
    text = printable(value)
    return f"'{text}" if text.startswith(_FORMULA) else text
