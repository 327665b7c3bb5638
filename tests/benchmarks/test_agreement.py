"""Three ways to a status: where they differ, and why."""

import re
from dataclasses import replace

import numpy as np
import pytest

from orbitdb.benchmarks.agreement import agreement, compare
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.balls.enclosure import true_errors
from orbitdb.orbits.newton import certificates
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.relaxation import EPSILON, relax, slowest_rates
from orbitdb.symbols.least_words import representatives

THROUGH_A_JOINT = ["011032", "011033", "011332", "011333", "012032", "012333", "111333"]


@pytest.mark.slow
def test_the_error_that_the_force_leaves_is_the_true_one():
    stadium = Stadium(1.6)
    words, _ = representatives(6)
    relaxed = relax(words, stadium)
    orbits = relaxed.rows(relaxed.status == Status.ORBIT)
    true, _, _ = true_errors(orbits, certificates(orbits.words, stadium))
    share = true * slowest_rates(orbits.words, stadium, orbits.coordinates) / EPSILON
    assert share.max() < 1.01
    assert np.median(share) > 0.5


@pytest.mark.slow
def test_orbits_through_a_joint_are_the_ones_that_differ_at_a_1():
    found, differing = agreement(6, Stadium(1.0))
    said = [re.sub("orbit by|dynamical by", "... by", each) for each in differing]
    assert said == [
        f"{word} at a = 1: boundary by proof, ... by the relaxation; it runs through a joint"
        for word in THROUGH_A_JOINT
    ]
    assert "012032 at a = 1: boundary by proof, orbit by the relaxation; it runs through a joint" in differing
    assert (found.boundary, found.disagreements, found.unexplained) == (7, 7, 0)
    assert found.doubles == found.relaxation == found.classes - 7


@pytest.mark.slow
def test_what_has_no_reason_is_not_explained():
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
