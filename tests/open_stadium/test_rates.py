"""The rates of the transfer matrix: without openings, against simulations, and where they are not defined."""

import numpy as np
import pytest

from orbitdb import Stadium, escape
from orbitdb.open_stadium import rates
from orbitdb.open_stadium.flight import OpenStadium
from orbitdb.open_stadium.openings import parse_openings
from orbitdb.open_stadium.survival import Stops, sample
from orbitdb.open_stadium.transfer import GridLegs
from orbitdb.trajectories.ensemble import advance, random_arcs, stays


def legs_of(a, opening=(), without=(), grid=40):
    return GridLegs.of(OpenStadium.of(Stadium(a), parse_openings(opening), without), grid)


@pytest.mark.parametrize("a", [0.5, 1.6])
def test_leg_probabilities(a):
    """A leg has n walls with probability r_(n+1) - 2 r_n + r_(n-1), where r_n = sqrt(a^2 + n^2)."""
    far = np.hypot(a, np.arange(2000))
    exact = np.array([far[1] - a, *(far[2:] - 2 * far[1:-1] + far[:-2])])
    assert exact.sum() == pytest.approx(1, abs=1e-3 * a)
    assert np.arange(len(exact)) @ exact == pytest.approx(a, rel=1e-3 * a)
    arcs = random_arcs(400_000, np.random.default_rng(3))
    walls = advance(arcs, a).walls[~stays(arcs)]
    for n in range(5):
        share = (walls == n).mean()
        assert share == pytest.approx(exact[n], abs=5 * np.sqrt(exact[n] / len(walls)))


def test_closed_stadium_loses_no_leg():
    legs = legs_of(1.6, without=["00"], grid=60)
    assert legs.lost == 0
    assert legs.growth(1.0, np.ones(legs.size))[0] == pytest.approx(0, abs=1e-3)
    share = legs.share / legs.share.sum()
    assert share @ legs.bounces == pytest.approx(1.6 + np.pi / 2, rel=0.02)
    assert share @ legs.path == pytest.approx(np.pi * Stadium(1.6).area / 4, rel=0.02)


@pytest.mark.slow
def test_rates_of_the_hole_in_the_middle():
    found = escape(1.6, "top:-0.3:0.3", trajectories=0)
    assert found.rate_leg == pytest.approx(0.11657, rel=0.004)
    assert found.rate_time == pytest.approx(0.01807, rel=0.005)
    assert found.rate_leg == pytest.approx(0.11657, abs=2 * (found.rate_leg_error or 0))
    assert found.n_tail == pytest.approx(148, abs=2)
    at, rate = found.n_tail or 0, found.rate_bounce or 0
    assert found.c1 / at + found.c2 / at**2 == pytest.approx(np.exp(-at * rate), rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "opening", "without"),
    [
        (1, ["left:0.2:0.7"], []),  # one step at a time would be wrong here
        pytest.param(0.5, ["bottom:-0.1:0.3", "right:1:"], [], marks=pytest.mark.fuzz),
        pytest.param(1, ["top:0:0.2"], ["131"], marks=pytest.mark.fuzz),
    ],
)
def test_rate_per_leg_is_the_simulated_one(a, opening, without):
    stadium = Stadium(a)
    open_stadium = OpenStadium.of(stadium, parse_openings(opening), without)
    rows = Stops(np.ones(1), np.ones(1), np.arange(1.0, 100))
    legs = sample(open_stadium, rows, 500_000, np.random.SeedSequence(2)).legs
    first = np.searchsorted(-legs / legs[0], -0.3)
    gone = legs[first] - legs[-1]
    rate = -np.log1p(-gone / legs[first:-1].sum())
    found = escape(a, opening, without, trajectories=0)
    assert found.rate_leg == pytest.approx(rate, abs=found.rate_leg_error + 3 * rate / np.sqrt(gone))


@pytest.mark.parametrize(
    ("opening", "without", "why"),
    [
        ("right:-0.1:0.1", (), "no rate per time or bounce: the bouncing-ball family is not cut"),
        ("right::", (), "no rates: the bouncing-ball family is not cut"),
        ("top::", (), "no rate per bounce: it would be above 0.15"),
        ((), "00", "no rates: too few of the points"),
    ],
)
def test_rates_that_are_not_defined_say_why(opening, without, why, monkeypatch):
    monkeypatch.setattr(rates, "GRIDS", (40, 60))
    monkeypatch.setattr(rates, "GRIDS_WITH_STATES", (40, 60))
    assert any(why in note for note in escape(1.6, opening, without, trajectories=0).notes)
