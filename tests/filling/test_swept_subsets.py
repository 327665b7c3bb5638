"""Sweeps of chosen orbits choose the same words as stored rows, and each subset has one canonical text."""

import json
import sqlite3
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contents import made
from hypothesis import given
from hypothesis import strategies as st
from quick import slow_but
from there import there

from orbitdb.answers.results import PROVED
from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.statistics_screen import statistics
from orbitdb.errors import InputError
from orbitdb.filling.fill import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.orbits.exponents import exponents
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.status import Status
from orbitdb.store.asking.criteria import chosen_by
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import SWEPT_MEASURES, selection_of, swept_text, within_ranges
from orbitdb.store.reading.moment import Reader
from orbitdb.symbols.enumeration import LeastWords, Span, least_words
from orbitdb.symbols.patterns import words_containing
from orbitdb.symbols.symmetry import GROUPS, label, members
from orbitdb.symbols.words import from_strings, pack, to_strings, unpack

SUBSETS = [
    {"time_reversal": "self"},
    {"symmetry": "x,T,xT"},
    {"contains": "13"},
    {"length": (None, 20.0)},
    {"lambda_d": (0.8, 1.0)},
    {"time_reversal": "pair", "contains": "31", "lyapunov": (3, None), "margin": (0.05, None)},
]
MORE = [
    {"time_reversal": "pair"},
    {"symmetry": "1"},
    {"contains": "3131"},
    {"contains": "0131313"},
    {"lambda_c": (None, 0.4)},
    {"margin": (None, 0.1), "symmetry": "1", "contains": "02"},
    {"contains": "020202", "time_reversal": "self"},
]


@pytest.mark.parametrize(
    ("a", "highest", "subsets"),
    slow_but(1, [(1.6, 6, SUBSETS[1::2]), (1.6, 7, SUBSETS), (1.6, 8, MORE), (0.5, 8, SUBSETS + MORE)]),
)
def test_a_swept_subset_equals_the_choice_from_stored_rows(tmp_path, a, highest, subsets):
    """Counts agree exactly, and sums up to the last digits."""
    path, periods = tmp_path / "orbits.db", (2, highest)
    made(path, fill_periods(path, a, periods))
    with closing(Catalogue(path)) as catalogue:
        for subset in subsets:
            agree(catalogue, chosen_by(a, **subset), periods)


def agree(catalogue: Catalogue, chosen: Selection, periods: tuple[int, ...]) -> None:
    list(sweep_periods(catalogue.path, chosen.a, periods, selection=chosen))
    with closing(sqlite3.connect(catalogue.path)) as plain:
        (last,) = plain.execute("SELECT parameters FROM run ORDER BY id DESC LIMIT 1").fetchone()
    assert json.loads(last)["selection"] == swept_text(chosen)
    for swept in catalogue.sweeps(chosen.a, chosen):
        here = replace(chosen, periods=((swept.p, swept.p),))
        of_words = replace(here, ranges={})
        rows, tally = catalogue.classes(here), swept.tally
        counts = [
            catalogue.count(replace(of_words, statuses=(s,))) for s in (Status.BOUNDARY, Status.UNRESOLVED)
        ]
        assert [tally.n_c, tally.classes, tally.boundary, tally.unresolved] == [
            rows.words.sum(), len(rows), *counts
        ]  # fmt: skip
        found, expected = there(swept.sums), PeriodSums.of(rows, swept.p)
        np.testing.assert_allclose(found.sums, expected.sums, rtol=2e-15)
        np.testing.assert_allclose(found.ranges, expected.ranges, rtol=2e-15)


@pytest.mark.slow
@pytest.mark.parametrize("subset", [SUBSETS[0], SUBSETS[-1]])
def test_averages_over_a_swept_subset_equal_those_over_rows(filled_once, tmp_path, subset):
    chosen = chosen_by(1.6, p="2-6", **subset)
    path = tmp_path / "swept.db"
    made(path, sweep_periods(path, 1.6, range(2, 8), selection=replace(chosen, periods=())))
    with closing(Catalogue(path)) as swept, closing(Catalogue(filled_once)) as filled:
        pairs = [(swept.entropy(chosen), filled.entropy(chosen))]
        pairs += [(swept.lyapunov(chosen), filled.lyapunov(chosen))]
        pairs += [(statistics(Reader(path), chosen), statistics(Reader(filled_once), chosen))]
        for found, wanted in pairs:
            for name in set(wanted.columns) - {"classes", *PROVED}:
                one, other = (np.array(each[name], dtype=float) for each in (found, wanted))
                np.testing.assert_allclose(one, other, rtol=1e-12, err_msg=name)
        assert sum(wanted["N_c"])


def test_a_bound_on_a_range_refers_to_the_stored_number():
    """One orbit in 10 000, such as this one, may differ in the last digit when swept."""
    word, a = "0204420233", 0.5
    stored = float(solve_admissible(from_strings([word]), Stadium(a)).length[0])
    (swept,) = exponents(pack(from_strings([word])), 10, Stadium(a))
    assert swept.length[0] == pytest.approx(stored, rel=1e-14)
    for bounds in ((stored, None), (None, stored), (stored, stored)):
        selection = chosen_by(a, length=bounds)
        assert within_ranges(pack(from_strings([word])), 10, swept.length, swept.lyapunov, selection).all()


@pytest.mark.parametrize("p", slow_but([2, 5], range(2, 7)))
def test_words_containing_a_factor_are_counted(p):
    parts = zip(*least_words(Span.whole(p)), strict=True)
    classes = LeastWords(*map(np.concatenate, parts))
    words = [members(word) for word in to_strings(unpack(classes.codes, p))]
    for factor in ("1", "02", "13", "131", "313", "1313", "3131", "020", "55555", "013130", "0131301313"):
        counts = [sum(factor in 2 * word for word in each) for each in words]
        assert words_containing(classes.codes, classes.stabiliser, p, factor).tolist() == counts, factor


def no_empty_range(bounds: tuple[float | None, float | None]) -> bool:
    low, high = bounds
    return low is None or high is None or low <= high


BOUND = st.one_of(st.none(), st.floats(-9, 99), st.sampled_from([-np.inf, np.inf, -0.0, 0, 20]))
CRITERIA = st.fixed_dictionaries(
    {},
    optional={
        "time_reversal": st.sampled_from(["self", "pair"]),
        "symmetry": st.sampled_from([label(mask).split(",") for mask in GROUPS]),
        "contains": st.text("012345", min_size=1, max_size=3),
        **dict.fromkeys(SWEPT_MEASURES, st.tuples(BOUND, BOUND).filter(no_empty_range)),
    },
)


def asked(criteria: dict[str, Any], order: list[str]) -> Selection:
    """Choose the criteria in the given order."""
    named = {name: criteria[name] for name in order}
    if "symmetry" in named:
        named["symmetry"] = ",".join(named["symmetry"])
    return chosen_by(**named)


def meant(criteria: dict[str, Any]) -> dict[str, Any]:
    """Return what criteria choose, however they are written."""
    found = {}
    for name, value in criteria.items():
        if name in SWEPT_MEASURES:
            low, high = value
            value = None if low == -np.inf else low, None if high == np.inf else high
        found[name] = frozenset(value) if name == "symmetry" else value
    return {name: value for name, value in found.items() if value != (None, None)}


@given(CRITERIA, CRITERIA, st.randoms())
def test_each_subset_has_a_unique_text(one, other, chance):
    order = chance.sample(list(one), len(one))
    text = swept_text(asked(one, list(one)))
    turned = one | ({"symmetry": one["symmetry"][::-1]} if "symmetry" in one else {})
    assert swept_text(asked(turned, order)) == text
    assert swept_text(replace(asked(one, order), a=0.5, periods=((3, 4),), statuses=(Status.ORBIT,))) == text
    assert swept_text(selection_of(text, 1.6)) == text
    for changed in (other, one | other):
        assert (swept_text(asked(changed, list(changed))) == text) == (meant(changed) == meant(one))


def test_the_set_of_all_orbits_has_the_empty_text():
    assert swept_text(chosen_by()) == swept_text(chosen_by(p=3, status="orbit", length=(-np.inf, None))) == ""
    assert swept_text(chosen_by(length=(-0.0, 20), time_reversal="self")) == "reversal=self length=0.0:20.0"


def test_a_stored_sweep_with_an_impossible_symmetry_is_still_read():
    """Such a sweep contains only zeros. New questions with such a symmetry are refused."""
    assert selection_of("symmetry=T,xT", 1.6) == Selection(1.6, statuses=(Status.ORBIT,), symmetry="T,xT")


@pytest.mark.parametrize(
    "text",
    ["length=:20", "length=:2.0 reversal=self", "born=1.0:", "contains=9", "reversal=x", "symmetry=z", "any"],
)
def test_a_text_no_sweep_can_have_is_refused(text):
    with pytest.raises(InputError):
        selection_of(text, 1.6)
