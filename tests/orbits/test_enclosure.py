"""Ball arithmetic: orbits through joints are proved, true values enclosed, and doubles never contradicted."""

import mpmath as mp
import numpy as np
import pytest
import reference
from flint import arb, ctx, fmpq, fmpq_poly
from quick import slow_but
from solutions import representatives, words_of

from orbitdb.billiard.legs import cut, direction_limits
from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits import balls
from orbitdb.orbits.ball_path import BallPath
from orbitdb.orbits.balls import ExactPath, NumberField, as_orbits, distance, enclose, joins
from orbitdb.orbits.newton import newton
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.words import from_strings, parse, to_strings

JOINT = {
    0.5: ["01032123", "01032155", "01033155", "01132443", "01134443", "01234443", "11134443"],
    1.0: ["011032", "011033", "011332", "011333", "012032", "012333", "111333"],
    2.0: ["01102302", "01102552", "01105502", "01105552", "01202302", "01205552", "04442333"],
    2.5: ["01320202", "01330202", "02021133"],
}
"""For each a, all classes up to p = 9 that run exactly through a joint."""

CASES = [(a, word) for a, words in JOINT.items() for word in words]


def enclosed(word: str, a: float):
    return enclose(from_strings([word])[0], Stadium(a))


def holds(ball, exact: mp.mpf) -> bool:
    """Tell whether a ball, rounded outward to exact numbers, contains a 50-digit value."""
    middle, radius = (
        mp.mpf(str(ball.mid().str(80, radius=False))),
        mp.mpf(str(ball.rad().str(20, radius=False))),
    )
    return abs(middle - exact) <= radius * (1 + mp.mpf(10) ** -15) + mp.mpf(10) ** -(reference.DIGITS + 5)


@pytest.mark.parametrize(("a", "word"), CASES)
def test_orbits_through_a_joint_are_proved_to_be_boundary(a, word):
    found = enclosed(word, a)
    assert found.status == Status.BOUNDARY
    assert found.margin.contains(0)
    assert solve(from_strings([word]), Stadium(a)).status[0] == Status.BOUNDARY


@pytest.mark.parametrize(("a", "word"), CASES)
def test_an_orbit_goes_through_a_joint_at_no_other_a_nearby(a, word):
    """In a longer stadium it is an orbit; in a shorter one the bounce leaves its wall."""
    below, above = enclosed(word, a - 1e-9), enclosed(word, a + 1e-9)
    assert (below.status, above.status) == (Status.DYNAMICAL, Status.ORBIT)
    for found in (below, above):
        assert 1e-11 < abs(float(found.margin)) < 1e-8
    for b, found in ((a - 1e-9, below), (a + 1e-9, above)):
        assert solve(from_strings([word]), Stadium(b)).status[0] == found.status


@pytest.mark.parametrize(
    ("a", "text"),
    [
        (2.0, "0102020203"),  # directions of slope 3, cosines in Q(sqrt 10)
        (3.0, "0211102333"),
        (1.0, "011032 011033"),  # the same path twice, with its joint written in both ways
        (0.5, "(01032123)^9 01032155"),
    ],
)
def test_longer_orbits_through_a_joint_are_proved_to_be_boundary(a, text):
    assert enclosed(parse(text), a).status == Status.BOUNDARY


def enclosed_path(word: str, a: float) -> BallPath:
    """Return the path of a word at its maximum, in balls of the current precision."""
    ((_, legs),) = cut(from_strings([word]))
    limits = [
        (low, high)
        for ((low,), (high,)) in zip(*(x.tolist() for x in direction_limits(legs, a)), strict=True)
    ]
    path = BallPath(legs, 0, a, limits)
    path.go_to([arb(x) for x in newton(legs, a).alpha[:, 0].tolist()])
    path.climb()
    path.widen()
    return path


@pytest.mark.parametrize(("a", "word"), slow_but(CASES[::4], CASES))
def test_only_zero_slacks_are_proved_to_be_zero(a, word):
    """Each slack is only given to within 1/2 of zero, because algebra knows it up to multiples of pi."""
    with ctx.workprec(128):
        path = enclosed_path(word, a)
        conditions = path.conditions()
        slack, _ = path.slacks(conditions)
        zero = [bool(abs(x.sin()) < 1e-20) for x in slack]
        assert any(zero)
        assert [joins(path, [(each, arb(0, 0.5))]) for each in conditions] == zero


def test_numbers_that_only_look_algebraic_prove_nothing():
    """Just above a = 1, 011032 misses the joint by 1e-16, so the exact identities fail."""
    with ctx.workprec(128):
        path = enclosed_path("011032", 1 + 2.0**-52)
        assert not any(joins(path, [(each, arb(0, 0.5))]) for each in path.conditions())


def test_runs_that_turn_by_the_wrong_angle_prove_nothing():
    """The half turns of 13 are right angles. Minus pi, they satisfy all equations; tilted, all but one."""
    with ctx.workprec(128):
        path = enclosed_path("13", 1.0)
        assert joins(path, [])
        turned, tilt = list(path.half), (arb(5) / 13).asin()
        for other in (turned[1], turned[1] - tilt, turned[1] + tilt):
            path.half = [turned[0] - (arb.pi() if other is turned[1] else tilt), other]
            assert not joins(path, [])


def test_numbers_off_the_unit_circle_prove_nothing():
    """Doubling the ones and halving the other numbers of 13 violates only the equation of the circle."""
    with ctx.workprec(128):
        path, rational = enclosed_path("13", 1.0), NumberField(fmpq_poly([0, 1]), arb(0, 1e-30))
        for size in (1, 2):
            numbers = (size, 0), (0, fmpq(1, size))
            alpha, half = ((fmpq_poly([cos]), fmpq_poly([sin])) for cos, sin in numbers)
            assert ExactPath(path, rational, [alpha] * 2, [half] * 2).is_maximum() == (size == 1)


def test_a_slack_is_not_zero_just_because_its_ball_contains_zero():
    """At 53 bits the ball of a slack of 1e-16 is small and contains zero, but the exact identities fail."""
    word, stadium = from_strings(["011032"])[0], Stadium(1 + 2.0**-52)
    assert enclose(word, stadium, precision=53).status == enclose(word, stadium).status == Status.ORBIT


def test_an_orbit_that_shadows_one_through_a_joint_is_an_orbit():
    """It comes within e^(-lambda / 2) of the joint."""
    text = "(02021133)^80 13"
    assert solve(from_strings([parse(text)]), Stadium(2.5)).status[0] == Status.ORBIT
    found = enclosed(parse(text), 2.5)
    assert float(found.margin.mid()) == pytest.approx(2.17590814607702e-121, rel=1e-12, abs=0)
    assert found.precision == 512


def test_a_word_that_no_precision_decides_is_unresolved(monkeypatch):
    monkeypatch.setattr(balls, "MAX_PRECISION", 256)
    assert enclosed(parse("(02021133)^80 13"), 2.5).status == Status.UNRESOLVED


def test_a_distance_is_rounded_up_even_below_the_range_of_doubles():
    assert distance(arb(0, arb(2) ** -1500), 0.0) > 0
    third = arb(1) / 3
    assert arb(distance(third, 1.0)) > 1 - third


@pytest.mark.parametrize("a", slow_but([1.0, 2.5], JOINT))
def test_the_list_of_orbits_through_joints_is_complete(a):
    found = []
    for p in range(2, 10):
        words = representatives(p)
        found += to_strings(words[solve(words, Stadium(a)).status == Status.BOUNDARY])
    assert found == JOINT[a]


@pytest.mark.parametrize("a", slow_but([1.6], [0.5, 1.6, 5.0]))
@pytest.mark.parametrize("p", slow_but(range(2, 8), range(2, 10)))
def test_enclosures_contain_the_mpmath_solution(p, a):
    words = words_of(p)
    orbits = solve(words, Stadium(a))
    rows = np.flatnonzero(orbits.status == Status.ORBIT)
    for row in np.random.default_rng(p).permutation(rows)[:4]:
        (word,) = to_strings(words[row : row + 1])
        exact = reference.refine(word, a, orbits.coordinates[row].tolist())
        found = enclosed(word, a)
        with mp.workdps(reference.DIGITS + 30):
            ends = [mp.mpf(a) if symbol in "02" else mp.pi / 2 for symbol in word]
            margin = min(end - abs(x) for end, x in zip(ends, exact.coordinates, strict=True))
            assert holds(found.margin, margin)
            assert all(holds(x, y) for x, y in zip(found.coordinates, exact.coordinates, strict=True))
            assert holds(found.length, exact.length)
            assert holds(found.lyapunov, exact.lyapunov)
        assert max(x.rad() for x in [*found.coordinates, found.length, found.lyapunov]) < 1e-25


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.2, 1.0, 2.5])
def test_doubles_never_contradict_balls(a):
    """All classes up to p = 7 and a third of those of p = 8 are compared."""
    for p in range(2, 9):
        words = representatives(p)[:: 3 if p == 8 else 1]
        orbits = solve(words, Stadium(a))
        for row, word in enumerate(words):
            assert enclose(word, Stadium(a)).status == orbits.status[row], to_strings(word[None])


def test_a_row_from_an_enclosure_includes_rounding_in_its_bounds():
    word = from_strings(["011032"])
    found = enclosed("011032", 1.0)
    row = as_orbits(word, Stadium(1.0), [found])
    assert row.status[0] == Status.BOUNDARY
    assert row.margin[0] == 0  # exactly, because this is proved
    for x, ball in zip(row.coordinates[0].tolist(), found.coordinates, strict=True):
        assert abs(ball - x) <= row.error[0]
    assert abs(found.length - float(row.length[0])) <= row.length_error[0]
    assert abs(found.lyapunov - float(row.lyapunov[0])) <= row.lyapunov_error[0]
    assert row.residual[0] == np.abs(forces(Stadium(1.0), word, row.coordinates)).max() < 1e-15
    assert row.error[0] < 1e-15
