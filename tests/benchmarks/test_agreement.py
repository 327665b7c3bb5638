"""Comparison of the methods: where and why their statuses differ, and run time against true error."""

import re
from collections import Counter
from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest

from orbitdb.benchmarks.agreement import agreement, compare
from orbitdb.benchmarks.work_precision import (
    ball_rows,
    newton_rows,
    relaxation_rows,
    root_rows,
    sample,
    stage_times,
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.balls import true_errors
from orbitdb.orbits.newton import certificates, solve
from orbitdb.orbits.relaxation import EPSILON, relax, slowest_rates
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives
from orbitdb.symbols.pruning import count_admissible

THROUGH_A_JOINT = ["011032", "011033", "011332", "011333", "012032", "012333", "111333"]


@pytest.mark.slow
def test_the_error_estimated_from_the_force_is_the_true_error():
    stadium = Stadium(1.6)
    words, _ = representatives(6)
    relaxed = relax(words, stadium)
    orbits = relaxed.rows(relaxed.status == Status.ORBIT)
    true, _, _ = true_errors(orbits, certificates(orbits.words, stadium))
    share = true * slowest_rates(orbits.words, stadium, orbits.coordinates) / EPSILON
    assert share.max() < 1.01
    assert np.median(share) > 0.5


@pytest.mark.slow
def test_methods_differ_at_a_1_only_on_orbits_through_a_joint():
    found, differing = agreement(6, Stadium(1.0))
    said = [re.sub("orbit by|dynamical by", "... by", each) for each in differing]
    assert said == [
        f"{word} at a = 1: boundary by proof, ... by the relaxation; it runs through a joint"
        for word in THROUGH_A_JOINT
    ]
    assert "012032 at a = 1: boundary by proof, orbit by the relaxation; it runs through a joint" in differing
    words, _ = representatives(6)
    orbits = int((solve(words, Stadium(1.0)).status == Status.ORBIT).sum())
    assert (found.a, found.p, found.classes, found.orbits) == (1.0, 6, len(words), orbits)
    assert (found.boundary, found.disagreements, found.unexplained, found.unresolved) == (7, 7, 0, 0)
    assert found.doubles == found.relaxation == found.classes - 7


@pytest.mark.slow
def test_a_disagreement_without_a_reason_counts_as_unexplained():
    stadium = Stadium(1.6)
    words, _ = representatives(4)
    relaxed = relax(words, stadium)
    statuses = np.where(np.arange(len(words)) == 2, Status.DYNAMICAL.value, relaxed.status)
    found, (only,) = compare(replace(relaxed, status=statuses), stadium)
    assert (found.disagreements, found.unexplained, found.relaxation) == (1, 1, len(words) - 1)
    (rate,) = slowest_rates(words[2:3], stadium, relaxed.coordinates[2:3])
    assert f"error of {EPSILON / rate:.1e}" in only
    assert only.endswith("NOT EXPLAINED")
    found, _ = compare(replace(relaxed, status=statuses), stadium, epsilon=2 * rate)
    assert (found.disagreements, found.unexplained) == (1, 0)


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
    assert Counter(each.status for each in every.truth)[Status.BOUNDARY] == len(THROUGH_A_JOINT)
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


def test_stage_times_count_the_words_and_classes_they_time():
    times = stage_times(8, Stadium(1.0))
    assert times.sequences == count_admissible(8)
    assert times.classes == len(representatives(8)[0])
    assert all(value > 0 for value in (times.enumeration, times.cutting, times.newton))
    assert times.balls < times.assessment  # there is no word to decide in ball arithmetic
    assert stage_times(6, Stadium(1.0)).balls > 10 * times.balls  # seven words need ball arithmetic
