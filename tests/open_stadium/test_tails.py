"""The tails of survival: published constants, and survival far out."""

import numpy as np
import pytest

from orbitdb import Stadium
from orbitdb.open_stadium.flight import OpenStadium
from orbitdb.open_stadium.openings import parse_openings
from orbitdb.open_stadium.patterns import patterns_of
from orbitdb.open_stadium.survival import Stops, sample
from orbitdb.open_stadium.tails import tails

STADIUM = Stadium(1.6)


def left(opening=(), without=(), a=1.6):
    return tails(Stadium(a), parse_openings(opening), patterns_of(without))


@pytest.mark.parametrize(
    ("opening", "without", "c1"),
    [
        ("top:-0.3:0.3", (), 0.24304),
        ("top:0.1:0.2", (), 0.34874),
        ("right:-0.1:0.1", (), 4.18257),
        (["right:1.27:", "right::-1.27"], (), 0.73630),
        ("right:1.27:", (), 1.21305),
        ((), ["33"], 2.85986),
        ((), ["212"], 2.08398),
        ((), ["020"], 0),
    ],
)
def test_constants(opening, without, c1):
    assert left(opening, without).c1 == pytest.approx(c1, abs=5e-6)


@pytest.mark.parametrize(("a", "low", "high"), [(1.6, -0.3, 0.3), (0.5, -0.1, 0.4), (3, 1, 2)])
def test_one_hole_has_the_constant_of_dettmann_and_georgiou(a, low, high):
    c1 = (4 + 3 * np.log(3)) * ((a + low) ** 2 + (a - high) ** 2) / (8 * Stadium(a).perimeter)
    assert left(f"top:{low}:{high}", a=a).c1 == pytest.approx(c1, rel=1e-14)


def test_constants_of_runs_and_time():
    assert left("top::").c2 == pytest.approx(0.20372, abs=5e-6)
    assert left("top:-0.3:0.3").d1 == pytest.approx(0.41133, abs=5e-6)
    assert left((), ["44"]).c2 == pytest.approx(left("top::").c2 * 3 / 4, rel=1e-14)
    assert left("right:-0.1:0.1").c2 < left("top::").c2


def test_holes_in_both_walls_leave_the_gaps_between_their_projections():
    assert left(["top:-0.5:0", "bottom:-0.1:0.2"]).gaps == ((-1.6, -0.5), (0.2, 1.6))
    assert left("top::").gaps == left((), ["2020"]).gaps == ()
    assert left("right:-0.1:0.1").uncut
    assert not left("top:-0.3:0.3").uncut


@pytest.mark.parametrize(
    ("opening", "without", "mirrored", "unturned"),
    [
        ("right:1.27:", ["030"], "left::-1.27", ["212"]),
        ("top:0.1:0.2", ["2330"], "bottom:-0.2:-0.1", ["0442"]),
    ],
)
def test_mirrored_openings_agree(opening, without, mirrored, unturned):
    """Turned by half a turn; a run that goes up on one side then goes down on the other."""
    one, other = left(opening, without), left(mirrored, unturned)
    assert one.c1 == pytest.approx(other.c1, rel=1e-14)
    assert one.c2 == pytest.approx(other.c2, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "opening", "without"),
    [
        (0.7, ["right:0.9:"], []),
        (1, ["bottom:-0.5:-0.2", "left:1:"], []),
        (1, [], ["0442", "030"]),
    ],
)
def test_survival_ends_in_the_tail(a, opening, without):
    stadium = Stadium(a)
    known = tails(stadium, parse_openings(opening), patterns_of(without))
    far = np.array([3000.0])
    counts = sample(
        OpenStadium.of(stadium, parse_openings(opening), without),
        Stops(far, far, np.ones(1)), 700_000, np.random.SeedSequence(5),
    )  # fmt: skip
    survived = counts.bounces[1] / counts.bounces[0]
    assert survived == pytest.approx(known.c1 / 3000, abs=4 * np.sqrt(survived / 700_000) + 0.04 * survived)
    in_time, error = counts.time[1] / counts.time[0], np.sqrt(counts.squares[1]) / counts.time[0]
    assert in_time == pytest.approx(known.d1 / 3000, abs=4 * error + 0.04 * in_time)
