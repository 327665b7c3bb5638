"""Run time against error: the errors are true ones, and every method is judged on the same words."""

import numpy as np
import pytest

from orbitdb.benchmarks.work_precision import (
    ball_rows,
    newton_rows,
    relaxation_rows,
    root_rows,
    sample,
    stage_times,
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.least_words import representatives


@pytest.fixture(scope="module")
def cases():
    return sample(5, Stadium(1.0))


def test_a_sample_is_spread_over_all_classes():
    words, sizes = representatives(7)
    few = sample(7, Stadium(), 10)
    assert len(few.words) == len(few.truth) == 10
    np.testing.assert_array_equal(few.words[[0, -1]], words[[0, -1]])
    assert sizes.sum() == count_admissible(7)


def test_newton_is_charged_once_for_a_class(cases):
    (row,) = newton_rows(cases, (1e-16,))
    assert row.failures == 0
    assert row.coordinates_max < 1e-14
    assert row.seconds * row.words == pytest.approx(row.seconds_per_sequence * count_admissible(5))


def test_balls_report_radii_that_shrink_with_the_bits(cases):
    rows = list(ball_rows(cases, (64, 128)))
    assert rows[0].coordinates_max < 1e-15
    assert rows[1].coordinates_max < 1e-30
    assert rows[0].failures == rows[1].failures == 0


def test_root_is_judged_by_the_orbit_it_finds(cases):
    loose, tight = root_rows(cases.part(8), (1e-4, 1e-10))
    assert tight.coordinates_max < 1e-7 < loose.coordinates_max
    assert tight.words == loose.words == 8


def test_relaxation_goes_on_to_smaller_forces_and_is_charged_for_the_whole_way(cases):
    few = cases.part(6)
    rows = list(relaxation_rows(few, (1e-8, 1e-3, 1e-6)))
    assert [row.setting for row in rows] == [1e-3, 1e-6, 1e-8]
    for name in ("seconds", "coordinates_max", "length_max"):
        values = [getattr(row, name) for row in rows]
        assert sorted(values, reverse=name != "seconds") == values
    assert rows[-1].coordinates_max < 1e-6
    assert rows[-1].seconds == rows[-1].seconds_per_sequence


def test_stages_count_what_they_time():
    times = stage_times(8, Stadium(1.0))
    assert times.sequences == count_admissible(8)
    assert times.classes == len(representatives(8)[0])
    assert all(value > 0 for value in (times.enumeration, times.cutting, times.newton))
