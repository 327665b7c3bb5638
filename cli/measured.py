"""Levels in a file, as wavenumbers, energies or frequencies, and the options that say so."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import parities
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import real

if TYPE_CHECKING:
    from orbitdb.arrays import Floats
    from orbitdb.quantum.amplitudes import Parity
    from orbitdb.store.reading.moment import Moment

_LIGHT = 299_792_458.0
"""Speed of light in metres per second."""
_UNITS = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}

LEVELS_FILE = "Levels k, one a line, or a table with a column k [default: those of the catalogue]."


@dataclass(frozen=True)
class Measured:
    """The options that say what a file of levels holds, as typed; see their help.

    A command gets all of them through one parameter, ``measured: Measured``.
    """

    parity: Annotated[
        str | None,
        typer.Option(help="ee, eo, oe or oo, if the levels are of one [default: all in one list]."),
    ] = None
    energies: Annotated[
        bool, typer.Option("--energies", help="The file holds energies k^2 (in a table, a column energy).")
    ] = False
    frequency: Annotated[
        Literal["Hz", "kHz", "MHz", "GHz"] | None,
        typer.Option(help="The file holds frequencies in this unit (in a table, a column frequency)."),
    ] = None
    radius: Annotated[
        float | None, options.number_option(help="Radius of the semicircles in metres, with --frequency.")
    ] = None

    def one_parity(self) -> "Parity | None":
        """Return the named parity, None for all; raise if several are named."""
        if self.parity is None:
            return None
        named = parities(self.parity)
        if len(named) != 1:
            raise InputError(f"--parity {self.parity}: give one, or leave it out for all")
        return named[0]

    def levels(self, context: typer.Context, path: Path | None) -> "Floats | None":
        """Return the levels k in a file, in rising order, those of the named parity; None without a file."""
        if path is None:
            options.refuse_idle(context, "without a file of levels", "energies", "frequency", "radius")
            return None
        return self._of(_read(path, self._column), path, self.one_parity())

    def by_parity(
        self, context: typer.Context, moment: "Moment", a: float, path: Path | None
    ) -> "dict[Parity, Floats]":
        """Return the levels of each named parity, from a file or the catalogue."""
        from orbitdb.answers.spectrum import levels_from_zero
        from orbitdb.billiard.stadium import Stadium
        from orbitdb.quantum.spectrum import check_levels

        named = parities(self.parity)
        if path is None:
            self.levels(context, path)
            return {each: levels_from_zero(moment, a, each).k for each in named}
        table = _read(path, self._column)
        known = {parity for parity, _ in table}
        if known == {None} and len(named) > 1:
            raise InputError(
                f"statistics are of one parity: name it with --parity, or give a column in {path}"
            )
        here = [each for each in named if known == {None} or str(each) in known]
        return {each: check_levels(self._of(table, path, each), Stadium(a), each) for each in here}

    @property
    def _column(self) -> str:
        if (self.frequency is None) != (self.radius is None):
            raise InputError("frequencies need --frequency with their unit and --radius in metres")
        if self.frequency is not None and self.energies:
            raise InputError("--energies and --frequency: the file holds one or the other")
        return "energy" if self.energies else "k" if self.frequency is None else "frequency"

    def _of(self, table: "list[tuple[str | None, float]]", path: Path, parity: "Parity | None") -> "Floats":
        """Return the levels k in a table, in rising order, with a note if they were not."""
        import numpy as np

        values = np.array(
            [value for of, value in table if parity is None or of in (None, str(parity))], float
        )
        if (np.diff(values) < 0).any():
            note(f"the levels in {path} were not in order: sorted")
        values = np.sort(values)
        if self.energies:
            values = np.sqrt(values)
        if self.frequency is not None and self.radius is not None:
            if not 0 < self.radius < math.inf:
                raise InputError(f"--radius {self.radius:g}: give metres, such as 0.2")
            values *= 2 * math.pi * _UNITS[self.frequency] * self.radius / _LIGHT
        return values


def _read(path: Path, name: str) -> list[tuple[str | None, float]]:
    """Return the parity, if there is one, and the number in a column, of each row of a file.

    The file is csv, a table with tabs, semicolons or spaces, or one number a line. Lines with # are skipped.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "no text"
        raise InputError(f"{path}: {why}; give a file with one level a line") from None
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    mark = next((each for each in "\t;, " if lines and each in lines[0]), ",")
    bare = not lines or _number(lines[0].split(mark)[0]) is not None
    table = csv.DictReader(lines, [name] if bare else None, delimiter=mark, skipinitialspace=True)
    if name not in (table.fieldnames or ()):
        raise InputError(f"{path}: its heading has no column {name}: rename one, or leave out the heading")
    found = []
    for number, row in enumerate(table, 1):
        if None in row:
            raise InputError(
                f"{path}: row {number} has too many columns: name all in a heading, or give one number a "
                "line, with a decimal point"
            )
        level = _number(row[name] or "")
        if level is None:
            raise InputError(f"{path}: row {number} has no level: {row[name]!r:.40}; give one number a line")
        if not 0 < level < math.inf:
            raise InputError(f"{path}: row {number} is {level:g}: levels are finite and above 0")
        found.append((row.get("parity"), level))
    return found


def _number(text: str) -> float | None:
    try:
        return real(text)
    except ValueError:
        return None
