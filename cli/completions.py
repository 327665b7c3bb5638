"""What the shell offers as the value of an option."""

from collections.abc import Iterable, Iterator

import typer

from orbitdb.cli.grids import ALL
from orbitdb.errors import InputError
from orbitdb.text import format_float


def offered_columns(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the columns of the catalogue that are not typed yet."""
    from orbitdb.columns import IN_CATALOGUE

    return _in_list(incomplete, ((column.name, column.brief) for column in IN_CATALOGUE))


def offered_statuses(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the statuses that rows can have."""
    from orbitdb.orbits.status import STORED

    rows = ((status.value, status.sentence) for status in STORED)
    return _in_list(incomplete, [*rows, ("all", "every status")])


def offered_half_lengths(context: typer.Context) -> list[str]:
    """Offer the values of a in the catalogue of --db, or in the default one; none if it cannot be read."""
    from orbitdb.catalogue import Catalogue
    from orbitdb.errors import StoreError

    try:
        return [*map(format_float, Catalogue(context.params.get("db")).a_values())]
    except (InputError, StoreError):
        return []


def offered_several_half_lengths(context: typer.Context) -> list[str]:
    """Offer the values of a in the catalogue, and ``all``."""
    return [*offered_half_lengths(context), ALL]


def _in_list(incomplete: str, names: Iterable[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """Yield the names that can continue a list separated by commas, with their meanings."""
    before, comma, _ = incomplete.rpartition(",")
    for name, meaning in names:
        if name not in before.split(","):
            yield f"{before}{comma}{name}", meaning
