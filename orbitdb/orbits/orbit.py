"""One word in a given stadium, with its orbit if it has one."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard import stability
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Drawn
from orbitdb.errors import InputError
from orbitdb.magnetic.action import area_slopes
from orbitdb.orbits.status import Status
from orbitdb.svg import MOST_BOUNCES, orbit_svg
from orbitdb.symbols.plane import symbol_plane
from orbitdb.symbols.pruning import FAMILY, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import (
    AXIS,
    ELEMENT_OF,
    QUARTER_SIGNS,
    REVERSE,
    STABILISER_OF,
    act_on_area,
    act_on_coordinates,
    act_on_words,
    half_of,
)
from orbitdb.symbols.words import from_strings, least_rotation, to_strings
from orbitdb.text import format_float, shortened

_SHOWN = 40


class _WhenAsked:
    """A value of an orbit: given, or read by a function when it is first asked for; arrays are read-only."""

    def __set_name__(self, orbits: type, name: str) -> None:
        self._kept = f"_{name}"

    def __get__(self, orbit: Any, kind: type | None = None) -> Any:
        if orbit is None:
            return None  # the default of the field
        if callable(orbit.__dict__[self._kept]):
            orbit.__dict__[self._kept] = orbit.__dict__[self._kept]()
        value = orbit.__dict__[self._kept]
        if isinstance(value, np.ndarray):
            value = value.view()
            value.flags.writeable = False
        return value

    def __set__(self, orbit: Any, value: Any) -> None:
        orbit.__dict__[self._kept] = value


@dataclass(frozen=True, eq=False, repr=False)
class Orbit(Drawn):
    """A word in a given stadium, with its orbit if it has one.

    Two of them are equal if they have the same cyclic word, in any rotation, and the same a. `plot` draws the
    orbit in its stadium, as in the paper's Fig. 1.

    Attributes
    ----------
    code : str
        The word in the requested rotation.
    representative : str
        The representative of its symmetry class; for a pruned word, its least rotation.
    a : float
        Half length of the stadium.
    status : Status
        The status of the word; numbers that the status leaves undefined are None.
    rules : tuple of int
        The geometric rules that the word breaks.
    time_reversal : str or None
        ``self`` or ``pair``.
    symmetry : str or None
        The elements that map the cyclic word to itself, or ``1`` if only the identity does.
    class_size : int or None
        Number of cyclic words in the symmetry class.
    length, lyapunov, margin, residual, error, length_error, lyapunov_error : float or None
        As in `Orbits`.
    area, area_error : float or None
        Area that one traversal encloses, (1/2) integral of (x dy - y dx), and a bound on its error, in
        radius^2. Anticlockwise is positive. The reverse and the mirror images have the opposite area, so it
        is 0 for a word that time reversal or a single mirror maps to itself.
    coordinates : ndarray, shape (p,), or None
        Coordinates in the order of ``code``; read-only, so that an orbit can be a dictionary key. An orbit
        of a `Subset` reads these and `exists` from the file when they are asked for.
    solver : str or None
        ``newton``, or ``relaxation`` for the paper's method; None for a word that is not solved.
    stored : bool
        Whether the orbit was read from a catalogue; otherwise it was solved on request.
    exists : tuple of (float, float or None), or None
        The ranges of a in which the word is an orbit, if the catalogue contains the births of its period, or
        if they were requested from `orbitdb.solve_word`.
    """

    code: str
    representative: str
    a: float
    status: Status
    rules: tuple[int, ...] = ()
    time_reversal: str | None = None
    symmetry: str | None = None
    class_size: int | None = None
    length: float | None = None
    lyapunov: float | None = None
    margin: float | None = None
    residual: float | None = None
    error: float | None = None
    length_error: float | None = None
    lyapunov_error: float | None = None
    area: float | None = None
    area_error: float | None = None
    solver: str | None = None
    stored: bool = False
    if TYPE_CHECKING:
        coordinates: Floats | None = None
        exists: tuple[tuple[float, float | None], ...] | None = None
    else:
        coordinates: Any = _WhenAsked()
        exists: Any = _WhenAsked()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_coordinates": self.coordinates, "_exists": self.exists}

    @property
    def p(self) -> int:
        """The period, that is, the number of bounces."""
        return len(self.code)

    @property
    def walls(self) -> int:
        """Number of bounces on the straight walls."""
        return self.code.count("0") + self.code.count("2")

    @property
    def maslov(self) -> int | None:
        """Maslov index of one traversal, 3p - walls, or None if the word has no symmetry class."""
        return None if self.class_size is None else 3 * self.p - self.walls

    @property
    def half(self) -> str | None:
        """The symmetry that makes the second half of the orbit the image of the first, if any.

        It is ``x``, ``y`` or ``xy``; for the word 13 it is ``x``, because ``y`` leaves its bounces in place.
        In the quarter stadium x, y >= 0, the orbit closes after half of its length.
        """
        return half_of(self.symmetry or "")

    @property
    def quarter_length(self) -> float | None:
        """Length of one traversal in the quarter stadium x, y >= 0: L / 2 if there is a `half`, else L."""
        return None if self.length is None else self.length / (2 if self.half else 1)

    @property
    def quarter_lyapunov(self) -> float | None:
        """Lambda of one traversal in the quarter stadium: lambda / 2 if there is a `half`, else lambda."""
        return None if self.lyapunov is None else self.lyapunov / (2 if self.half else 1)

    @property
    def quarter_maslov(self) -> int | None:
        """Maslov index of one traversal in the quarter stadium: `maslov` / 2 if there is a `half`."""
        return None if self.maslov is None else self.maslov // (2 if self.half else 1)

    @property
    def quarter_signs(self) -> list[int] | None:
        """Signs of one traversal in the quarter stadium for the parities ee, eo, oe and oo."""
        return None if self.class_size is None else list(QUARTER_SIGNS[self.half])

    @property
    def quarter_orientations(self) -> int | None:
        """Number of ways to traverse the orbit in the quarter stadium: 1 if it retraces its path there, or 2.

        It is 1 for the word 13, which lies on an axis.
        """
        if self.class_size is None or self.representative == AXIS:
            return self.class_size
        return self.class_size * (2 if self.half else 1) // 4

    @property
    def lambda_d(self) -> float | None:
        """Lambda per bounce, or None if there is no orbit."""
        return None if self.lyapunov is None else self.lyapunov / self.p

    @property
    def lambda_c(self) -> float | None:
        """Lambda per unit length, in 1/radius, or None if there is no orbit."""
        return None if self.lyapunov is None or self.length is None else self.lyapunov / self.length

    @property
    def lambda_c_error(self) -> float | None:
        """Bound on the error of `lambda_c`, or None if there is no orbit or no bound."""
        if self.lyapunov is None or self.length is None or self.lambda_c is None:
            return None
        if self.lyapunov_error is None or self.length_error is None:
            return None
        return error_of_quotient(self.lambda_c, self.length, self.lyapunov_error, self.length_error)

    def amplitude(self, k: float, repetitions: int = 1) -> float | None:
        """Return the contribution of this cyclic word to the density of levels at wavenumber k.

        Parameters
        ----------
        k : float
            Wavenumber, in 1/radius.
        repetitions : int, optional
            The number of traversals, r.

        Returns
        -------
        float or None
            (L / pi) cos(r (k L - maslov pi / 2)) / sqrt|det(M^r - 1)|, in units of the radius, or None if
            there is no orbit.

        Raises
        ------
        InputError
            If the number of traversals is less than one.

        Notes
        -----
        This is a term of Gutzwiller's trace formula. If the reverse is another word, it contributes the same
        amount.
        """
        if repetitions < 1:
            raise InputError(f"{repetitions} repetitions: give 1 or more")
        if self.length is None or self.lyapunov is None or self.maslov is None:
            return None
        decay = math.exp(-repetitions * self.lyapunov)  # the root is exp(r lambda / 2) (1 -+ decay)
        root = 1 + decay if repetitions * self.walls % 2 else 1 - decay
        phase = repetitions * (k * self.length - self.maslov * math.pi / 2)
        shrunk = math.exp(-repetitions * self.lyapunov / 2)  # the decay itself may be too small for a double
        return self.length * shrunk * math.cos(phase) / (math.pi * root)

    @property
    def points(self) -> Floats | None:
        """Cartesian coordinates of the bounces, shape (p, 2), or None if there is no orbit."""
        if self.coordinates is None:
            return None
        return Stadium(self.a).points(from_strings([self.code])[0], self.coordinates)

    @property
    def arclength(self) -> Floats | None:
        """Positions of the bounces along the boundary, shape (p,) (`Stadium.arclength`), or None."""
        return None if self.coordinates is None else self._in_phase_space()[0]

    @property
    def sine(self) -> Floats | None:
        """Sines of the angles between the outgoing path and the normal at each bounce, shape (p,), or None.

        They are positive if the path goes anticlockwise.
        """
        return None if self.coordinates is None else self._in_phase_space()[1]

    def _in_phase_space(self) -> tuple[Floats, Floats]:
        arclength, sine = stability.birkhoff(Stadium(self.a), from_strings([self.code]), self._one_row())
        return arclength[0], sine[0]

    def _one_row(self) -> Floats:
        assert self.coordinates is not None
        return self.coordinates[None, :]

    @property
    def symbol_plane(self) -> Floats | None:
        """The points (gamma, delta) of the bounces in the symbol plane, shape (p, 2).

        A dynamically pruned word has them too (`orbitdb.symbols.plane`). None for a word that breaks a rule.
        """
        return None if self.class_size is None else symbol_plane(from_strings([self.code]))[0]

    @property
    def monodromy(self) -> Floats | None:
        """Monodromy matrix of (d theta, d y), starting just after the last bounce, shape (2, 2), or None.

        It is the product of the matrices of Biham and Kvale, eqs. (3) and (4), as corrected in
        `orbitdb.billiard.stability`. Its entries lose digits as lambda grows; `trace` does not. Beyond the
        range of doubles, lambda > 709, both are infinite.
        """
        if self.coordinates is None:
            return None
        factors = stability.bounce_matrices(Stadium(self.a), from_strings([self.code]), self._one_row())[0]
        product, doublings = stability.product_of(factors.transpose(1, 2, 0)[..., None])
        with np.errstate(over="ignore"):
            return np.ldexp(product, doublings)[..., 0]

    @property
    def trace(self) -> float | None:
        """Trace of the monodromy matrix, with modulus 2 cosh(lambda), negative if `walls` is odd."""
        if self.lyapunov is None:
            return None
        with np.errstate(over="ignore"):
            return float(np.exp(self.lyapunov) + np.exp(-self.lyapunov)) * (-1.0) ** self.walls

    @property
    def area_slope(self) -> float | None:
        """Derivative of the enclosed area in the curvature of the path, at zero, in radius^3, or None.

        In a weak magnetic field, S = L - kappa area - kappa^2 area_slope / 2 is the action.
        """
        if self.coordinates is None:
            return None
        return float(area_slopes(Stadium(self.a), from_strings([self.code]), self._one_row())[0])

    def reverse(self) -> "Orbit":
        """Return the time-reversed orbit, which traverses the same path in the opposite direction."""
        return self._image(REVERSE)

    def images(self) -> "tuple[Orbit, ...]":
        """Return all orbits of the symmetry class, this one first; for a pruned word, only itself."""
        if not self.symmetry:
            return (self,)
        elements = ELEMENT_OF[STABILISER_OF[self.symmetry], : self.class_size]
        return tuple(self._image(g) for g in elements.tolist())

    def _image(self, element: int) -> "Orbit":
        word, coordinates = from_strings([self.code]), self.coordinates
        if coordinates is not None:
            coordinates = act_on_coordinates(element, word, self._one_row())[0].copy()
        code = to_strings(act_on_words(element, word))[0]
        least = self.representative if self.class_size else least_rotation(code)
        area = None if self.area is None else act_on_area(element, self.area)
        return replace(self, code=code, representative=least, coordinates=coordinates, area=area)

    def __eq__(self, other: object) -> bool:
        """Tell whether both have the same cyclic word, in any rotation, and the same a."""
        if not isinstance(other, Orbit):
            return NotImplemented
        return self.a == other.a and least_rotation(self.code) == least_rotation(other.code)

    def __hash__(self) -> int:
        return hash((self.a, least_rotation(self.code)))

    def __repr__(self) -> str:
        code = self.code if self.p <= _SHOWN else f"{self.code[:_SHOWN]}... of {self.p} bounces"
        if self.length is None or self.lyapunov is None:
            return f"<Orbit {code} at a = {format_float(self.a)}: {self.status.sentence}>"
        numbers = f"length {self.length:.7f}, lambda {self.lyapunov:.7f}"
        return f"<Orbit {code} at a = {format_float(self.a)}: {numbers}>"

    def _repr_svg_(self) -> str | None:
        """Return the orbit as SVG for notebooks; None if there is no orbit or it is very long."""
        if self.points is None or self.p > MOST_BOUNCES:
            return None
        title = f"The orbit {self.code} at a = {format_float(self.a)}"
        return orbit_svg(Stadium(self.a), self.points, self.code, title)

    _FIGURES = ("orbit",)

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        if self.points is None:
            raise InputError(
                f"{self.code:.40} at a = {format_float(self.a)} cannot be drawn: {self.status.sentence}"
            )
        return (Stadium(self.a), self.points, self.code), shortened(self.code)


def error_of_quotient(lambda_c: Any, length: Any, lyapunov_error: Any, length_error: Any) -> Any:
    """Return a bound on the error of lambda_c, the rounded quotient of lambda and length, in 1/radius.

    All four are numbers, arrays, or columns of SQL, and so is the bound.
    """
    worst = (lyapunov_error + lambda_c * length_error) / (length - length_error)
    return 1.000001 * (worst + 1.2e-16 * lambda_c)


def pruned_words(words: Iterable[str], a: float) -> dict[str, Orbit]:
    """Return those of some primitive words that are geometrically pruned or the family 02."""
    periods: dict[int, list[str]] = {}
    for word in dict.fromkeys(words):
        periods.setdefault(len(word), []).append(word)
    pruned = {}
    for group in periods.values():
        masks = rules_broken(from_strings(group))
        for row in np.flatnonzero(masks).tolist():
            least, rules = least_rotation(group[row]), rule_numbers(int(masks[row]))
            status, broken = (Status.FAMILY, ()) if least == FAMILY else (Status.GEOMETRIC, tuple(rules))
            pruned[group[row]] = Orbit(group[row], least, a, status, broken)
    return pruned


def pruned_word(word: str, a: float) -> Orbit | None:
    """Return a primitive word that is geometrically pruned or the family 02; None for any other word."""
    return pruned_words([word], a).get(word)
