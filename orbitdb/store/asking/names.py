"""Names of columns, as they are asked for."""

from collections.abc import Sequence

from orbitdb.store.asking.selection import SelectionError


def parse_names(text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Read some of the known names of columns, with commas between.

    Raises
    ------
    SelectionError
        If one of them is not there, or is named twice.
    """
    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in known:
            raise unknown(name, known)
    if len(set(names)) < len(names):
        twice = next(name for place, name in enumerate(names) if name in names[:place])
        raise SelectionError(f"column {twice!r} is named twice")
    return names


def unknown(name: str, known: Sequence[str]) -> SelectionError:
    """Return the error that tells of a column that is not there."""
    return SelectionError(f"column {name!r}: the columns are {', '.join(known)}")
