"""The length spectrum of a stadium, from its orbits and from its levels."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Complexes, Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.errors import InputError
from orbitdb.extras import Drawn, data_frame
from orbitdb.numerals import exact
from orbitdb.plaintext import several
from orbitdb.quantum.amplitudes import Parity, Terms, weyl
from orbitdb.quantum.lengths import peak_of_each

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike


COLUMNS = ("length", "quantum_re", "quantum_im", "orbits_re", "orbits_im")
_LEAST_LEVELS = 10
_OFF, _FEW = 0.2, 4
"""Allowed difference from Weyl's law: a fraction of the number that it predicts, plus a few levels."""
_FAMILY = "02"


class Peak(NamedTuple):
    """An orbit that contributes to a peak of the length spectrum.

    Attributes
    ----------
    length : float
        Position of the peak, in units of the radius.
    height : float
        Modulus of F at the peak, from the levels if they are given, otherwise from the orbits.
    code : str
        Representative of the symmetry class of the orbit; ``02`` is the bouncing-ball family.
    repetitions : float
        Number of traversals; a half-integer is possible for one parity, because half orbits contribute.
    total : float
        Length of the repeated orbit, in units of the radius.
    strength : float
        Modulus of the contribution of this orbit alone to F at the peak.
    """

    length: float
    height: float
    code: str
    repetitions: float
    total: float
    strength: float


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(ByValue, Drawn):
    """The length spectrum F(x), windowed with sin^4(pi k / k_max).

    `plot` draws the modulus of F, downwards for the orbits and upwards for the levels, if there are any.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity or None
        Parity of the levels; None for levels of all parities.
    k_max : float
        End of the window, in 1/radius.
    length : ndarray, shape (n,)
        The lengths x, in units of the radius.
    orbits : ndarray of complex128, shape (n,)
        F from the orbits and the bouncing-ball family.
    quantum : ndarray of complex128, shape (n,), or None
        F from the levels, minus their smooth density; None if there are no levels.
    complete : float
        Length up to which the sum is proved to contain every orbit; beyond it, orbits may be missing.
    terms : Terms
        The terms of the orbits, followed by those of the bouncing-ball family.
    codes : ndarray of object, shape (C,)
        Representatives of the symmetry classes to which `Terms.orbit` refers.
    """

    a: float
    parity: Parity | None
    k_max: float
    length: Floats
    orbits: Complexes
    quantum: Complexes | None
    complete: float
    terms: Terms
    codes: NDArray[np.object_]

    def __repr__(self) -> str:
        of = "" if self.parity is None else f" of the parity {self.parity}"
        levels = "orbits" if self.quantum is None else "levels and orbits"
        low, high = self.length[[0, -1]]
        lengths, k_max = f"x = {low:g} to {high:g}", f"k below {self.k_max:.4g}"
        return f"<length spectrum{of} at a = {exact(self.a)}: {levels}, {lengths}, {k_max}>"

    @property
    def misfit(self) -> float | None:
        """rms of ``quantum - orbits`` divided by the rms of ``quantum``; None if there are no levels."""
        if self.quantum is None:
            return None
        return float(np.linalg.norm(self.quantum - self.orbits) / np.linalg.norm(self.quantum))

    def notes(self) -> list[str]:
        """Return one line on how complete the orbits are, and one on how well they agree with the levels."""
        end = math.floor(self.complete * 100) / 100
        if end < self.length[-1]:
            said = [f"complete, by proof, up to length {end:.2f}; longer orbits may be missing from the sum"]
        else:
            said = ["complete: no orbit of these lengths is missing"]
        if self.misfit is None:
            of = "" if self.parity is None else f" --parity {self.parity}"
            return [
                *said,
                f"no levels to compare with: run 'orbitdb levels --k 0:30 --a {exact(self.a)}{of}'",
            ]
        return [*said, f"k_max = {self.k_max:.6g}; |quantum - orbits| / |quantum| = {self.misfit:.3f}"]

    def rows(self) -> list[tuple[float | None, ...]]:
        """Return one row for each length, with the values of `COLUMNS`."""
        nothing = [None] * len(self.length)
        quantum = (nothing, nothing) if self.quantum is None else _parts(self.quantum)
        return list(zip(self.length.tolist(), *quantum, *_parts(self.orbits), strict=True))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the rows as a pandas data frame (extra ``pandas``)."""
        return data_frame(self.rows(), COLUMNS)

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        return "curves.draw_spectrum", (self,), repr(self).strip("<>")

    def peaks(self, most: int = 5) -> Iterator[Peak]:
        """Yield up to `most` of the strongest orbits of each peak, in ascending order of the peak length."""
        height = np.abs(self.orbits if self.quantum is None else self.quantum)
        inner = height[1:-1]
        tops = 1 + np.flatnonzero((inner > height[:-2]) & (inner >= height[2:]) & (inner > height.max() / 20))
        for top in tops.tolist():
            x = self.length[top : top + 1]
            near = self.terms.rows(np.abs(self.terms.length - x) < 2 * math.pi / self.k_max)
            strength = np.abs(peak_of_each(near, x, self.k_max)[0])
            for n in np.argsort(-strength)[:most].tolist():
                code = _FAMILY if near.orbit[n] < 0 else str(self.codes[near.orbit[n]])
                times, half = divmod(int(near.repetitions[n]), int(near.parts[n]))
                of_term = times + half / 2 if half else times, float(near.length[n]), float(strength[n])
                yield Peak(float(x[0]), float(height[top]), code, *of_term)


def _parts(values: Complexes) -> tuple[list[float], list[float]]:
    return values.real.tolist(), values.imag.tolist()


def check_levels(levels: "ArrayLike", stadium: Stadium, parity: Parity | None) -> Floats:
    """Return levels in ascending order; refuse a list that cannot be all levels of a stadium of radius 1.

    Raises
    ------
    InputError
        If there are too few levels, one is not positive and finite, or their number is far from Weyl's law.
    """
    k = np.sort(np.asarray(levels, np.float64), axis=-1)
    if k.ndim != 1:
        raise InputError(f"the levels have shape {k.shape}: give one row of numbers")
    if len(k) < _LEAST_LEVELS:
        raise InputError(f"the list has only {several(len(k), 'level')}: give {_LEAST_LEVELS} or more")
    if (wrong := k[~((k > 0) & (k < np.inf))]).size:
        raise InputError(f"{wrong[0]:g} is not a level: give finite k above 0, in 1/radius")
    if not _plausible(len(k), k[-1], stadium, parity):
        of = " of all parities" if parity is None else f" of parity {parity}"
        expected = max(0.0, float(weyl(stadium, parity)(k[-1])))
        raise InputError(
            f"{len(k)} levels up to k = {k[-1]:g}, but Weyl's law expects {expected:.0f}{of} at a = "
            f"{exact(stadium.a)}: {_remedy(len(k), k[-1], stadium, parity)}"
        )
    return k


def _plausible(count: int, end: float, stadium: Stadium, parity: Parity | None) -> bool:
    expected = float(weyl(stadium, parity)(end))
    return abs(count - expected) <= _OFF * expected + _FEW


def _remedy(count: int, end: float, stadium: Stadium, parity: Parity | None) -> str:
    """Return a message that says what may be wrong with a list that has too many or too few levels."""
    if _plausible(count, math.sqrt(end), stadium, parity):
        return "they look like energies: give --energies"
    if _plausible(count, end**2, stadium, parity):
        return "they look like wavenumbers: leave out --energies"
    if parity is not None and _plausible(count, end, stadium, None):
        return "they look like the levels of all parities: leave out --parity"
    if parity is None and any(_plausible(count, end, stadium, each) for each in Parity):
        return "they look like the levels of one parity: name it with --parity"
    return "check --parity, --a and the unit: k is in 1/radius, frequencies need --frequency and --radius"
