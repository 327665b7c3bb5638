"""Options for quantum levels, shared by several commands: ranges of k, parities, and files of levels."""

import csv
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple, TypeAlias

import typer

from orbitdb.cli.options import number_option, read_path
from orbitdb.cli.output import note
from orbitdb.errors import InputError
from orbitdb.text import real, real_in_file

if TYPE_CHECKING:
    from orbitdb.arrays import Floats
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.weyl import Parity

FileLevels: TypeAlias = "list[tuple[Parity | None, float]]"
"""For each level in a file, its parity (None if not given) and its value: k, an energy or a frequency."""

_LIGHT = 299_792_458.0
"""Speed of light in metres per second."""
_UNITS = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}


class Radius(NamedTuple):
    """A radius in metres, and its standard error if it is known."""

    metres: float
    error: float | None = None


def read_radius(text: str) -> Radius:
    """Parse a radius such as 0.2 or 0.2+-0.0005, in metres."""
    value, given, error = text.replace("\u00b1", "+-").partition("+-")
    return Radius(real(value), real(error) if given else None)


_RANGE = typer.Option(metavar="FROM:TO", help="Range of wavenumbers k, in units of 1/radius.")
Range = Annotated[str, _RANGE]
SomeRange = Annotated[str | None, _RANGE]
Parities = Annotated[
    str | None, typer.Option(help="ee, eo, oe or oo; separate several by commas [default: all four].")
]


_HELP = (
    "File with one level k per line, or a table with a column k; - reads stdin [default: levels in the "
    "catalogue]."
)
OF_FILE = ("energies", "frequency", "radius")
"""Options that say what a file of levels contains."""


@dataclass(frozen=True)
class GivenLevels:
    """The options for a file of levels, and for the parity of its levels."""

    levels: Annotated[Path | None, typer.Option(metavar="FILE", parser=read_path, help=_HELP)] = None
    parity: Annotated[
        str | None, typer.Option(help="ee, eo, oe or oo, if the levels have one parity [default: all].")
    ] = None
    energies: Annotated[
        bool, typer.Option("--energies", help="The file has energies k^2 (in a table, the column energy).")
    ] = False
    frequency: Annotated[
        Literal["Hz", "kHz", "MHz", "GHz"] | None,
        typer.Option(help="The file has frequencies in this unit (in a table, the column frequency)."),
    ] = None
    radius: Annotated[
        Radius | None,
        number_option(
            read=read_radius,
            help="Radius of the semicircles in metres; goes with --frequency. If you add its standard error, "
            "as in 0.2+-0.0005, 'assess' fits it.",
        ),
    ] = None

    def __post_init__(self) -> None:
        if (self.frequency is None) != (self.radius is None):
            raise InputError("frequencies need --frequency with their unit and --radius in metres")
        if self.frequency is not None and self.energies:
            raise InputError("--energies and --frequency: the file can contain only one of them")
        if self.radius is not None:
            metres, error = self.radius
            if not 0 < metres < math.inf:
                raise InputError(f"--radius {metres:g}: give the radius in metres, such as 0.2")
            if error is not None and not 0 < error < math.inf:
                raise InputError(f"--radius {metres:g}+-{error:g}: give an error above 0")

    @property
    def radius_error(self) -> float | None:
        """Relative standard error of the radius, if it is given."""
        if self.radius is None or self.radius.error is None:
            return None
        return self.radius.error / self.radius.metres

    def of_one(self) -> "Parity | None":
        """Return the parity given with --parity, or None without it; raise if several are given."""
        from orbitdb.quantum.weyl import one_parity

        return one_parity(self.parity)

    def read(self, parity: "Parity | None") -> "Floats | None":
        """Return the levels k of one parity or of all, in ascending order; None if no file is given."""
        return None if self.levels is None else self._of(self._table(self.levels), parity)

    def by_parity(self, catalogue: "Catalogue", a: float) -> "dict[Parity, Floats]":
        """Return the levels of each parity, from the file or the catalogue."""
        from orbitdb.billiard.stadium import Stadium
        from orbitdb.quantum.weyl import check_levels, parities_of

        named = parities_of(self.parity)
        if self.levels is None:
            return {parity: catalogue.levels(parity=parity, a=a).k for parity in named}
        table = self._table(self.levels)
        in_file = {parity for parity, _ in table}
        if in_file == {None} and len(named) > 1:
            raise InputError(
                "statistics need one parity: name it with --parity, or add a column parity to "
                f"{_name(self.levels)}"
            )
        given = [parity for parity in named if in_file == {None} or parity in in_file]
        return {parity: check_levels(self._of(table, parity), Stadium(a), parity) for parity in given}

    def _table(self, path: Path) -> "FileLevels":
        return read_file(path, "energy" if self.energies else "k" if self.frequency is None else "frequency")

    def _of(self, table: "FileLevels", parity: "Parity | None") -> "Floats":
        """Return the levels k of one parity or of all, in ascending order; note if they had to be sorted."""
        import numpy as np

        values = np.array([value for of, value in table if parity is None or of in (None, parity)], float)
        if (np.diff(values) < 0).any():
            assert self.levels is not None
            note(f"the levels in {_name(self.levels)} were not in order and have been sorted")
        values = np.sort(values)
        if self.frequency is not None and self.radius is not None:
            values *= 2 * math.pi * _UNITS[self.frequency] * self.radius.metres / _LIGHT
        return np.sqrt(values) if self.energies else values


@dataclass(frozen=True)
class MeasuredLevels(GivenLevels):
    """The options of `GivenLevels`, with the file as an argument."""

    levels: Annotated[Path | None, typer.Argument(metavar="FILE", parser=read_path, help=_HELP)] = None


def read_range(name: str, text: str) -> tuple[float, float]:
    """Parse a range such as 0:30 and return its ends, or raise."""
    first, colon, last = text.partition(":")
    try:
        low, high = real(first) if first else 0.0, real(last)
    except ValueError:
        low, high = 0.0, -1.0
    if not colon or not 0 <= low < high:
        raise InputError(f"{name} {text!r:.40}: give FROM:TO with 0 <= FROM < TO, such as 0:30")
    return low, high


def read_file(path: Path, name: str) -> "FileLevels":
    """Read a file; return the parity, if given, and the value in the named column for each row.

    The file is a table separated by commas, tabs, semicolons or spaces, or a list with one number per line.
    Lines that begin with # are comments.
    """
    where = _name(path)
    try:
        from_stdin = str(path) == "-"
        text = sys.stdin.read().lstrip("\ufeff") if from_stdin else path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "not text"
        raise InputError(f"{where}: {why}; give a file with one level per line") from None
    try:
        return _levels_in(text, where, name)
    except csv.Error as error:
        raise InputError(f"{where} is no table ({error}); give a file with one level per line") from None


def _name(path: Path) -> str:
    return "stdin" if str(path) == "-" else str(path)


def _levels_in(text: str, path: str, name: str) -> "FileLevels":
    if text.lstrip().startswith(("[", "{")):
        raise InputError(f"{path} is JSON: give csv, as 'orbitdb levels --format csv' writes it")
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    mark = next((mark for mark in "\t;, " if lines and mark in lines[0]), ",")
    bare = not lines or lines[0][0] == "(" or _number(lines[0].split(mark)[0]) is not None
    table = csv.DictReader(lines, [name] if bare else None, delimiter=mark, skipinitialspace=True)
    if (table.fieldnames or []).count(name) > 1:
        raise InputError(f"{path}: its header has several columns {name}: rename or remove all but one")
    if name not in (table.fieldnames or ()):
        raise InputError(f"{path}: its header has no column {name}: rename a column, or leave out the header")
    levels = []
    for number, row in enumerate(table, 1):
        if None in row:
            raise InputError(
                f"{path}: row {number} has too many columns: name them all in a header, or give one number "
                "per line, with a decimal point"
            )
        level = _number(row[name] or "")
        if level is None:
            raise InputError(
                f"{path}: row {number} has no level: {row[name]!r:.40}; give one number per line"
            )
        if not 0 < level < math.inf:
            raise InputError(f"{path}: row {number} is {level:g}: levels are finite and above 0")
        levels.append((_parity(row.get("parity"), f"{path}: row {number}"), level))
    return levels


def _parity(name: str | None, where: str) -> "Parity | None":
    """Return the parity in a column of a table, None if there is none."""
    from orbitdb.quantum.weyl import one_parity

    try:
        return one_parity(name or None)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _number(text: str) -> float | None:
    try:
        return real_in_file(text)
    except ValueError:
        return None
