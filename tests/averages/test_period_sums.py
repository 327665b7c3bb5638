"""Sums by period give the averages that the orbits give, and do not depend on how they were parted."""

from dataclasses import fields, replace

import numpy as np
import pytest
from solutions import class_rows, lyapunov

from orbitdb.averages.by_period import lyapunov_of_periods
from orbitdb.averages.fixed_points import PeriodSums, Weight


def parts_of(a: float, p: int, count: int) -> list[PeriodSums]:
    rows = class_rows(a, 7)
    places = np.array_split(np.flatnonzero(rows.period == p), count)
    return [PeriodSums.of(rows.rows(part), p) for part in places]


@pytest.mark.parametrize("weight", Weight)
@pytest.mark.parametrize("a", [0.5, 1.6])
def test_averages_of_sums_are_those_of_the_orbits(a, weight):
    rows = class_rows(a, 7)
    sums = {p: PeriodSums.joined(parts_of(a, p, 3), p) for p in range(2, 8)}
    expected, found = lyapunov(rows, 7, weight), lyapunov_of_periods(sums, 7, weight)
    assert found.faults == expected.faults
    for field in fields(found):
        if field.name != "faults":
            values = getattr(found, field.name), getattr(expected, field.name)
            np.testing.assert_allclose(*values, rtol=1e-12, err_msg=field.name)


def test_what_no_orbits_up_to_a_period_can_have_is_told_whatever_longer_ones_have():
    """At a tiny a, where zeros are spurious, with longer orbits that are by far more unstable."""
    rows = class_rows(1e-6, 7)
    rows = replace(rows, lyapunov=np.where(rows.period == 7, 5, 1) * rows.lyapunov)
    sums = {p: PeriodSums.of(rows.rows(rows.period == p), p) for p in range(2, 8)}
    faults = lyapunov_of_periods(sums, 7, Weight.DETERMINANT).faults
    assert faults == lyapunov(rows, 7, Weight.DETERMINANT).faults
    assert "of orbits 2e-06 to 0.8814" in faults[4]


def test_sums_are_the_same_in_any_order_and_come_back_from_bytes():
    parts = parts_of(1.6, 7, 9)
    whole = PeriodSums.joined(parts, 7)
    assert PeriodSums.joined(parts[::-1], 7) == whole
    assert PeriodSums.from_numbers(7, whole.numbers()) == whole
    none = PeriodSums.joined([], 7)
    assert PeriodSums.from_numbers(7, none.numbers()) == none
    for wrong in (whole.numbers()[8:], whole.numbers()[:-8] + b"\xff" * 8):
        with pytest.raises(ValueError, match="no sums of period 7"):
            PeriodSums.from_numbers(7, wrong)
