"""What a shell offers behind an option: columns, statuses, values of a."""

from collections.abc import Iterable, Iterator

import typer


def columns(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the columns of the catalogue behind those that are written already."""
    from orbitdb.columns import IN_CATALOGUE

    return _in_list(incomplete, ((each.name, each.brief) for each in IN_CATALOGUE))


def statuses(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the statuses that rows have."""
    from orbitdb.orbits.orbit import STORED

    rows = ((status.value, status.sentence) for status in STORED)
    return _in_list(incomplete, [*rows, ("all", "every one")])


def half_lengths(context: typer.Context, incomplete: str) -> list[str]:
    """Offer the values of a in the catalogue that is named, or meant; none if it cannot be read."""
    from contextlib import closing

    from orbitdb.errors import InputError, StoreError
    from orbitdb.numerals import exact
    from orbitdb.store.reading.catalogue import Catalogue

    try:
        with closing(Catalogue(context.params.get("db"))) as catalogue:
            return [text for text in map(exact, catalogue.a_values()) if text.startswith(incomplete)]
    except (InputError, StoreError):
        return []


def several_half_lengths(context: typer.Context, incomplete: str) -> list[str]:
    """Offer them, and what stands for all of them."""
    return [*half_lengths(context, incomplete), *(["all"] if "all".startswith(incomplete) else [])]


def _in_list(incomplete: str, known: Iterable[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """Offer names that go on with the last of some, with commas between, each with what it means."""
    before, comma, begun = incomplete.rpartition(",")
    for name, meaning in known:
        if name.startswith(begun) and name not in before.split(","):
            yield f"{before}{comma}{name}", meaning
