"""Every term of every error bound is needed by some row, and each row comes close to its bound.

Well-solved orbits would satisfy bounds of half the size. Directions are therefore moved deliberately here, or
rounded as badly as the bounds allow, and the resulting error is measured in ball arithmetic. Each
row names the terms without which it would fail.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from bound_errors import (
    BITS,
    Floats,
    apart,
    bounds_of,
    chain,
    errors_of,
    maximum,
    path_at,
    share,
    slacks_of,
)
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st
from solutions import random_word

from orbitdb.billiard import legs, stability
from orbitdb.billiard.legs import add_up, direction_limits
from orbitdb.orbits.ball_path import BallPath
from orbitdb.orbits.balls import distance


@dataclass(frozen=True)
class Row:
    """A word with directions away from its maximum, and how close an error comes to its bound.

    `shift` is added to the directions of the maximum. If `at` is given, it contains the directions, and the
    true path is `shift` away, for bounds that hold between any two paths.
    """

    needs: str
    number: str
    word: str
    a: float
    shift: tuple[float, ...]
    at_least: float
    at: tuple[float, ...] | None = None

    def paths(self) -> tuple[Floats, BallPath]:
        """Return directions in doubles, and the path they approximate."""
        shift = np.array(self.shift)[:, None]
        with ctx.workprec(BITS):
            if self.at is not None:
                alpha = np.array(self.at)[:, None]
                return alpha, path_at(self.word, self.a, alpha + shift)
            found = maximum(self.word, self.a)
        middle = np.array([[float(x.mid())] for x in found.alpha])
        return np.clip(middle + shift, *direction_limits(chain(self.word)[1], self.a)), found


def rows_of(rows: "Sequence[Row | Rounded]") -> pytest.MarkDecorator:
    return pytest.mark.parametrize("row", rows, ids=lambda row: f"{row.number}: {row.needs}")


LIMIT = "4^100 0 3^100 0"
"""At a = 0.001 its second leg is clamped at a limit, and D of its first leg drops to a tenth on the way."""


@rows_of([
    Row("a bound at all, of this size", "direction", "1^5 3", 60, (1e-5, -1e-5), 0.99),
    Row("the same", "slack", "1^5 3", 60, (1e-5, -1e-5), 0.99),
    Row("the same", "place", "1^5 3", 60, (1e-5, -1e-5), 0.99),
    Row("slope of D", "direction", LIMIT, 0.001, (-0.23, 0), 0.9),
    Row("first bound with half of D", "direction", LIMIT, 0.001, (-0.37, 0), 0.9),
    Row("a loss of up to a half", "direction", LIMIT, 0.001, (-0.485, 0), 0.9),
    Row("curvature of D", "direction", LIMIT, 0.001, (-1.5, 0), 0.7),
    Row("sum of the energies", "direction", "1 02 3", 0.18, (-0.0012, 0.0015), 0.9),
    Row("energies beside the share", "direction", "1 3^100 (02)^5", 0.0014, (-0.157, 0.0647), 0.2),
    Row("root of D in the energy", "direction", "4^1000 (20)^25 3 (20)^12", 8.7, (-0.01, 0.0003), 0.9),
])  # fmt: skip
def test_bounds_hold_and_are_sharp_for_moved_directions(row):
    alpha, path = row.paths()
    found = share(errors_of(path, row.word, row.a, alpha)[row.number],
                  bounds_of(row.word, row.a, alpha)[row.number])  # fmt: skip
    assert row.at_least <= found <= 1


@rows_of([
    Row("a bound at all, of this size", "length", "4^3 2 5^3", 0.353, (1e-7, -1e-7), 0.99),
    Row("start of a leg", "place", "4^1000 3 0", 7000, (-1e-5, 0), 0.6),
    Row("end of a leg", "place", "4^100 20 3^3", 4400, (0, -1e-4), 0.9),
    Row("points on walls", "place", "1 3 2", 8400, (-3e-5, 0), 0.9),
    Row("square of the shift", "place", "1 0 3 0202", 10, (0, -0.4), 0.7),
    Row("the orbit's own direction", "place", "1 3^3 2", 38, (0, 0.07), 0.5),
    Row("first bounce of a run", "place", "1^1000 3", 3900, (0, 1e-4), 0.9),
    Row("last bounce of a run", "place", "4^1000 3", 2400, (-4e-4, 0), 0.9),
])  # fmt: skip
def test_bounds_from_known_direction_errors_hold_and_are_sharp(row):
    """Bounds on derived numbers follow from bounds on directions that are as sharp as possible."""
    alpha, path = row.paths()
    errors = errors_of(path, row.word, row.a, alpha)
    found = share(
        errors[row.number], bounds_of(row.word, row.a, alpha, errors["direction"][:, None])[row.number]
    )
    assert row.at_least <= found <= 1


BENT, PLAIN = "1^1000 3^1000", "1^3 2 3^3 1^3 3^3"


@rows_of([
    *(Row(f"leg {i}", "slack", PLAIN, 1, tuple(0.1 * (i == j) for j in range(4)), 0.99, (-0.1, 0.2, 0.3, 0.1))
      for i in range(4)),
    Row("a bound at all, of this size", "lambda", BENT, 100, (1e-4, 0), 0.99, (0, 0)),
    Row("both neighbours of a kick", "lambda", BENT, 100, (0, 1e-4), 0.99, (0, 0)),
    Row("slope of D", "lambda", BENT, 0.05, (0.01, -0.01), 0.8, (1.4, -1.4)),
    Row("a logarithm is no share", "lambda", BENT, 0.05, (0.1, -0.1), 0.5, (1.4, -1.4)),
    Row("none where the share is all", "lambda", BENT, 0.05, (-1.5, 0), 0.0, (1.52, 0.1)),
    Row("curvature of D", "lambda", "1^1000 0 5^1000 2", 1, (-0.4, 0.4), 0.8, (-0.785, 0.785)),
])  # fmt: skip
def test_bounds_between_any_two_paths_hold_and_are_sharp(row):
    alpha, path = row.paths()
    errors = errors_of(path, row.word, row.a, alpha)
    moved = np.abs(np.array(row.shift))[:, None]
    found = share(errors[row.number], bounds_of(row.word, row.a, alpha, moved)[row.number])
    assert row.at_least <= found <= 1


def test_lambda_has_no_bound_if_a_drift_may_vanish():
    alpha = np.array([[1.52], [0.1]])
    assert bounds_of(BENT, 0.05, alpha, np.array([[1.5], [0.0]]))["lambda"] == [np.inf]


class Worse:
    """NumPy with sine, cosine and arcsinh rounded up or down by as much as the bounds assume."""

    def __init__(self, sin: int, cos: int, arcsinh: int = 0):
        self.ways = {"sin": sin, "cos": cos, "arcsinh": arcsinh}
        self.sin, self.cos, self.arcsinh = (np.vectorize(getattr(self, f"_{name}")) for name in self.ways)

    def __getattr__(self, name):
        return getattr(np, name)

    def _sin(self, x):
        return self._rounded(arb.sin, x, self.ways["sin"])

    def _cos(self, x):
        return self._rounded(arb.cos, x, self.ways["cos"])

    def _arcsinh(self, x):
        found, way = self._rounded(arb.asinh, x, self.ways["arcsinh"]), self.ways["arcsinh"]
        return found + way * math.ulp(found)

    def _rounded(self, function, x, way: int) -> float:
        with ctx.workprec(BITS):
            ball = function(arb(float(x)))
            nearest = float(ball.mid())
            short = way and (ball - nearest) * way > 0
        return math.nextafter(nearest, way * math.inf) if short else nearest


@dataclass(frozen=True)
class Rounded:
    """Exact directions at which a number is rounded badly; sine, cosine and arcsinh are rounded by `ways`."""

    needs: str
    number: str
    word: str
    a: float
    at: tuple[float, ...]
    ways: tuple[int, ...]
    at_least: float


THREE = "1^100 3^100"


@rows_of([
    Rounded("half of it", "gradient", THREE, 100,
            (-0.010624600206115898, 4.335243776896203e-05), (-1, 1), 0.5),
    Rounded("2 a sin", "gradient", THREE, 1000, (9.135327181584386e-05, 0.0010544132586688738), (1, 1), 0.5),
    Rounded("2 n cos", "gradient", "1^100 02 3^100", 1e-6,
            (-0.9648505143887937, -0.8175234887194154), (-1, -1), 0.5),
    Rounded("cos h", "gradient", THREE, 0.001, (-0.7846466360655182, 0.2042671009535748), (-1, 1), 0.5),
    Rounded("psi", "gradient", "1 3", 1e-6, (-0.4806353341982239, -0.6248070503396271), (-1, 1), 0.2),
    Rounded("the run before", "gradient", "1 3^100", 1e-6,
            (-0.5619364154203851, -0.6379654146872857), (-1, 1), 0.2),
    Rounded("the run after", "gradient", "1^100 3", 1e-6,
            (-0.4420352499582879, -0.5650069324642752), (-1, 1), 0.2),
    Rounded("rounding", "slack", "1^100 02 3^100", 1e-6,
            (-0.7531507820019611, -1.0336867629126791), (0, 0), 0.1),
    Rounded("less of it in a run of one", "slack", "1 2 3 0", 0.001,
            (-1.3772022248253821, 1.0301157818431674), (0, 0), 0.4),
    Rounded("rounding", "place", THREE, 1e-6, (-0.314961210007239, -0.49705335305161924), (0, 0), 0.1),
    Rounded("rounding on walls", "place", "1 3^10 (02)^500", 83_900,
            (1.1406607189250922e-05, -0.02151949584452008), (0, 0), 0.05),
    Rounded("a leg's terms", "length", "1 3", 1000,
            (-0.0010624996001793072, -0.00044692994914263123), (-1, -1), 0.2),
    Rounded("2 n sin", "length", "1 (20)^500 3 (20)^500", 0.01,
            (1.569785252873019, 1.5699152298836947), (-1, -1), 0.1),
    Rounded("2 k sin h", "length", "1 3", 1e-6,
            (9.406174278997005e-05, -9.403160359025805e-05), (-1, -1), 0.2),
    Rounded("cos h", "length", "1^5 3^5", 0.001, (1.5682505870328263, 1.568929210349655), (0, 0), 0.1),
    Rounded("psi", "lambda", "1 3", 0.001, (1.5698551506022105, 1.5686897211386468), (1, 0), 0.02),
    Rounded("every run and leg", "lambda", "(1 3)^10", 350, (0,) * 20, (1, 1, 1), 0.2),
    Rounded("the last function", "lambda", THREE, 350, (0, 0), (1, 1, 1), 0.4),
])  # fmt: skip
def test_bounds_hold_and_are_sharp_for_the_worst_rounding(row, monkeypatch):
    alpha = np.array(row.at)[:, None]
    for module in (legs, stability):
        monkeypatch.setattr(module, "np", Worse(*row.ways))
    with ctx.workprec(BITS):
        path = path_at(row.word, row.a, alpha)
    errors = errors_of(path, row.word, row.a, alpha)
    monkeypatch.undo()
    found = share(errors[row.number], bounds_of(row.word, row.a, alpha, np.zeros_like(alpha))[row.number])
    assert row.at_least <= found <= 1


def test_balls_enclose_a_distant_maximum():
    """D drops to a tenth on the way, so a bound with the initial D would be too small."""
    row = Row("", "", LIMIT, 0.001, (-0.485, 0), 0)
    alpha, found = row.paths()
    with ctx.workprec(BITS):
        path = path_at(row.word, row.a, alpha)
        path.widen()
        assert all(ball.contains(x.mid()) for ball, x in zip(path.alpha, found.alpha, strict=True))
        assert float(path.alpha[0].rad()) < 10 * 0.485


def test_a_distance_from_a_ball_is_rounded_up():
    with ctx.workprec(BITS):
        ball = arb(1) + arb(2) ** -60
        assert arb(distance(ball, 0.0)) >= ball


def test_sums_over_long_words_are_within_their_bounds(monkeypatch):
    """NumPy's sums satisfy their bound, and the length satisfies its bound even with the worst such sums."""
    rng = np.random.default_rng(0)
    for m in (3, 7, 20, 128, 1000, 20_000):
        terms = rng.uniform(1, 2) * np.ones((m, 1)) + rng.choice([0, 1e-3]) * rng.random((m, 1))
        exact = math.fsum(terms[:, 0].tolist())
        assert abs(add_up(terms)[0] - exact) <= legs.summation_rounding(m) * exact
    word, a = "(1 3)^500", 1000.0
    alpha = np.zeros((1000, 1))
    worst = (20 + math.log2(1000)) / 2**53
    monkeypatch.setattr(legs, "add_up", lambda rows: np.array([math.fsum(rows[:, 0].tolist()) * (1 + worst)]))
    with ctx.workprec(BITS):
        path = path_at(word, a, alpha)
        error = apart([path.length()], legs.length(chain(word)[1], a, alpha))
    assert 0.5 < share(error, bounds_of(word, a, alpha, alpha)["length"]) <= 1


@given(seed=st.integers(0, 10**6), order=st.integers(3, 25), a=st.floats(-6, 6), size=st.floats(-16, 0))
def test_no_bound_is_smaller_than_the_error(seed, order, a, size):
    """This holds for any word whose directions are moved by any amount in any way."""
    word, a, rng = random_word(seed, order), 10**a, np.random.default_rng(seed)
    path = maximum(word, a)
    row = Row("", "", word, a, tuple(10**size * rng.choice([-1, 1, 0, rng.random()], path.m)), 0)
    alpha, _ = row.paths()
    errors, allowed = errors_of(path, word, a, alpha), bounds_of(word, a, alpha)
    for number in ("direction", "slack", "length", "lambda"):
        assert share(errors[number], allowed[number]) <= 1, number
    if (legs.slacks(chain(word)[1], alpha) > 0).all() and all(
        x > 0 for each in slacks_of(path)[:2] for x in each
    ):
        assert share(errors["place"], allowed["place"]) <= 1
