"""The conditions on a stored orbit and their tolerances, evaluated bounce by bounce in plain Python.

The formulas are those in the docstrings of `orbitdb.verification.invariants`, but none of its code is used,
and no array except the Hessian.
"""

import sys
from dataclasses import dataclass
from functools import lru_cache
from math import acosh, cos, exp, hypot, inf, log, pi, sin, sqrt, tanh

import numpy as np

EPS = sys.float_info.epsilon
VAGUE = 1e-2


@dataclass(frozen=True)
class Row:
    """A stored row; `word` contains the symbols 0..5, and `x` the coordinates."""

    a: float
    word: tuple[int, ...]
    x: tuple[float, ...]
    boundary: bool
    length: float
    lyapunov: float
    margin: float
    residual: float
    error: float
    length_error: float
    lyapunov_error: float


@dataclass(frozen=True)
class Bounce:
    """A bounce: path lengths, cosines and sines on arrival and departure, and error bounds on the angles."""

    curved: bool
    cosines: tuple[float, float]
    paths: tuple[float, float]
    sines: tuple[float, float]
    tilts: tuple[float, float]
    along: tuple[float, float]


def place(a: float, symbol: int, x: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the position of a bounce, and the tangent along which its coordinate increases."""
    if symbol in (0, 2):
        return (x, symbol - 1.0), (1.0, 0.0)
    side = 1 if symbol in (3, 5) else -1
    return (side * (a + cos(x)), sin(x)), (-side * sin(x), cos(x))


@lru_cache(maxsize=1)
def bounces(row: Row) -> list[Bounce]:
    """Return all bounces of a row."""
    p, e = len(row.word), off(row)
    places = [place(row.a, symbol, x) for symbol, x in zip(row.word, row.x, strict=True)]
    steps = [tuple(places[(i + 1) % p][0][k] - places[i][0][k] for k in (0, 1)) for i in range(p)]
    paths = [hypot(*step) for step in steps]
    found = []
    for i in range(p):
        along, curved = places[i][1], row.word[i] not in (0, 2)
        around = (paths[i - 1], paths[i])
        before, behind = (
            sum(along[k] * step[k] for k in (0, 1)) / path
            for step, path in zip((steps[i - 1], steps[i]), around, strict=True)
        )
        sines = (sqrt(max(1 - before**2, EPS**2)), sqrt(max(1 - behind**2, EPS**2)))
        arriving, leaving = (
            2 * e / path + (e if curved else 0) + 4 * EPS / s for path, s in zip(around, sines, strict=True)
        )
        found.append(Bounce(curved, (before, behind), around, sines, (arriving, leaving), along))
    return found


def rounding(row: Row) -> float:
    """Return how far rounding may move a position on the table."""
    return 4 * EPS * (row.a + 2)


def off(row: Row) -> float:
    """Return how far a bounce may be from its exact position on the orbit."""
    return row.error + rounding(row)


def walls(row: Row) -> tuple[float, float]:
    """Return how far the worst bounce is beyond its wall, or out of order in its run, and the tolerance."""
    margin = least_margin(row)
    beyond = abs(margin) if row.boundary else -margin
    back = [
        (row.x[i] - row.x[(i + 1) % len(row.x)]) * (-1 if s >= 4 else 1)
        for i, s in enumerate(row.word)
        if s not in (0, 2) and s == row.word[(i + 1) % len(row.x)]
    ]
    return max(beyond, *back, 0.0), off(row)


def least_margin(row: Row) -> float:
    """Return the signed distance of the worst bounce from the nearest end of its wall."""
    ends = (row.a if s in (0, 2) else pi / 2 for s in row.word)
    return min(end - abs(x) for end, x in zip(ends, row.x, strict=True))


def reflection(row: Row) -> tuple[float, float]:
    """Return the force and its tolerance at the bounce where their ratio is largest."""
    pairs = [
        (abs(b.cosines[0] - b.cosines[1]), sum((s + t) * t for s, t in zip(b.sines, b.tilts, strict=True)))
        for b in bounces(row)
    ]
    return max(pairs, key=lambda pair: pair[0] / pair[1])


def residuals(row: Row) -> tuple[float, float]:
    """Return the difference between the residual and the largest force, and its tolerance."""
    found = bounces(row)
    force = max(abs(b.cosines[0] - b.cosines[1]) for b in found)
    shortest = min(path for b in found for path in b.paths)
    return abs(row.residual - force), 4 * rounding(row) / shortest + 8 * EPS


def stretches(row: Row) -> list[float]:
    """Return the error bound on the length of the link after each bounce."""
    return [2 * off(row) + 4 * EPS * b.paths[1] for b in bounces(row)]


def diagonal(row: Row) -> list[tuple[float, float, float]]:
    """Return sin^2 / l of both links at each bounce, the sines if curved, and their error bound."""
    stretch, entries = stretches(row), []
    for i, b in enumerate(bounces(row)):
        own = loose = 0.0
        for s, t, path, longer in zip(b.sines, b.tilts, b.paths, (stretch[i - 1], stretch[i]), strict=True):
            own += s**2 / path
            loose += (2 * s * t + t**2) / path + s**2 / path * longer / path
        entries.append((own, sum(b.sines) * b.curved, loose + sum(b.tilts) * b.curved))
    return entries


def couplings(row: Row) -> list[tuple[float, float]]:
    """Return sin sin' / l of the link after each bounce, and the error bound of (cos cos' - t . t') / l."""
    found, stretch, entries = bounces(row), stretches(row), []
    for i, b in enumerate(found):
        other, path = found[(i + 1) % len(found)], b.paths[1]
        coupling = b.sines[1] * other.sines[0] / path
        angles = b.sines[1] * b.tilts[1] + other.sines[0] * other.tilts[0]
        loose = (angles + 2 * off(row) + 4 * EPS) / path + coupling * stretch[i] / path
        entries.append((coupling, loose))
    return entries


def lengths(row: Row) -> tuple[float, float]:
    """Return the difference between the length and the sum of the links, and its tolerance near an orbit."""
    paths = [b.paths[1] for b in bounces(row)]
    firm = sum(own + sines + loose for own, sines, loose in diagonal(row))
    firm += sum(2 * (coupling + loose) for coupling, loose in couplings(row))
    beside = sum(2 * rounding(row) + 4 * EPS * path for path in paths)
    return abs(row.length - sum(paths)), row.length_error + row.error**2 * firm + beside


def exponents(row: Row) -> tuple[float, float]:
    """Return lambda from kicks and drifts between the feet of the centres, and its error bound."""
    found, stretch = bounces(row), stretches(row)
    p = len(found)
    sines = [sum(b.sines) / 2 if b.curved else 0.0 for b in found]
    angles = [max(b.tilts) if b.curved else 0.0 for b in found]

    def exponent(shift: int) -> float:
        m = ((1.0, 0.0), (0.0, 1.0))
        for i in range(p):
            after = (i + 1) % p
            loose = stretch[i] + angles[i] + angles[after]
            drift = max(found[i].paths[1] - sines[i] - sines[after] + shift * loose, 0.0)
            kick = 2 / max(sines[i] - shift * angles[i], 1e-9 * sines[i]) if found[i].curved else 0.0
            (a, b), (c, d) = m
            a, b, c, d = a + b * kick, b, c + d * kick, d
            m = ((a, b + a * drift), (c, d + c * drift))
        return acosh(max(m[0][0] + m[1][1], 2.0) / 2)

    least, middle, greatest = map(exponent, (-1, 0, 1))
    return middle, max(greatest - middle, middle - least) + 12 * p * EPS + 4 * EPS * middle


def lambdas(row: Row) -> tuple[float, float] | None:
    """Return the error of lambda compared with the bounces, and its tolerance; None if too uncertain."""
    middle, spread = exponents(row)
    return (
        (abs(row.lyapunov - middle), row.lyapunov_error + spread) if spread < VAGUE * (1 + middle) else None
    )


def determinant(row: Row) -> tuple[bool, float, float] | None:
    """Tell whether the Hessian's signature is wrong; compare ln |det H| with lambda.

    Also returns their difference and its tolerance. Returns None if an eigenvalue could have either sign.
    """
    p, found = len(row.word), bounces(row)
    entries, beside = diagonal(row), couplings(row)
    scale = [1 / sqrt(own + sines) for own, sines, _ in entries]
    matrix, links = np.zeros((p, p)), []
    for i, b in enumerate(found):
        k = (i + 1) % p
        dot = sum(u * v for u, v in zip(b.along, found[k].along, strict=True))
        links.append((b.cosines[1] * found[k].cosines[0] - dot) / b.paths[1] * scale[i] * scale[k])
        diagonal_of_it = sum(s**2 / path for s, path in zip(b.sines, b.paths, strict=True))
        matrix[i, i] += (diagonal_of_it - sum(b.sines) * b.curved) * scale[i] ** 2
        matrix[i, k] += links[i]
        matrix[k, i] += links[i]
    values = np.linalg.eigvalsh(matrix).tolist()
    around = [[own * scale[i] * scale[(i + 1) % p] for own in beside[i]] for i in range(p)]
    norm = max(entries[i][2] * scale[i] ** 2 + around[i][1] + around[i - 1][1] for i in range(p))
    norm += 4 * p * EPS * max(1 + around[i][0] + around[i - 1][0] for i in range(p))
    if min(map(abs, values)) <= 2 * norm:
        return None
    straights = sum(s in (0, 2) for s in row.word)
    sign = -1 if straights % 2 else 1
    trace = row.lyapunov + 2 * log(abs(1 - sign * exp(-row.lyapunov)))  # ln |tr M - 2|
    differ = sum(log(abs(v)) for v in values) - sum(log(abs(b)) for b in links) - trace
    allowed = 2 * norm * sum(1 / abs(v) for v in values) + sum(loose / own for own, loose in beside)
    allowed += 8 * p * EPS + tanh(row.lyapunov / 2) ** -sign * row.lyapunov_error
    return sum(v > 0 for v in values) != straights, abs(differ), allowed


def checked(row: Row) -> dict[str, tuple[int, float, float]]:
    """Return, for each check, the number of rows checked, the deviation and its share of the tolerance."""
    distances = {
        "walls": walls(row),
        "margins": (abs(row.margin - least_margin(row)), off(row)),
        "reflection": reflection(row),
        "residuals": residuals(row),
        "lengths": lengths(row),
        "lambda": lambdas(row),
    }
    hessian = determinant(row)
    distances["Hessian"] = hessian and hessian[1:]
    found = {
        name: (0, 0.0, 0.0) if each is None else (1, each[0], each[0] / each[1] if each[0] else 0.0)
        for name, each in distances.items()
    }
    return found | {"signature": (int(hessian is not None), inf if hessian and hessian[0] else 0.0, 0.0)}
