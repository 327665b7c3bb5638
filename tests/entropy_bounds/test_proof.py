"""Verdicts on windows in ball arithmetic, which prove exactly those of doubles."""

import numpy as np
import pytest
from edges import texts_of
from flint import arb
from quick import slow_but

from orbitdb.billiard.legs import direction_limits
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds import proof as module
from orbitdb.entropy_bounds.bounds import search
from orbitdb.entropy_bounds.proof import Proof, condition_in_balls, limits_hold, proved
from orbitdb.entropy_bounds.verdicts import Decision, Verdict, corner, decide_windows, solve_corner
from orbitdb.entropy_bounds.windows import MIRROR, Windows, extended, first_windows, open_chains

OPPOSITE = np.array([Verdict.UNDECIDED, Verdict.FORBIDDEN, Verdict.ALLOWED], dtype=np.uint8)


def levels(a: float, edges: int) -> list[tuple[Windows, Decision]]:
    windows, found = first_windows(), []
    while windows.edges <= edges:
        decision = decide_windows(windows, a)
        found.append((windows, decision))
        undecided = decision.verdict == Verdict.UNDECIDED
        windows = extended(windows.rows(undecided), decision.extend_left[undecided])
    return found


@pytest.mark.parametrize(("a", "edges", "least"), slow_but(1, [(0.5, 6, 150), (0.5, 8, 400), (1.6, 8, 400)]))
def test_balls_prove_every_verdict_and_nothing_else(a, edges, least):
    """Balls prove neither the opposite verdict nor any verdict on an undecided window."""
    decided = 0
    for windows, decision in levels(a, edges):
        some = decision.verdict != Verdict.UNDECIDED
        decided += some.sum()
        assert (proved(windows, decision.verdict, a) == some).all()
        assert not proved(windows, OPPOSITE[decision.verdict], a).any()
        if windows.edges <= 6:
            mirrored = Windows(MIRROR[windows.letters], windows.mark)
            assert (proved(mirrored, decision.verdict, a) == some).all()
        for verdict in (Verdict.ALLOWED, Verdict.FORBIDDEN):
            claimed = np.where(some, Verdict.UNDECIDED, verdict)
            assert not proved(windows, claimed, a).any(), texts_of(windows.rows(~some))
    assert decided > least


@pytest.mark.slow
@pytest.mark.parametrize("a", [1e-3, 0.05, 10.0])
def test_proved_bounds_equal_those_of_doubles(a):
    kept = Proof()
    assert list(search(Stadium(a), edges=7, decider=kept.decide_windows)) == list(search(Stadium(a), edges=7))
    assert kept.left_open == 0 < kept.proved


def test_balls_report_progress():
    told = []
    windows, decision = levels(1.6, 4)[-1]
    proved(windows, decision.verdict, 1.6, lambda *state: told.append(state))
    assert told == [(0, np.count_nonzero(decision.verdict), "4 letters: ball arithmetic")]


def test_an_unproved_verdict_counts_as_undecided(monkeypatch):
    """A falsified verdict is left open and counted, and no bound relies on it."""

    def wrong(windows, a, tell=None):
        decision = decide_windows(windows, a, tell)
        verdict = decision.verdict.copy()
        if len(some := np.flatnonzero(verdict)):
            verdict[some[0]] = OPPOSITE[verdict[some[0]]]
        return Decision(verdict, decision.extend_left)

    sound = list(search(Stadium(1.6), edges=7))[-1]
    monkeypatch.setattr(module, "decide_windows", wrong)
    kept = Proof()
    found = list(search(Stadium(1.6), edges=7, decider=kept.decide_windows))[-1]
    assert kept.left_open == 5  # one per level, from the third letter on
    assert found.undecided > sound.undecided
    assert found.lower <= sound.lower < sound.upper <= found.upper


@pytest.mark.parametrize("a", slow_but([0.3], [1e-3, 0.3, 1.6]))
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_balls_are_right_from_any_starting_directions(way, a):
    """The ball contains f at the clamped directions, whatever the starting directions are.

    Directions that are all off by the same amount, some up and some down, need the full radius of the proof.
    """
    random = np.random.default_rng(1)
    for windows, _ in levels(a, 5):
        for _, chains in open_chains(windows):
            problem = corner(chains, a, way * chains.sense, way * chains.lean)
            exact = solve_corner(problem, a, np.zeros(len(chains)))
            shape = problem.low.shape
            starts = [random.normal(size=shape)]
            starts += [exact.alpha + off * random.choice([-1.0, 1.0], shape) for off in (0.2, 0.6, 1.2, 1.2)]
            for start in starts:
                for column, (value, error) in enumerate(zip(exact.value, exact.error, strict=True)):
                    found = condition_in_balls(problem, column, a, start.T.tolist()[column])
                    assert found is not None
                    assert found.overlaps(arb(value, error))


@pytest.mark.parametrize("a", [1e-4, 0.3, 1.6])
def test_newton_steps_until_the_sign_is_known_or_the_error_is_rounding(a):
    for windows, _ in levels(a, 6):
        for _, chains in open_chains(windows):
            for way in (-1.0, 1.0):
                problem = corner(chains, a, way * chains.sense, way * chains.lean)
                found = solve_corner(problem, a, np.zeros(len(chains)))
                assert ((np.abs(found.value) > found.error) | (found.error < 1e-12)).all()


@pytest.mark.parametrize(("nearer", "a"), [(0.9, 0.05), (1 - 1e-3, 0.05), (0.83, 20.0)])
def test_direction_limits_are_proved_before_they_are_used(monkeypatch, nearer, a):
    assert all(limits_hold(40, a) for a in (1e-6, 0.05, 1.0, 1.6, 20.0, 1e6))
    monkeypatch.setattr(
        module, "direction_limits", lambda *at: tuple(nearer * x for x in direction_limits(*at))
    )
    assert not limits_hold(40, a)
