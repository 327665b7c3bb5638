"""Run time of each method against its true error."""

from collections import Counter
from time import perf_counter

import numpy as np
import pytest

from orbitdb.benchmarks.work_precision import (
    ball_rows,
    newton_rows,
    relaxation_rows,
    root_rows,
    sample,
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.admissible import certificates
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives
from orbitdb.symbols.pruning import count_admissible


@pytest.fixture(scope="module")
def cases():
    return sample(5, Stadium(1.0))


def test_a_sample_is_spread_over_all_classes():
    words, sizes = representatives(7)
    few = sample(7, Stadium(), 10)
    assert len(few.words) == len(few.truth) == 10
    np.testing.assert_array_equal(few.words[[0, -1]], words[[0, -1]])
    assert sizes.sum() == count_admissible(7)


@pytest.mark.parametrize(("measure", "setting"), [(newton_rows, 1e-16), (ball_rows, 128)])
def test_newton_and_balls_are_charged_once_per_class(cases, measure, setting):
    begin = perf_counter()
    (row,) = measure(cases, (setting,))
    assert 0 < row.seconds * row.words < perf_counter() - begin
    assert row.failures == 0
    assert row.coordinates_max < 1e-14
    assert row.seconds * row.words == pytest.approx(row.seconds_per_sequence * count_admissible(5), abs=0)


def test_only_orbits_are_measured_and_boundary_words_are_not_failures():
    """At a = 1, seven words of period 6 run through a joint."""
    every = sample(6, Stadium(1.0))
    (row,) = newton_rows(every, (1e-16,))
    assert Counter(each.status for each in every.truth)[Status.BOUNDARY] == 7
    assert row.failures == 0
    solved = solve(every.words, every.stadium)
    orbits = [n for n, each in enumerate(every.truth) if each.status is Status.ORBIT]
    for name in ("length", "lyapunov"):
        values = getattr(solved, name)
        off = [abs(float(getattr(every.truth[n], name) - values[n])) / values[n] for n in orbits]
        shown = getattr(row, f"{name}_max"), getattr(row, f"{name}_median")
        assert shown == pytest.approx((max(off), np.median(off)), rel=1e-6, abs=0)
    (row,) = ball_rows(every, (64,))
    found = [each for each in certificates(every.words, every.stadium, 64) if each.status is Status.ORBIT]
    radii = [max(float(x.rad()) for x in each.coordinates) for each in found]
    assert (row.coordinates_max, row.coordinates_median) == (max(radii), np.median(radii))
    for name in ("length", "lyapunov"):
        balls = [getattr(each, name) for each in found]
        assert getattr(row, f"{name}_max") == max(float(ball.rad() / ball.mid()) for ball in balls)
    one, two, *_ = orbits
    every.truth[one], every.truth[two] = every.truth[two], every.truth[one]
    assert next(newton_rows(every, (1e-16,))).failures == 2


def test_balls_report_radii_that_shrink_with_the_bits(cases):
    rows = list(ball_rows(cases, (64, 128)))
    assert rows[0].coordinates_max < 1e-15
    assert rows[1].coordinates_max < 1e-30
    assert rows[0].failures == rows[1].failures == 0


def test_a_root_finder_is_judged_by_the_orbit_it_finds(cases):
    begin = perf_counter()
    loose, tight = root_rows(cases.part(8), (1e-4, 1e-10))
    assert 0 < (loose.seconds + tight.seconds) * 8 < perf_counter() - begin
    assert tight.coordinates_max < 1e-7 < loose.coordinates_max
    assert tight.words == loose.words == 8
    (some,) = root_rows(sample(5, Stadium(0.3)), (1e-10,))  # it also solves pruned words
    assert some.failures == 0 < some.coordinates_max < 1e-7


def test_relaxation_continues_to_smaller_forces_and_is_charged_from_the_start(cases):
    few = cases.part(6)
    begin = perf_counter()
    rows = list(relaxation_rows(few, (1e-8, 1e-3, 1e-6)))
    assert rows[-1].seconds * len(few.words) < perf_counter() - begin
    assert [row.setting for row in rows] == [1e-3, 1e-6, 1e-8]
    for name in ("seconds", "coordinates_max", "length_max"):
        values = [getattr(row, name) for row in rows]
        assert sorted(values, reverse=name != "seconds") == values
    assert rows[-1].coordinates_max < 1e-6
    assert rows[-1].seconds == rows[-1].seconds_per_sequence > rows[0].seconds > 0
