"""Options for quantum levels, shared by several commands: ranges of k, parities, and files of levels."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import typer

from orbitdb.cli.notes import note
from orbitdb.cli.options import number_option, read_path
from orbitdb.errors import InputError
from orbitdb.text import real, several

if TYPE_CHECKING:
    from orbitdb.arrays import Floats
    from orbitdb.quantum.level_files import LevelTable
    from orbitdb.quantum.weyl import Parity, Wavenumbers


class Radius(NamedTuple):
    """A radius in metres, and its standard error if it is known."""

    metres: float
    error: float | None = None


def read_radius(text: str) -> Radius:
    """Parse a radius such as 0.2 or 0.2+-0.0005, in metres."""
    value, given, error = text.replace("\u00b1", "+-").partition("+-")
    return Radius(real(value), real(error) if given else None)


RangeOfK = Annotated[
    str | None,
    typer.Option(
        metavar="LOW:HIGH",
        help="Range of wavenumbers k, in units of 1/radius; a single number is its upper end.",
    ),
]
Lengths = Annotated[
    str | None,
    typer.Option(
        metavar="LOW:HIGH",
        help="Range of lengths, in units of the radius [default: 1 to beyond 4(1 + a), the length of 13].",
    ),
]
Parities = Annotated[
    str | None, typer.Option(help="ee, eo, oe or oo, several separated by commas, or all [default: all].")
]


_HELP = (
    "File with one level k per line, or a table with a column k; - reads stdin [default: levels in the "
    "catalogue]."
)
OF_FILE = ("energies", "frequency", "radius", "window")
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

    window: Annotated[
        bool, typer.Option("--window", help="The list may begin with any level, not only the lowest.")
    ] = False

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
        if self.levels is None:
            return None
        table = self._table(self.levels)
        self._note_left_out(table, [parity] if parity else [])
        return self._levels(table, parity)

    def by_parity(self) -> "dict[Parity, Floats] | None":
        """Return the levels k of each parity in the file; None if no file is given."""
        from orbitdb.quantum.weyl import parities_of

        if self.levels is None:
            return None
        named, table = parities_of(self.parity), self._table(self.levels)
        in_file = {*table.parity}
        if in_file == {None} and len(named) > 1:
            raise InputError(
                "statistics need one parity: name it with --parity, or add a column parity to "
                f"{_name(self.levels)}"
            )
        self._note_left_out(table, named)
        given = [parity for parity in named if in_file == {None} or parity in in_file]
        return {parity: self._levels(table, parity) for parity in given}

    def _table(self, path: Path) -> "LevelTable":
        from orbitdb.quantum.level_files import read_table

        metres = None if self.radius is None else self.radius.metres
        return read_table(path, self.energies, self.frequency, metres)

    def _note_left_out(self, table: "LevelTable", named: "Sequence[Parity]") -> None:
        """Note how many levels are left out because the file gives them a parity that is not named."""
        others = sum(parity not in (None, *named) for parity in table.parity) if named else 0
        if others and self.levels is not None:
            every = several(len(table.parity), "level")
            note(f"left out for their parity: {others} of {every} in {_name(self.levels)}")

    def _levels(self, table: "LevelTable", parity: "Parity | None") -> "Floats":
        """Return the levels of one parity or of all; note if they are not in order."""
        if not table.in_order(parity):
            assert self.levels is not None
            note(f"the levels in {_name(self.levels)} were not in order and have been sorted")
        return table.of(parity)


def _name(path: Path) -> str:
    return "stdin" if str(path) == "-" else str(path)


@dataclass(frozen=True)
class MeasuredLevels(GivenLevels):
    """The options of `GivenLevels`, with the file as an argument."""

    levels: Annotated[Path | None, typer.Argument(metavar="FILE", parser=read_path, help=_HELP)] = None


def read_range(name: str, text: str) -> tuple[float, float]:
    """Parse a range such as 0:30 or :30 and return its ends, or raise."""
    first, colon, last = text.partition(":")
    try:
        low, high = real(first) if first else 0.0, real(last)
    except ValueError:
        low, high = 0.0, -1.0
    if not colon or not 0 <= low < high:
        raise InputError(f"{name} {text!r:.40}: give LOW:HIGH with 0 <= LOW < HIGH, such as 0:30")
    return low, high


def read_k(text: str) -> "Wavenumbers":
    """Parse --k: one number, or LOW:HIGH, either of which may be missing."""
    first, colon, last = text.partition(":")
    try:
        low, high = real(first) if first or not colon else 0.0, real(last) if last else math.inf
    except ValueError:
        low = high = -1.0
    if not (0 <= low < high if colon else 0 < low < math.inf) or text == ":":
        raise InputError(
            f"--k {text!r:.40}: give LOW:HIGH with 0 <= LOW < HIGH, such as 0:30, or one k above 0"
        )
    return (low, high if last else None) if colon else low
