"""Read lists of levels from files: a number per line, or a table, in k, in k^2 or in a frequency."""

import csv
import math
import sys
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.errors import InputError
from orbitdb.quantum.weyl import Parity, one_parity
from orbitdb.text import real_in_file

_LIGHT = 299_792_458.0
"""Speed of light in metres per second."""
_UNITS = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}

Unit = Literal["Hz", "kHz", "MHz", "GHz"]
"""Units of frequencies."""


class LevelTable(NamedTuple):
    """The levels in a file, as they stand there: k in 1/radius, and the parity of each, None if not given."""

    k: Floats
    parity: list[Parity | None]

    def of(self, parity: Parity | None) -> Floats:
        """Return the levels of one parity, with those whose parity is not given, or of all; they ascend."""
        return np.sort(self._own(parity))

    def in_order(self, parity: Parity | None) -> bool:
        """Return whether the levels of one parity or of all are in ascending order in the file."""
        return bool((np.diff(self._own(parity)) >= 0).all())

    def _own(self, parity: Parity | None) -> Floats:
        return self.k[[parity is None or of in (None, parity) for of in self.parity]]


def read_levels(
    path: Path | str,
    *,
    energies: bool = False,
    frequency: Unit | None = None,
    radius: float | None = None,
    parity: Parity | str | None = None,
) -> Floats:
    """Return the levels in a file as wavenumbers k in ascending order, shape (N,), in 1/radius.

    The file has one level per line, or is a table with a header, separated by commas, tabs, semicolons or
    blanks; lines that begin with # are comments.

    Parameters
    ----------
    path : path
        The file; ``-`` reads stdin.
    energies : bool, optional
        Whether the file has energies k^2 (in a table, the column ``energy``) in place of k (column ``k``).
    frequency : str, optional
        Hz, kHz, MHz or GHz, if the file has frequencies of a microwave resonator (column ``frequency``).
    radius : float, optional
        Radius of the semicircles in metres; goes with `frequency`.
    parity : str, optional
        ``ee``, ``eo``, ``oe`` or ``oo``: leave out the rows whose column ``parity`` names another.

    Raises
    ------
    InputError
        If the file cannot be read, or has no levels.
    """
    return read_table(path, energies, frequency, radius).of(one_parity(parity))


def read_table(
    path: Path | str, energies: bool = False, frequency: Unit | None = None, radius: float | None = None
) -> LevelTable:
    """Return the levels in a file with their parities (`read_levels`)."""
    if (frequency is None) != (radius is None):
        raise InputError("frequencies need frequency with their unit and radius in metres")
    if frequency is not None and energies:
        raise InputError("energies and frequency: the file can contain only one of them")
    if frequency is not None and frequency not in _UNITS:
        raise InputError(f"frequency {frequency!r:.40}: use {', '.join(_UNITS)}")
    if radius is not None and not 0 < radius < math.inf:
        raise InputError(f"radius {radius:g}: give the radius in metres, such as 0.2")
    where = "stdin" if str(path) == "-" else str(path)
    name = "energy" if energies else "k" if frequency is None else "frequency"
    try:
        parities, values = _levels_in(_text(path, where), where, name)
    except csv.Error as error:
        raise InputError(f"{where} is no table ({error}); give a file with one level per line") from None
    if frequency is not None and radius is not None:
        values *= 2 * math.pi * _UNITS[frequency] * radius / _LIGHT
    return LevelTable(np.sqrt(values) if energies else values, parities)


def _text(path: Path | str, where: str) -> str:
    """Return the text of a file or of stdin."""
    try:
        if where == "stdin":
            return sys.stdin.read().lstrip("\ufeff")
        return Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "not text"
        raise InputError(f"{where}: {why}; give a file with one level per line") from None


def _levels_in(text: str, path: str, name: str) -> tuple[list[Parity | None], Floats]:
    """Return the parities, None if not given, and the values of the rows."""
    if text.lstrip().startswith(("[", "{")):
        raise InputError(f"{path} is JSON: give csv, with one level k per line or with a column k")
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    mark = next((mark for mark in "\t;, " if lines and mark in lines[0]), ",")
    bare = not lines or lines[0][0] == "(" or _number(lines[0].split(mark)[0]) is not None
    table = csv.DictReader(lines, [name] if bare else None, delimiter=mark, skipinitialspace=True)
    if (table.fieldnames or []).count(name) > 1:
        raise InputError(f"{path}: its header has several columns {name}: rename or remove all but one")
    if name not in (table.fieldnames or ()):
        raise InputError(f"{path}: its header has no column {name}: rename a column, or leave out the header")
    parities: list[Parity | None] = []
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
        parities.append(_parity(row.get("parity"), f"{path}: row {number}"))
        levels.append(level)
    return parities, np.array(levels, np.float64)


def _parity(name: str | None, where: str) -> Parity | None:
    """Return the parity in a column of a table, None if there is none."""
    try:
        return one_parity(name or None)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _number(text: str) -> float | None:
    try:
        return real_in_file(text)
    except ValueError:
        return None
