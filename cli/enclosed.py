"""What is known by proof of the topological entropy, in words."""

from typing import TYPE_CHECKING

from orbitdb.cli.render import number

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.enclosures import Enclosure

COLUMNS = ("h_lower", "h_upper", "h_proof")
"""Names that the bounds have beside other columns."""


def between(found: "Enclosure") -> str:
    """Return the bounds, rounded outward."""
    return f"{number('lower', found.lower)} < h < {number('upper', found.upper)}"


def enclosure(catalogue: "Catalogue", a: float) -> "tuple[Enclosure, str] | None":
    """Return the closest stored bounds on the entropy at one a, and a line that tells of them.

    Where others, in balls, are less close, the line tells of them, too.
    """
    from orbitdb.store.file.schema import BALLS

    closest = catalogue.entropy_bounds(a)
    if closest is None:
        return None
    line = f"entropy of all orbits: {between(closest)}, proved by {closest.basis}"
    surer = None if closest.proof == BALLS else catalogue.entropy_bounds(a, BALLS)
    if surer is not None:
        line += f"; {between(surer)} by {surer.basis}"
    return closest, line


def told(found: "tuple[Enclosure, str]", a: float, many: bool) -> str:
    """Return the line of an `enclosure`, with its a if there are several."""
    return f"a = {a:g}: {found[1]}" if many else found[1]


def columns_of(found: "Enclosure | None", count: int) -> dict[str, list[float | str]]:
    """Return the bounds as columns of so many rows; none where there are none."""
    if found is None:
        return {}
    return {
        "h_lower": [found.lower] * count,
        "h_upper": [found.upper] * count,
        "h_proof": [found.proof] * count,
    }
