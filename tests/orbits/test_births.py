"""Births and deaths compared with solutions at single a, exact numbers, and 50-digit arithmetic."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from quick import slow_but
from reference import birth_error
from solutions import representatives

from orbitdb import existence, solve_word
from orbitdb.billiard.legs import cut, direction_limits, slack_changes, slacks, smooth_slacks
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, WorkError
from orbitdb.orbits import births
from orbitdb.orbits.along_a import between, candidates, follow_in_a, motion, refine
from orbitdb.orbits.births import JOINTS, Changes, events, find_changes
from orbitdb.orbits.newton import newton
from orbitdb.orbits.solve import LONGEST, solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.words import from_strings, to_strings


@pytest.fixture(scope="module")
def found() -> dict[int, tuple[NDArray[np.uint8], Changes]]:
    """Words of p = 2..7 and their changes."""
    return {p: (words, find_changes(words)) for p in range(2, 8) for words in [representatives(p)]}


def test_smooth_slacks_are_linear_and_give_the_slacks():
    ((_, legs),) = [each for each in cut(representatives(7)) if each[1].k.shape[0] == 4]
    alpha = newton(legs, 1.0).alpha
    smooth, rough = smooth_slacks(legs, alpha), slacks(legs, alpha)
    assert np.array_equal(np.minimum(smooth[0], smooth[1]), rough[0])
    several = legs.k > 1
    assert np.array_equal(np.minimum(smooth[2], smooth[3])[several], rough[1][several])
    assert np.isinf(smooth[2:4][:, ~several]).all()
    assert smooth[4:] == pytest.approx(rough[2:])
    change = np.random.default_rng(1).normal(size=alpha.shape)
    finite = np.isfinite(smooth)
    moved = smooth_slacks(legs, alpha + change)[finite] - smooth[finite]
    assert moved == pytest.approx(slack_changes(legs, change)[finite], abs=1e-13)


def test_velocity_is_the_derivative_of_the_maximum():
    ((_, legs),) = [each for each in cut(representatives(6)) if each[1].k.shape[0] == 4]
    a, h = 1.2, 1e-5
    low, here, high = (newton(legs, a * math.exp(x)).alpha for x in (-h, 0.0, h))
    limits = direction_limits(legs, a)
    free = ((here > limits[0]) & (here < limits[1])).all(axis=0)
    _, velocity = motion(legs, a, here, limits)
    assert velocity[:, free] == pytest.approx(((high - low) / (2 * h))[:, free], abs=1e-8)


def test_following_a_word_agrees_with_solving():
    ((_, legs),) = [each for each in cut(representatives(6)) if each[1].k.shape[0] == 4]
    stations = list(follow_in_a(legs, np.log(np.geomspace(60, 0.05, 20))))
    assert stations[-1].alpha == pytest.approx(newton(legs, 0.05).alpha, abs=1e-5)
    ends = [list(follow_in_a(legs, np.log(np.geomspace(1.5, 1, 1 + steps))))[-1].alpha for steps in (8, 16)]
    off = [np.abs(end - newton(legs, 1.0).alpha).max() for end in ends]
    assert off[0] / off[1] == pytest.approx(2**6, rel=0.3)  # a cubic error, squared by a Newton step


@pytest.mark.parametrize(
    ("p", "at", "widths", "order"),
    [(6, 0.3, (0.4, 0.2), 8), (6, 0.3, (3, 2), None), (7, -2.5, (8, 3), None), (6, -4.5, (6, 3), None)],
)
def test_interpolation_between_stations_agrees_with_solving(p, at, widths, order):
    """Between close stations the error is quartic and a Newton step squares it; others take several steps."""
    for _, legs in cut(representatives(p)):
        off = []
        for h in widths:
            low, middle, high = (next(follow_in_a(legs, np.array([at + x]))) for x in (-h / 2, 0, h / 2))
            found = between(legs, low, high)
            assert found.x == pytest.approx(at)
            assert found.velocity == pytest.approx(middle.velocity, abs=3e-3)
            off.append(np.abs(found.alpha - middle.alpha).max())
        assert max(off) < 1e-5
        assert order is None or off[0] / off[1] == pytest.approx(2**order, rel=0.2)


@pytest.mark.slow
def test_every_change_between_two_stations_is_found(found):
    """This includes words that are orbits at both stations but not between them, and a station at a birth."""
    dying, rng = from_strings(["010203113", "010233113"]), np.random.default_rng(1)
    for words, changes in [(dying, find_changes(dying)), *found.values()]:
        drawn = rng.uniform((-1.7, 0.1), (-0.4, 1), (8 if words is dying else 2, 2))
        for n, (low, width) in enumerate([(-0.87, 0.65), *drawn.tolist()]):
            high = low + width
            for rows, legs in cut(words):
                births = np.log(changes.a[np.isin(changes.word, rows)])
                at = births[(low < births) & (births < high)][:n] + (0, 1e-13, -1e-13, 1e-8)[n % 4]
                stations = np.sort(np.unique([low, *at, high]))[::-1]
                zeros = refine(legs, candidates(legs, follow_in_a(legs, stations)))
                for row, word in enumerate(rows.tolist()):
                    places = np.log(changes.a[changes.word == word])
                    places = places[(low < places) & (places < high)]
                    here = np.sort(zeros.x[zeros.word == row])
                    here = here[np.diff(here, prepend=-np.inf) > 1e-9]  # several bounces at once
                    assert here == pytest.approx(places, abs=1e-11)


def test_a_word_dies_and_is_reborn():
    one, other = existence("010203113"), existence("010233113")
    ends: list[Any] = [pytest.approx(at, abs=1e-12) for at in (0.473270308236, 0.605684335145)]
    assert solve_word("020311301", 0.5, exists=True).exists == tuple(existence("020311301"))
    assert solve_word("13", 0.5).exists is None
    assert one == [(pytest.approx(0.386252501738), ends[0]), (ends[1], None)]
    assert other == [(pytest.approx(0.390890513418), ends[0]), (ends[1], None)]


def test_some_words_are_orbits_at_every_a_and_others_at_none():
    assert existence("13") == [(0.0, None)]
    assert existence("02") == existence("0131") == existence("1313") == []


def test_the_numbers_of_births_are_correct(found):
    assert {p: int(changes.always.sum()) for p, (_, changes) in found.items()} == {
        2: 1, 3: 2, 4: 8, 5: 4, 6: 14, 7: 6
    }  # fmt: skip
    assert {p: len(changes.a) for p, (_, changes) in found.items()} == {
        2: 0, 3: 0, 4: 0, 5: 13, 6: 33, 7: 101
    }  # fmt: skip
    assert all(changes.born.all() for _, changes in found.values())


@pytest.mark.parametrize("p", [5, 6, 7])
def test_births_are_exact_to_rounding(found, p):
    _, changes = found[p]
    relative = changes.error / changes.a
    assert np.finfo(float).eps < np.median(relative) < 1e-13
    assert relative.max() < 1e-11


@pytest.mark.parametrize(
    "a", slow_but([0.02, 0.3661, 0.7, 1.0, 2.0], [0.02, 0.12, 0.3661, 0.5, 0.7, 1.0, 1.6, 2.0, 2.5, 5.0])
)
def test_lives_agree_with_solving(found, a):
    for words, changes in found.values():
        status = solve(words, Stadium(a)).status
        for each, said in zip(changes.lives(), status.tolist(), strict=True):
            if said != "boundary":
                assert (said == "orbit") == any(low < a and (high is None or a < high) for low, high in each)


def test_the_bounce_of_a_change_is_at_the_stated_joint(found):
    for words, changes in found.values():
        for i, a in [*enumerate(changes.a.tolist())][::3]:
            word, at = words[changes.word[i]][None], Stadium(a * (1 + 1e-9))
            x, y = at.points(word, solve(word, at).coordinates)[0, changes.bounce[i] - 1]
            assert (abs(x), abs(y)) == pytest.approx((a, 1), abs=1e-6)
            side = f"{'top' if y > 0 else 'bottom'} {'right' if x > 0 else 'left'}"
            assert JOINTS[changes.joint[i]] == side


@pytest.mark.parametrize("p", slow_but([5, 7], [5, 6, 7]))
def test_births_are_within_their_bounds_of_50_digit_values(found, p):
    """The reference is Newton's method on all p coordinates in plane geometry, without legs and slacks."""
    words, changes = found[p]
    for i in np.random.default_rng(p).choice(len(changes.a), 2, replace=False):
        word, a = words[changes.word[i]], float(changes.a[i])
        joint = JOINTS[changes.joint[i]]
        start = solve(word[None], Stadium(a * (1 + 1e-9))).coordinates[0].tolist()
        off = float(birth_error(to_strings(word[None])[0], int(changes.bounce[i]), joint, a, start))
        assert off <= changes.error[i]
        assert off / a < 1e-13


@given(st.lists(st.integers(1, 40), min_size=1, max_size=12), st.integers(0, 3))
@example([1, 7, 3, 8, 5], 1)
def test_events_are_chains_of_touching_brackets(places, error):
    found = events(np.array(places, float), np.full(len(places), float(error)))
    rising = sorted(set(places))
    first = [place for k, place in enumerate(rising) if k == 0 or place - rising[k - 1] > 2 * error]
    assert found.tolist() == [sum(begin <= place for begin in first) for place in places]


def test_words_up_to_the_maximum_length_are_followed():
    assert existence("13" * (LONGEST // 2)) == []  # a repetition has no life
    for long in ("01" + "5" * 25 + "202", "01" + "5" * 45 + "202"):  # born near 0.13 p^2
        ((born, died),) = existence(long)
        assert born > 60
        around = [solve_word(long, born * (1 + off)).status for off in (-1e-9, 1e-9)]
        assert (around, died) == ([Status.DYNAMICAL, Status.ORBIT], None)
    with pytest.raises(InputError, match=f"{LONGEST + 1} bounces is too long .* at most {LONGEST}"):
        existence("1" * LONGEST + "3")


def test_words_of_the_same_event_share_a_path(found):
    """They have the same length at the birth that they share."""
    words, changes = found[6]
    numbers = events(changes.a, changes.error)
    assert np.bincount(numbers).max() == 7
    for number in np.unique(numbers)[:6]:
        rows = np.flatnonzero(numbers == number)
        assert len(rows) > 1
        at = Stadium(float(changes.a[rows[0]]) * (1 + 1e-9))
        length = solve(words[changes.word[rows]], at).length
        assert length == pytest.approx(length[0], rel=1e-7)


def test_the_grid_is_extended_below_its_usual_end(monkeypatch):
    """A word whose status at the end of the usual grid is not that at a = 0 is followed to smaller a."""
    monkeypatch.setattr(births, "LOW", 1.0)
    changes = find_changes(from_strings(["010203113"]))
    assert changes.a == pytest.approx([0.386252501738, 0.473270308236, 0.605684335145])


def test_balls_decide_what_doubles_leave_open(found, monkeypatch):
    undecided = "orbitdb.orbits.births.statuses"
    monkeypatch.setattr(undecided, lambda legs, a, alpha: np.zeros(len(a), np.int8))
    words, plain = found[5]
    changes = find_changes(words)
    assert changes.born.tolist() == plain.born.tolist()
    assert (np.abs(changes.a - plain.a) <= changes.error).all()


def test_a_word_that_is_searched_again_joins_the_others(found, monkeypatch):
    """The first grid misses all births of one word here."""
    words, plain = found[6]
    missed: list[int] = []

    def forgetful(legs, stations):
        cells = candidates(legs, stations)
        if missed or not len(cells):
            return cells
        missed.append(int(cells.word[0]))
        return cells.rows(cells.word != cells.word[0])

    monkeypatch.setattr(births, "candidates", forgetful)
    changes = find_changes(words)
    assert missed
    assert changes.word.tolist() == plain.word.tolist()
    assert (np.abs(changes.a - plain.a) <= changes.error).all()


def test_inconsistent_births_are_refused(monkeypatch):
    """A word whose birth the grid missed is searched again, and finally refused."""
    monkeypatch.setattr(births, "FINER", (1,))
    monkeypatch.setattr(births, "follow_in_a", lambda legs, grid: iter(()))
    with pytest.raises(WorkError, match="010203113"):
        find_changes(from_strings(["010203113"]))
