"""The length spectrum: the Fourier transform of the fluctuating density of levels, from levels or orbits.

F(x) is the integral of w(k) (d(k) - smooth density) exp(i k x) over k0 < k < K, where the window is w =
sin^4(pi (k - k0) / (K - k0)) and k0 = 0 unless the levels begin higher up. From levels, F is the sum of w
exp(i k x) over the levels minus the transform of the smooth density. From orbits, each term Re(A exp(i k l))
gives a peak at x = l and a small image of it at -l.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Complexes, Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Drawn, data_frame
from orbitdb.quantum.bouncing_balls import family
from orbitdb.quantum.trace_formula import Terms
from orbitdb.quantum.weyl import Parity, weyl
from orbitdb.text import format_float, upwards

if TYPE_CHECKING:
    import pandas


SPECTRUM_COLUMNS = ("length", "quantum_re", "quantum_im", "orbits_re", "orbits_im")
TERMS = (
    "code", "p", "repetition", "length", "lyapunov", "index", "sign", "amplitude_re", "amplitude_im",
)  # fmt: skip
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
class Spectrum(Drawn):
    """The length spectrum F(x), windowed with sin^4(pi (k - k_min) / (k_max - k_min)).

    `plot` draws the modulus of F, downwards for the orbits and upwards for the levels, if there are any.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity or None
        Parity of the levels; None for levels of all parities.
    k_min, k_max : float
        Ends of the window, in 1/radius.
    length : ndarray, shape (n,)
        The lengths x, in units of the radius.
    orbits : ndarray of complex128, shape (n,)
        F from the orbits and the bouncing-ball family.
    quantum : ndarray of complex128, shape (n,), or None
        F from the levels, minus their smooth density; None if there are no levels.
    complete_length : float
        Length up to which the sum is proved to contain every orbit; beyond it, orbits may be missing.
    terms : Terms
        The terms of the orbits, followed by those of the bouncing-ball family.
    codes : ndarray of object, shape (C,)
        Representatives of the symmetry classes to which `Terms.orbit` refers.
    missing : float
        Bound on the amplitude of each class of orbits that the sum may lack, up to the last length.
    on_a : tuple of str
        The first of the notes if no a was named: which one was taken.
    """

    a: float
    parity: Parity | None
    k_min: float
    k_max: float
    length: Floats
    orbits: Complexes
    quantum: Complexes | None
    complete_length: float
    terms: Terms
    codes: NDArray[np.object_]
    missing: float = math.inf
    on_a: tuple[str, ...] = ()

    def __repr__(self) -> str:
        of = "" if self.parity is None else f" of the parity {self.parity}"
        levels = "orbits" if self.quantum is None else "levels and orbits"
        low, high = self.length[[0, -1]]
        return (
            f"<length spectrum{of} at a = {format_float(self.a)}: {levels}, x = {low:g} to {high:g}, "
            f"{self.range_of_k}>"
        )

    @property
    def range_of_k(self) -> str:
        """The range of k as text."""
        return f"k from {self.k_min:.6g} to {self.k_max:.6g}" if self.k_min else f"k below {self.k_max:.4g}"

    @property
    def misfit(self) -> float | None:
        """rms of ``quantum - orbits`` divided by the rms of ``quantum``; None if there are no levels."""
        if self.quantum is None:
            return None
        return float(np.linalg.norm(self.quantum - self.orbits) / np.linalg.norm(self.quantum))

    def notes(self, terms: bool = False) -> list[str]:
        """Return one line on how complete the orbits are, and one on how well they agree with the levels.

        With `terms`, the second line says instead at which k the amplitude of the bouncing balls is given.
        """
        end = math.floor(self.complete_length * 100) / 100
        if end < self.length[-1]:
            largest = f"{float(upwards(self.missing)):g} up to length {self.length[-1]:g}"
            said = [
                *self.on_a,
                f"complete, by proof, up to length {end:.2f}; longer orbits may be missing from the sum, a "
                f"class with an amplitude of at most {largest}",
            ]
        else:
            said = [*self.on_a, "complete: no orbit of these lengths is missing"]
        if terms:
            middle = (self.k_min + self.k_max) / 2
            at = f"the amplitudes of the bouncing balls, {_FAMILY}, are those at k = {middle:.6g}"
            return [*said, *[at][: any(row[0] == _FAMILY for row in self.term_rows())]]
        if self.misfit is None:
            of = "" if self.parity is None else f", parity='{self.parity}'"
            finds = f"`catalogue.fill_levels(k=30, a={format_float(self.a)}{of})` finds some"
            return [*said, f"no levels to compare with: {finds}"]
        ends = f"k = {self.k_min:.6g} to {self.k_max:.6g}" if self.k_min else f"k_max = {self.k_max:.6g}"
        return [*said, f"{ends}; |quantum - orbits| / |quantum| = {self.misfit:.3f}"]

    def rows(self) -> list[tuple[float | None, ...]]:
        """Return one row for each length, with the values of `SPECTRUM_COLUMNS`."""
        nothing = [None] * len(self.length)
        quantum = (nothing, nothing) if self.quantum is None else _parts(self.quantum)
        return list(zip(self.length.tolist(), *quantum, *_parts(self.orbits), strict=True))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the rows as a pandas data frame (extra ``pandas``)."""
        return data_frame(self.rows(), SPECTRUM_COLUMNS)

    _FIGURES = ("spectrum",)

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        return (self,), repr(self).strip("<>")

    def term_rows(self) -> list[tuple[Any, ...]]:
        """Return the terms Re(A exp(i k l)) with lengths l in the range of `length`, bouncing balls last.

        Each row has the values of `TERMS`: the code of the representative (02 for the bouncing balls), its
        period, the number of traversals of the orbit or, for one parity, of its half if it has one, the
        length (in units of the radius), lambda and Maslov index of all these traversals, the sign of the
        parity, and the real and imaginary part of A (in units of the radius), which is ``sign abs(A) exp(-i
        index pi / 2)``. For the bouncing balls, A depends on k and is given in the middle of the window; they
        have no lambda, index and sign.
        """
        low, high = self.length[[0, -1]]
        inside = self.terms.rows((self.terms.length >= low) & (self.terms.length <= high))
        terms = inside.rows(np.lexsort([inside.length, inside.orbit < 0]))
        of_orbit = terms.orbit >= 0
        codes = np.append(self.codes, _FAMILY)[terms.orbit].tolist()
        own = [
            [value if belongs else None for value, belongs in zip(values, of_orbit.tolist(), strict=True)]
            for values in (terms.lyapunov.tolist(), terms.maslov.tolist(), terms.sign.tolist())
        ]
        shared = terms.repetitions.tolist(), terms.length.tolist()
        return list(zip(codes, map(len, codes), *shared, *own, *_parts(terms.amplitude + 0.0), strict=True))

    def peaks(self, most: int = 5) -> Iterator[Peak]:
        """Yield up to `most` of the strongest orbits of each peak, in ascending order of the peak length."""
        height = np.abs(self.orbits if self.quantum is None else self.quantum)
        inner = height[1:-1]
        tops = 1 + np.flatnonzero((inner > height[:-2]) & (inner >= height[2:]) & (inner > height.max() / 20))
        for top in tops.tolist():
            x = self.length[top : top + 1]
            near = self.terms.rows(np.abs(self.terms.length - x) < 2 * math.pi / (self.k_max - self.k_min))
            strength = np.abs(peak_of_each(near, x, self.k_min, self.k_max)[0])
            for n in np.argsort(-strength)[:most].tolist():
                code = _FAMILY if near.orbit[n] < 0 else str(self.codes[near.orbit[n]])
                times, half = divmod(int(near.repetitions[n]), int(near.parts[n]))
                of_term = times + half / 2 if half else times, float(near.length[n]), float(strength[n])
                yield Peak(float(x[0]), float(height[top]), code, *of_term)


def _parts(values: Complexes) -> tuple[list[float], list[float]]:
    return values.real.tolist(), values.imag.tolist()


BLOCK = 1 << 20


def reach(k_min: float, k_max: float) -> float:
    """Return the distance from its centre, in units of the radius, beyond which a peak is below 1e-5."""
    return 30 * math.pi / (k_max - k_min)


def of_levels(
    k: Floats, x: Floats, k_min: float, k_max: float, stadium: Stadium, parity: Parity | None = None
) -> Complexes:
    """Return F at the lengths x, shape (n,), from all levels k between `k_min` and `k_max`."""
    inside = k[(k > k_min) & (k < k_max)]
    nodes, weights = _quadrature(x, k_min, k_max)
    smooth = weights * weyl(stadium, parity).deriv()(nodes)
    return _transform(inside, _window(inside, k_min, k_max), x) - _transform(nodes, smooth, x)


def of_terms(terms: Terms, x: Floats, k_min: float, k_max: float) -> Complexes:
    """Return F from terms, at lengths x in ascending order, shape (n,)."""
    total = np.zeros(len(x), np.complex128)
    far = reach(k_min, k_max)
    ordered = terms.rows(np.argsort(terms.length))
    for first in range(0, len(x), _POINTS):
        lengths = x[first : first + _POINTS]
        low, high = np.searchsorted(ordered.length, [lengths[0] - far, lengths[-1] + far])
        step = BLOCK // len(lengths)
        for at in range(low, high, step):
            some = ordered.rows(np.arange(at, min(at + step, high)))
            total[first : first + len(lengths)] += peak_of_each(some, lengths, k_min, k_max).sum(axis=1)
    return total


_POINTS = 64


def peak_of_each(terms: Terms, x: Floats, k_min: float, k_max: float) -> Complexes:
    """Return the contribution of each term to F at each of the lengths x, shape (n, N)."""
    at, length, amplitude = x[:, None], terms.length, terms.amplitude
    below, above = _peak(at - length, k_min, k_max), _peak(at + length, k_min, k_max)
    return (below * amplitude.conj() + above * amplitude) / 2


def _peak(y: Floats, k_min: float, k_max: float) -> Complexes:
    """Return the integral of w(k) exp(i k y) in closed form, because w is a sum of cosines."""
    width = k_max - k_min
    z = width * y / (2 * math.pi)
    sides = (np.sinc(z - 1) + np.sinc(z + 1)) / 4 + (np.sinc(z - 2) + np.sinc(z + 2)) / 16
    return np.asarray(width * (3 / 8 * np.sinc(z) + sides) * np.exp(1j * (math.pi * z + k_min * y)))


def of_family(
    stadium: Stadium, x: Floats, k_min: float, k_max: float, parity: Parity | None = None
) -> Complexes:
    """Return the contribution of the bouncing-ball orbits (`family`) to F, at lengths x."""
    k, weights = _quadrature(x, k_min, k_max)
    balls = family(stadium, k, x[-1] + reach(k_min, k_max), parity)
    return _transform(k, weights * sum((wave.real for _, wave in balls), np.zeros_like(k)), x)


def _window(k: Floats, k_min: float, k_max: float) -> Floats:
    return np.sin(math.pi * (k - k_min) / (k_max - k_min)) ** 4


def _quadrature(x: Floats, k_min: float, k_max: float) -> tuple[Floats, Floats]:
    """Return nodes in k_min..k_max that resolve the oscillations exp(i k x), and weights with the window."""
    half = (k_max - k_min) / 2
    count = math.ceil(half * (2 * float(np.abs(x).max()) + reach(k_min, k_max))) + 100
    nodes, weights = np.polynomial.legendre.leggauss(count)
    k = k_min + (nodes + 1) * half
    return k, weights * half * _window(k, k_min, k_max)


def _transform(k: Floats, weights: Floats | Complexes, x: Floats) -> Complexes:
    """Return the sum of weights times exp(i k x) at each x."""
    parts = np.array_split(x, max(1, len(x) * len(k) // BLOCK))
    return np.concatenate([np.exp(1j * part[:, None] * k) @ weights for part in parts])
