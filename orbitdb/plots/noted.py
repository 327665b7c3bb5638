"""What figures ask a catalogue beside its methods: what is missing, and why there is nothing to draw."""

from typing import TYPE_CHECKING

from orbitdb.plots.registry import EmptyFigureError
from orbitdb.store.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue


def gaps(catalogue: "Catalogue", chosen: Selection, order: str = "p") -> list[str]:
    """Return one line for each kind of gap in a chosen subset."""
    return [*catalogue.rows(chosen, columns=("code",), order=order).notes]


def nothing(catalogue: "Catalogue", chosen: Selection) -> EmptyFigureError:
    """Return the error for a subset without anything to draw."""
    listing = catalogue.rows(chosen, columns=("code",))
    absent = listing.absent
    lines = [line for line in listing.notes if line not in absent]
    return EmptyFigureError([*lines, *(f"{line}: nothing to draw" for line in absent)])
