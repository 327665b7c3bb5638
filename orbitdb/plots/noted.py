"""What figures ask a catalogue beside its methods, and what they say if there is nothing to draw."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

from orbitdb.answers import completeness
from orbitdb.errors import InputError
from orbitdb.store.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

_Answer = TypeVar("_Answer")


class EmptyFigureError(InputError):
    """There is nothing to draw; each line says what is missing, and perhaps the command that makes it.

    Attributes
    ----------
    lines : tuple of str
    """

    def __init__(self, lines: Iterable[str]) -> None:
        self.lines = tuple(lines)
        super().__init__("; ".join(self.lines))


def asked(catalogue: "Catalogue", function: Callable[..., _Answer], chosen: Selection, *more: Any) -> _Answer:
    """Return the answer of a function of `orbitdb.answers` that is no method of the catalogue."""
    return catalogue._answer(function, chosen, {}, *more)


def gaps(catalogue: "Catalogue", chosen: Selection, order: str = "p") -> list[str]:
    """Return one line for each kind of gap in a chosen subset (`orbitdb.answers.completeness.gaps`)."""
    return asked(catalogue, lambda moment, own: completeness.gaps(moment, own, order=order), chosen)


def nothing(catalogue: "Catalogue", chosen: Selection) -> EmptyFigureError:
    """Return the error for a subset without anything to draw."""
    lines = gaps(catalogue, chosen)
    if empty := asked(catalogue, completeness.nothing, chosen):
        lines.append(f"{empty}: nothing to draw")
    return EmptyFigureError(lines)
