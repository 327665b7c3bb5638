"""Small versions of the stress cases, in which every error is below its stored bound."""

import dataclasses
from collections.abc import Callable, Iterator
from time import perf_counter
from typing import Any

import numpy as np
import pytest

from orbitdb.benchmarks.stress import (
    CASES,
    Outcome,
    closed_words,
    compare,
    extreme_stadia,
    small_margins,
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives


@pytest.mark.slow
def test_stadia_from_a_circle_to_a_channel_pass():
    outcomes = list(extreme_stadia(p=6))
    assert len(outcomes) == 13
    assert all(outcome.passed for outcome in outcomes)
    assert all(outcome.length < 1e-15 for outcome in outcomes)
    words, _ = representatives(6)
    for exponent, outcome in zip(range(-6, 7), outcomes, strict=True):
        assert outcome.asked.startswith(f"a = 1e{exponent},")
        assert outcome.orbits == (solve(words, Stadium(10.0**exponent)).status == Status.ORBIT).sum()
    assert outcomes[-1].orbits == outcomes[-1].words


SMALL: dict[str, tuple[tuple[Any, ...], str]] = {
    "stadium": ((3,), "a = 1e6, all classes of p = 3"), "joint": (((6,),), "a = 2.5, all classes of p = 6"),
    "run": ((2,), "1^100 5^100"), "leg": ((2,), "1 2 (02)^50 3 2 (02)^50"),
    "trajectory": (((300,), 2), "closed segments of p = 300"), "sum": ((100_000,), "e^-40 .. e^0,"),
    "margin": (((6, 7), 0.05), "|margin| < 0.05 of p = 7,"),
}  # fmt: skip
"""The arguments of each small case, and the beginning of its last question."""


@pytest.mark.parametrize("name", CASES)
def test_every_case_passes_and_reports_its_time(name):
    begin = perf_counter()
    case: Callable[..., Iterator[Outcome]] = CASES[name]
    outcomes = list(case(*SMALL[name][0]))
    assert outcomes[-1].asked.startswith(SMALL[name][1])
    assert 0 < sum(each.seconds for each in outcomes) < perf_counter() - begin
    assert all(each.passed and each.case == name and each.words for each in outcomes)
    assert max(each.share for each in outcomes) > 1e-3  # the bounds are useful
    assert any(each.orbits for each in outcomes) == (name != "sum")  # this case adds up numbers without words


def test_the_smallest_margins_of_each_period_are_found():
    for p, outcome in zip((6, 7), small_margins((6, 7), 0.05), strict=True):
        margin = np.abs(solve(representatives(p)[0], Stadium()).margin)
        assert outcome.words == (margin < 0.05).sum() > 0
        assert outcome.asked.endswith(f"of p = {p}, least {margin.min():.1e}")


@pytest.mark.parametrize(("a", "p"), [(1.6, 5), (10, 40)])  # some trajectories have no such word here
def test_closed_words_begin_with_a_run_on_the_left(a, p):
    words = closed_words(Stadium(a), p, 12)
    assert words.shape[1] == p
    assert len(words) == 12  # out of eight times as many
    on_left = np.isin(words, (1, 4))
    assert on_left[:, 0].all()
    assert not on_left[:, -1].any()


def test_a_wrong_row_fails():
    words, _ = representatives(5)
    orbits = solve(words, Stadium())
    honest = compare("x", "honest", orbits, Stadium(), 0.0)
    assert honest.passed
    faults: Any = {"open": 1}, {"wrong": 1}, {"share": 1.01}
    assert not any(dataclasses.replace(honest, **wrong).passed for wrong in faults)
    for name in ("length", "lyapunov"):
        values = getattr(orbits, name).copy()
        values[3] *= 1 + 1e-9
        altered: Orbits = dataclasses.replace(orbits, **{name: values})
        found = compare("x", "altered", altered, Stadium(), 0.0)
        assert not found.passed
        assert getattr(found, name) == pytest.approx(1e-9, rel=1e-4)
    swapped = np.where(orbits.status == Status.ORBIT, Status.DYNAMICAL.value, orbits.status)
    found = compare("x", "status", dataclasses.replace(orbits, status=swapped), Stadium(), 0.0)
    assert found.wrong == found.orbits > 0
    assert np.isnan(found.coordinates)  # words without an orbit have nothing to compare
