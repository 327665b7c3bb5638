"""Options about quantum levels, shared by commands: ranges of k, parities, and levels in a file."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.cli.options import number_option
from orbitdb.errors import InputError
from orbitdb.numerals import real

if TYPE_CHECKING:
    from orbitdb.quantum.amplitudes import Parity

_LIGHT = 299_792_458.0
"""Speed of light in metres per second."""
_UNITS = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}

_RANGE = typer.Option(metavar="FROM:TO", help="Range of wavenumbers, in units of 1/radius.")
Range = Annotated[str, _RANGE]
SomeRange = Annotated[str | None, _RANGE]
Parities = Annotated[
    str | None, typer.Option(help="ee, eo, oe or oo, several separated by commas [default: all four].")
]


@dataclass(frozen=True)
class GivenLevels:
    """The options for levels in a file, and for the parity of levels."""

    levels: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="File of levels k, one per line, or csv with a column k [default: those of the catalogue].",
        ),
    ] = None
    energies: Annotated[
        bool, typer.Option("--energies", help="The file holds energies k^2 (in csv, a column energy).")
    ] = False
    parity: Annotated[
        str | None, typer.Option(help="ee, eo, oe or oo, if the levels are of one [default: all].")
    ] = None

    def of_one(self) -> "Parity | None":
        """Return the parity, or None if none is named; raise for several."""
        return None if self.parity is None else one_parity(self.parity)

    def read(self, parity: str | None) -> list[float] | None:
        """Return the levels k of one parity or of all, or None if no file is named."""
        if self.levels is None:
            return None
        return read_file(self.levels, "energy" if self.energies else "k", parity)


@dataclass(frozen=True)
class MeasuredLevels(GivenLevels):
    """The same for a measured list, which may hold frequencies."""

    levels: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="Levels k, one per line, or csv with a column k [default: those of the catalogue].",
        ),
    ] = None
    frequency: Annotated[
        Literal["Hz", "kHz", "MHz", "GHz"] | None,
        typer.Option(help="The file holds frequencies in this unit (csv: a column frequency)."),
    ] = None
    radius: Annotated[
        float | None, number_option(help="Radius of the semicircles in metres, with --frequency.")
    ] = None

    def __post_init__(self) -> None:
        if (self.frequency is None) != (self.radius is None):
            raise InputError("frequencies need --frequency with their unit and --radius in metres")
        if self.frequency is not None and self.energies:
            raise InputError("--energies and --frequency: the file holds one or the other")
        if self.radius is not None and not 0 < self.radius < math.inf:
            raise InputError(f"--radius {self.radius:g}: give metres, such as 0.2")

    def read(self, parity: str | None) -> list[float] | None:
        """Return the levels k, from frequencies too."""
        if self.levels is None or self.frequency is None or self.radius is None:
            return super().read(parity)
        wave = 2 * math.pi * _UNITS[self.frequency] * self.radius / _LIGHT
        return [wave * each for each in read_file(self.levels, "frequency", parity)]


def read_range(name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range such as 0:30, or raise."""
    first, colon, last = text.partition(":")
    try:
        low, high = real(first), real(last)
    except ValueError:
        low, high = 0.0, -1.0
    if not colon or not 0 <= low < high:
        raise InputError(f"{name} {text!r:.40}: give a range from 0 up, such as 0:30")
    return low, high


def read_parities(text: str | None) -> "list[Parity]":
    """Return the named parities, by default all four, or raise."""
    from orbitdb.quantum.amplitudes import Parity

    if text is None:
        return list(Parity)
    try:
        return list(dict.fromkeys(Parity(each.strip()) for each in text.split(",")))
    except ValueError:
        raise InputError(f"--parity {text!r:.40}: use ee, eo, oe or oo, separated by commas") from None


def one_parity(text: str) -> "Parity":
    """Return the named parity; raise if there are several."""
    first, *others = read_parities(text)
    if others:
        raise InputError(f"--parity {text}: give one, or leave it out for all")
    return first


def read_file(path: Path, column: str, parity: str | None) -> list[float]:
    """Return the levels k in a file, or another column; from a csv with parities only the named parity.

    Energies become k. Refuses unreadable files and impossible levels.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "no text"
        raise InputError(f"{path}: {why}; give a file with one level per line") from None
    lines = [line for line in text.splitlines() if line.strip()]
    bare = not lines or _level(lines[0].split(",")[0]) is not None
    table = csv.DictReader(lines, [column] if bare else None, skipinitialspace=True)
    if column not in (table.fieldnames or ()):
        raise InputError(f"{path}: its heading has no column {column}: rename one, or leave out the heading")
    found = []
    for number, row in enumerate(table, 1):
        if parity not in (None, row.get("parity", parity)):
            continue
        level = _level(row[column] or "")
        if level is None:
            raise InputError(
                f"{path}: row {number} has no level: {row[column]!r:.40}; give one number per line"
            )
        if level <= 0:
            raise InputError(f"{path}: row {number} is {level:g}: levels are above 0")
        found.append(math.sqrt(level) if column == "energy" else level)
    return found


def _level(text: str) -> float | None:
    try:
        return real(text)
    except ValueError:
        return None
