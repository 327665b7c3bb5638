"""Numbers that are recognised, and those that are not."""

import math

import numpy as np
import pytest

from orbitdb.numerals import closed_form


@pytest.mark.parametrize(
    ("a", "form"),
    [
        (2.0, "2"),
        (2.499999999999999, "5/2"),
        (math.sqrt(0.5), "sqrt(2)/2"),
        (math.sqrt(432) / 18, "2 sqrt(3)/3"),
        ((math.sqrt(3) - 1) / 2, "(sqrt(3) - 1)/2"),
        ((3 * math.sqrt(2) + 2) / 2, "(3 sqrt(2) + 2)/2"),
        ((5 - math.sqrt(5)) / 2, "(5 - sqrt(5))/2"),
    ],
)
def test_simple_numbers_are_recognised(a, form):
    assert closed_form(a) == form


def test_no_other_number_is():
    assert not any(map(closed_form, np.random.default_rng(3).uniform(0.05, 12, 40).tolist()))
