"""For thousands of rows, the stored bounds exceed the true errors, and the errors are small."""

from collections.abc import Iterable
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
import reference
from quick import slow_but
from solutions import real, representatives, solved, words_of
from there import there

from orbitdb.billiard.legs import centre_directions, cut, derivatives
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.admissible import solve_in_doubles
from orbitdb.orbits.balls import enclose, true_errors
from orbitdb.orbits.error_bounds import steepness
from orbitdb.orbits.least_values import (
    largest_least_length,
    least_exponent,
    least_length,
    least_limit_of_lengths,
)
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.solve import solve, solve_word
from orbitdb.orbits.status import Status
from orbitdb.symbols.words import from_strings, parse, to_strings

VALUES = [0.5, 1.6, 5.0]


def test_rounding_may_hide_that_a_direction_is_not_pressed():
    """A gradient that pushes outward by less than its rounding may point inward; a larger one cannot."""
    ((_, legs),) = cut(from_strings(["0103"]))
    slopes = derivatives(legs, 1.6, centre_directions(legs, 1.6))
    slopes = replace(slopes, gradient=np.array([[1e-17], [-0.5]]))
    rounding, yes, no = np.full((2, 1), 3e-16), np.full((2, 1), True), np.full((2, 1), False)
    assert steepness(slopes, yes, rounding)[:, 0].tolist() == [3e-16 - 1e-17, 0.0]
    assert steepness(slopes, no, rounding)[:, 0].tolist() == [3e-16 + 1e-17, 0.5 + 3e-16]


def sample(p: int, a: float, count: int) -> Orbits:
    """A random choice of orbits of one period."""
    orbits = solved(p, a) if p < 10 else solve(representatives(p), Stadium(a))
    return orbits.rows(np.random.default_rng(p).permutation(np.flatnonzero(real(orbits)))[:count])


def check_bounds(orbits: Orbits, errors: Iterable[np.ndarray]) -> None:
    """Check the errors of coordinates, length, lambda and, if given, the area, one of each per orbit."""
    for name, error in zip(("error", "length_error", "lyapunov_error", "area_error"), errors, strict=False):
        assert (error <= getattr(orbits, name)).all(), (name, to_strings(orbits.words))


def enclosed_errors(orbits: Orbits, a: float) -> np.ndarray:
    return true_errors(orbits, [enclose(word, Stadium(a)) for word in orbits.words])


@pytest.mark.parametrize("a", slow_but([1.6], VALUES))
@pytest.mark.parametrize("p", slow_but((2, 3, 4, 5, 7), range(2, 12)))
def test_bounds_hold_and_errors_are_small_compared_with_fifty_digits(p, a):
    """The reference is Newton's method in mpmath on all p coordinates, with lambda from p bounces."""
    orbits = sample(p, a, 8)

    def errors_of(row: int) -> list[float]:
        word, places = to_strings(orbits.words[row : row + 1])[0], orbits.coordinates[row].tolist()
        exact = reference.refine(word, a, places)
        with mp.workdps(reference.DIGITS):
            others = (orbits.length[row], exact.length), (orbits.lyapunov[row], exact.lyapunov)
            farthest = max(abs(mp.mpf(x) - y) for x, y in zip(places, exact.coordinates, strict=True))
            return [float(farthest), *(float(abs(mp.mpf(float(x)) - y)) for x, y in others)]

    errors = np.transpose([errors_of(row) for row in range(len(orbits))])
    check_bounds(orbits, errors)
    assert (errors < 1e-13 * np.stack([np.ones(len(orbits)), orbits.length, orbits.lyapunov])).all()


@pytest.mark.parametrize("a", slow_but([1e-3, 0.1, 1e3], [1e-6, 1e-3, 0.1, 1.0, 30.0, 1e3, 1e6]))
def test_bounds_hold_at_any_a(a):
    for p in (2, 4, 5, 7, 8):
        orbits = sample(p, a, 15)
        check_bounds(orbits, enclosed_errors(orbits, a))


@pytest.mark.parametrize("tolerance", slow_but([1e-2, 1e-8], [1e-2, 1e-4, 1e-8]))
def test_bounds_hold_for_rough_solutions(tolerance):
    """The bounds follow from concavity and do not need a solution nearby."""
    worst = 0.0
    for p in (3, 5, 6, 7):
        orbits = solve(representatives(p), Stadium(1.6), tolerance)
        orbits = orbits.rows(np.flatnonzero(real(orbits))[:40])
        errors = enclosed_errors(orbits, 1.6)
        check_bounds(orbits, errors)
        worst = max(worst, errors[0].max())
    assert worst > 1e-12


@pytest.mark.parametrize("a", VALUES)
def test_bounds_are_not_much_larger_than_necessary(a):
    """They can decide a status, and are at most 10^4 times the errors for all words up to p = 8."""
    for p in range(2, 9):
        orbits = solved(p, a)
        found = real(orbits)
        assert orbits.error[found].max() < 1e-12
        assert (orbits.length_error / orbits.length)[found].max() < 1e-14
        assert (orbits.lyapunov_error / orbits.lyapunov)[found].max() < 1e-13


@pytest.mark.parametrize(
    "text",
    [
        "(13)^300 3",
        "1^1000 2 5^1000 0",
        "1 (20)^500 3 (02)^500",
        "1^20 (02)^5 3",
        "(1 2 3 0 2)^100 1 3",
        "(1 2 3 2)^99 1 3 1 3",
    ],
)
@pytest.mark.parametrize("a", slow_but([0.3], [0.3, 1.6, 20.0]))
def test_bounds_hold_for_long_words(text, a):
    orbits = solve_in_doubles(from_strings([parse(text)] * 2), Stadium(a))
    exact = enclose(orbits.words[0], Stadium(a))
    assert {*orbits.status} <= {exact.status, Status.UNRESOLVED}
    found = orbits.rows(orbits.status == Status.ORBIT)
    check_bounds(found, true_errors(found, [exact] * len(found)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "margin"),
    [
        ("12(02)^200000 32(02)^200000", 2.50000020685093e-12),
        ("12(02)^45000 32(02)^135002", 2.03207708426649e-34),
    ],
)
def test_steep_legs_are_not_clamped_at_their_limits(text, margin):
    """At a = 1e-6 the limits are within 1e-11 of pi/2. The second margin was computed with 70 digits."""
    orbits = solve(from_strings([parse(text)]), Stadium(1e-6))
    assert orbits.status[0] == Status.ORBIT
    assert orbits.margin[0] == pytest.approx(margin, rel=1e-4, abs=0)


@pytest.mark.parametrize("a", slow_but([0.05, 1.6], [1e-3, 0.05, 0.3, 1.0, 1.6, 3.0, 12.0, 1e4]))
def test_longer_words_exceed_the_least_lambda_and_length(a):
    least = []
    for p in range(3, 9):
        orbits = solve(words_of(p), Stadium(a))
        real = orbits.status == "orbit"
        least.append((orbits.lyapunov[real].min(), orbits.length[real].min()))
    for p, (exponent, length) in enumerate(np.minimum.accumulate(least[::-1])[::-1], 2):
        assert 0 < least_exponent(p, a) < exponent
        assert 0 < least_length(p, a) < length


def test_the_least_lambda_and_length_are_useful():
    """At a = 1.6 they are within a twelfth of the true minima, 6.075 at p = 12 and 12.35 at p = 9."""
    assert least_exponent(11, 1.6) > 5.57
    assert least_length(8, 1.6) > 11.5
    assert least_length(8, 0.02) > 5.2


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.02, 0.3, 1.0, 1.6, 12.0])
def test_the_least_length_has_a_limit_below_the_perimeter(a):
    bounds, limit = [least_length(p, a) for p in (4, 20, 80, 160)], largest_least_length(a)
    assert bounds == sorted(bounds)
    assert limit * (1 - 1e-3) < bounds[-1] <= limit < least_limit_of_lengths(a)


@pytest.mark.parametrize("a", [0.02, 1.6, 20.0])
def test_infinitely_many_orbits_are_shorter_than_the_perimeter(a):
    lengths = [there(solve_word("3" * k + "4" * k, a).length) for k in (2, 3, 10, 60)]
    assert lengths == pytest.approx([4 * a + 4 * k * np.sin(np.pi / 2 / k) for k in (2, 3, 10, 60)])
    assert lengths == sorted(lengths)
    assert lengths[-1] < least_limit_of_lengths(a) < lengths[-1] + 1e-3


@pytest.mark.parametrize("a", [0.05, 0.5, 1.6, 20.0])
def test_the_least_lambda_comes_from_the_least_kicks_and_drifts(a):
    """Any number of runs and legs is taken, each at its worst over the angles that the docstring allows."""
    share = np.linspace(0, 1, 4001)[1:]

    def least(k, n):
        kick = (2 * k / np.sin(share * np.pi / 2 / max(k - 1, 1))).min()
        low = np.arctan((n - 1) / (a + 1)) if n else -np.arctan(1 / a)
        angle = low + np.linspace(0, 1, 4001) * (np.arctan((n + 1) / a) - low)
        return np.log1p(kick * (2 * a * np.cos(angle) + 2 * n * np.sin(angle)).min())

    most = 9
    alone = [min((least(k, b - k) for k in range(1, b + 1)), default=np.inf) for b in range(most)]
    several = [np.inf] * most
    for b in range(2, most):
        several[b] = min(alone[i] + min(alone[b - i], several[b - i]) for i in range(1, b))
    for p in range(2, 6):
        assert least_exponent(p, a) == pytest.approx(min(several[p + 1 :]), rel=1e-6)
