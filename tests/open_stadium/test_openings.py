"""Openings: how they are written, what is refused, and the share of the boundary that they open."""

import math

import pytest

from orbitdb import InputError, Stadium, escape
from orbitdb.open_stadium.openings import measure, parse_openings

STADIUM = Stadium(1.6)


@pytest.mark.parametrize(
    ("opening", "why"),
    [
        ("top:0.3:0.3", "is empty"),
        ("top:0.3:-0.3", "is reversed"),
        ("top:0:1.7", "goes beyond its wall, where x is from -1.6 to 1.6"),
        ("right:0:1.6", "goes beyond its semicircle"),
        ("bottom:2:3", "goes beyond its wall"),
        ("side:0:1", "write WALL:LOW:HIGH"),
        ("top:0.3", "write WALL:LOW:HIGH"),
        ("top:a:b", "write WALL:LOW:HIGH"),
        ("top:nan:1", "has no numbers"),
        (["top::", "bottom::", "left::", "right::"], "all of the boundary is open"),
        ((), "nothing is opened"),
        (7, "write WALL:LOW:HIGH"),
    ],
)
def test_bad_opening_gets_one_line(opening, why):
    with pytest.raises(InputError, match=why) as caught:
        escape(1.6, opening, trajectories=0)
    assert "\n" not in str(caught.value)


def test_measure_counts_what_overlaps_once():
    whole, half = parse_openings(["top:-0.5:0.2", "top:0:0.5"]), parse_openings("right:0:")
    assert measure(STADIUM, whole) == pytest.approx(1 / STADIUM.perimeter, rel=1e-15)
    assert measure(STADIUM, half) == pytest.approx(math.pi / 2 / STADIUM.perimeter, rel=1e-15)
    assert measure(STADIUM, parse_openings("right:0:1.5708")) == measure(STADIUM, half)


def test_opening_reads_back_as_it_is_written():
    openings = parse_openings(["right:0.1:", "top:-0.3:0.3", "top:-0.3:0.3"])
    assert [*map(str, openings)] == ["top:-0.3:0.3", "right:0.1:"]
    assert parse_openings(map(str, openings)) == openings
