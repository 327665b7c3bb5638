"""Errors of numbers computed from given directions, measured in ball arithmetic, and their bounds."""

from functools import cache

import numpy as np
from flint import arb, ctx

from orbitdb.billiard import legs, stability
from orbitdb.billiard.legs import Legs, cut, derivatives, direction_limits, gradient_rounding
from orbitdb.billiard.stability import exponent
from orbitdb.orbits import error_bounds as bounds
from orbitdb.orbits.ball_path import BallPath, Balls
from orbitdb.orbits.newton import newton
from orbitdb.symbols.words import from_strings, parse

BITS = 200

Floats = np.ndarray
Errors = dict[str, Floats]


def chain(word: str) -> tuple[Floats, Legs]:
    """Return the symbols and the legs of a word in run notation."""
    symbols = from_strings([parse(word)])
    ((_, found),) = cut(symbols)
    return symbols, found


def path_at(word: str, a: float, alpha: Floats) -> BallPath:
    """Return the path with the given directions, shape (m, 1), in ball arithmetic."""
    _, found = chain(word)
    low, high = (limit[:, 0].tolist() for limit in direction_limits(found, a))
    path = BallPath(found, 0, a, list(zip(low, high, strict=True)))
    path.go_to([arb(x) for x in alpha[:, 0].tolist()])
    return path


@cache
def maximum(word: str, a: float) -> BallPath:
    """Return the path that maximises the length, to far more digits than double precision has."""
    with ctx.workprec(BITS):
        path = path_at(word, a, newton(chain(word)[1], a).alpha)
        path.climb()
        path.widen()
        return path


def slacks_of(path: BallPath) -> list[Balls]:
    """Recompute the slacks of `orbitdb.billiard.legs.slacks`; they are 0 for a leg without walls."""
    half_pi, (first, last) = arb.pi() / 2, path.ends()
    found: list[Balls] = [[half_pi - abs(t) for t in ends] for ends in (first, last)]
    for sign, ends in ((-1, last), (1, first[1:] + first[:1])):
        found.append([])
        for s, parity, alpha, t in zip(path.s, path.parity, path.alpha, ends, strict=True):
            joint = sign * s * t * (parity if sign > 0 else 1)
            found[-1].append(half_pi - 2 * s * alpha + joint)
    return found


def apart(balls: Balls, numbers: Floats) -> Floats:
    """Return upper bounds on the distances of numbers from the points in balls."""
    return np.array([float(abs(x - y).abs_upper()) for x, y in zip(balls, numbers.tolist(), strict=True)])


def errors_of(path: BallPath, word: str, a: float, alpha: Floats) -> Errors:
    """Return the errors of all numbers computed at directions alpha, compared with those of a path."""
    _, own = chain(word)
    slopes = derivatives(own, a, alpha)
    slack = legs.slacks(own, alpha)[:, :, 0]
    with ctx.workprec(BITS):
        there = np.isfinite(slack)
        slack = np.where(there, slack, 0)
        return {
            "gradient": apart(path.gradient, slopes.gradient[:, 0]),
            "direction": apart(path.alpha, alpha[:, 0]),
            "slack": there * [apart(*each) for each in zip(slacks_of(path), slack, strict=True)],
            "place": apart(path.coordinates(own), legs.coordinates(own, a, alpha)[0]),
            "length": apart([path.length()], legs.length(own, a, alpha)),
            "lambda": apart([path.exponent()], stability.exponent(slopes)),
        }  # fmt: skip


def bounds_of(word: str, a: float, alpha: Floats, moved: Floats | None = None) -> Errors:
    """Return the bounds on the errors at directions alpha; `moved` gives those on the directions."""
    _, own = chain(word)
    slopes = derivatives(own, a, alpha)
    direction = bounds.direction_errors(own, a, alpha, slopes) if moved is None else moved
    slack = legs.slack_errors(own, direction)
    return {
        "gradient": gradient_rounding(own, a, alpha)[:, 0],
        "direction": direction[:, 0],
        "slack": slack[:, :, 0],
        "place": bounds.coordinate_error(own, a, alpha, direction, slack),
        "length": bounds.length_error(own, a, alpha, slopes, direction),
        "lambda": bounds.lambda_error(own, slopes, direction, exponent(slopes)),
    }


def share(error: Floats, bound: Floats) -> float:
    """Return the largest ratio of an error to its bound."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(error > 0, error / bound, 0.0).max())
