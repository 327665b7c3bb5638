"""Sampled survival: known numbers, and a bounce map of its own that goes bounce by bounce."""

import numpy as np
import pytest

from orbitdb import Stadium, escape
from orbitdb.billiard.stadium import written
from orbitdb.open_stadium import rates
from orbitdb.open_stadium.flight import OpenStadium
from orbitdb.open_stadium.openings import parse_openings
from orbitdb.open_stadium.patterns import Patterns
from orbitdb.open_stadium.survival import Stops, rows_to, sample, survival_of

CASES = [
    (1.6, ["top:-0.3:0.3"], []),
    (1, ["left:0.2:0.7", "bottom:0.5:1"], []),
    (0.3, ["right:-1:1"], []),
    (1.6, [], ["020"]),
    (1, ["top:-1:-0.8"], ["11", "355"]),
]


def sampled(a, opening, without, n, last=100, seed=1):
    stadium = Stadium(a)
    rows = Stops.up_to(stadium, last)
    opened = OpenStadium.of(stadium, parse_openings(opening), without)
    return survival_of(rows, sample(opened, rows, n, np.random.SeedSequence(seed)))


def paths(a, n, bounces, rng):
    """Follow random bounces by elementary geometry: x, y and side of each, shape (n, bounces + 2)."""
    curved = rng.random(n) < np.pi / (np.pi + 2 * a)
    sign, along = rng.choice([-1.0, 1.0], n), rng.uniform(-1, 1, n)
    angle = rng.uniform(-np.pi / 2, np.pi / 2, n)
    nx, ny = np.where(curved, sign * np.cos(angle), 0), np.where(curved, np.sin(angle), sign)
    x, y, side = np.where(curved, nx + sign * a, along * a), ny, np.where(curved, sign, 0)
    sine = rng.uniform(-1, 1, n)
    cosine = np.sqrt(1 - sine**2)
    back = hit(a, x, y, -cosine * nx + sine * ny, -cosine * ny - sine * nx)
    vx, vy = -cosine * nx - sine * ny, -cosine * ny + sine * nx
    rows = [back[:3], (x, y, side)]
    for _ in range(bounces):
        x, y, side, vx, vy = hit(a, x, y, vx, vy)
        rows.append((x, y, side))
    return [np.stack(part, axis=1) for part in zip(*rows, strict=True)]


def hit(a, x, y, vx, vy):
    """Return the next bounce: where the path leaves the walls or the circles, on the boundary."""
    best, side = np.full(len(x), np.inf), np.zeros(len(x))
    wall = np.sign(vy)
    t = (wall - y) / vy
    best = np.where(np.abs(x + t * vx) <= a, t, np.inf)
    for end in (-1.0, 1.0):
        along, off = (x - end * a) * vx + y * vy, (x - end * a) ** 2 + y**2 - 1
        t = -along + np.sqrt(np.maximum(along**2 - off, 0))
        there = (best == np.inf) & (t > 0) & (along**2 >= off) & (end * (x + t * vx) >= a - 1e-12)
        best, side = np.where(there, t, best), np.where(there, end, side)
    x_new, y_new = x + best * vx, np.where(side == 0, wall, y + best * vy)
    nx, ny = np.where(side == 0, 0, x_new - side * a), y_new
    dot = vx * nx + vy * ny
    vx, vy = vx - 2 * dot * nx, vy - 2 * dot * ny
    return x_new, y_new, side, vx / np.hypot(vx, vy), vy / np.hypot(vx, vy)


def survivors(a, opening, without, n, bounces, seed):
    """Return the share of trajectories that survive 1, 2, ... bounces."""
    x, y, side = paths(a, n, bounces, np.random.default_rng(seed))
    symbols, coordinates = written(Stadium(a), x, y, side)  # one bounce at each end is context
    out = np.zeros(symbols.shape, bool)
    for one in parse_openings(opening):
        walls = {"top": (2,), "bottom": (0,), "left": (1, 4), "right": (3, 5)}[one.wall]
        out |= np.isin(symbols, walls) & (coordinates >= one.low) & (coordinates <= one.high)
    for pattern in without:
        digits = np.array([*map(int, pattern)])
        for end in range(len(digits), symbols.shape[1] + 1):
            out[:, end - 1] |= (symbols[:, end - len(digits) : end] == digits).all(axis=1)
    return 1 - np.maximum.accumulate(out, axis=1).mean(axis=0)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_survival_agrees_with_another_map(case):
    agree(case, 20_000, 30)


@pytest.mark.fuzz
@pytest.mark.parametrize("case", CASES[1:2], ids=str)
def test_survival_of_a_million_agrees_with_another_map(case):
    agree(case, 1_000_000, 20)


def agree(case, n, last):
    a, opening, without = case
    found = sampled(a, opening, without, n=2 * n, last=last)[0]
    own = survivors(a, opening, without, n=n, bounces=last, seed=7)[found.at.astype(int) - 1]
    error = np.sqrt(np.maximum(own * (1 - own), 1 / n) / n)
    assert (np.abs(found.survival - own) < 4.5 * np.hypot(error, found.error)).all()


@pytest.mark.slow
def test_known_numbers():
    bounce, time, leg = sampled(1.6, ["top:-0.3:0.3"], [], n=200_000)
    assert bounce.survival[0] == pytest.approx(0.95269, abs=4 * bounce.error[0])  # 1 - mu, exactly
    assert bounce.survival[-1] == pytest.approx(0.01417, abs=4 * bounce.error[-1])
    assert time.survival[-1] == pytest.approx(0.1526, abs=4 * time.error[-1])
    assert (np.diff(leg.survival) < 0).all()
    bounce, *_ = sampled(1.6, [], ["020"], n=100_000)
    assert bounce.survival[bounce.at == 50] == pytest.approx(0.1907, abs=4 * bounce.error[bounce.at == 50][0])


@pytest.mark.slow
def test_errors_are_those_of_the_scatter():
    found = [sampled(1.6, ["top:-0.3:0.3"], [], n=2000, last=20, seed=seed) for seed in range(60)]
    for kind in range(3):
        scatter = np.std([one[kind].survival for one in found], axis=0)
        assert found[0][kind].error == pytest.approx(scatter, rel=0.45)


def test_walls_by_table_are_walls_one_by_one():
    patterns = Patterns(("0202", "2012", "33"))
    for start in range(len(patterns.states)):
        for top in range(2):
            state, number = start, 0
            for number in range(1, 30):
                state = patterns.step[state, 2 * ((top + number - 1) % 2)]
                if state < 0:
                    break
                after, fatal = patterns.cross(np.array([start]), np.array([top]), np.array([float(number)]))
                assert (after[0], fatal[0]) == (state, np.inf)
            after, fatal = patterns.cross(np.array([start]), np.array([top]), np.array([40.0]))
            assert fatal[0] == (number if state < 0 else np.inf)


def test_extreme_stadiums(monkeypatch):
    monkeypatch.setattr(rates, "GRIDS", (20, 30))
    for a in (1e-6, 1e6):
        found = escape(a, "left:0:0.5", trajectories=300, bounces=20)
        assert found.columns()["survival"][0] == pytest.approx(1 - found.measure, abs=0.1)
    assert {*found.columns("leg")["survival"]} <= {None, 0.0, 1.0}  # no leg may have begun


def test_same_seed_same_numbers_and_rows_of_any_length(monkeypatch):
    monkeypatch.setattr(rates, "GRIDS", (20, 30))
    assert rows_to(2000)[-4:] == [200, 500, 1000, 2000]
    assert rows_to(3) == [1, 2, 3]
    one, again, other = (escape(1, "top::", trajectories=5000, bounces=7, seed=seed) for seed in (1, 1, 2))
    assert one.columns() == again.columns() != other.columns()
    assert one.columns("time")["t"] == one.columns()["n"] == [1, 2, 5, 7]
