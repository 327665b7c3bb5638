"""The sharpness of the checks of orbits: sound ones pass, and an error in a single number is found."""

from dataclasses import replace

import numpy as np
import pytest
from quick import slow_but
from solutions import representatives

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbits import NUMBERS, Orbits
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import EXISTING
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import from_strings, parse, to_strings
from orbitdb.verification.check_orbits import BOUNDED, check_against, check_consistency, prove, restart

STADIUMS = (1e-6, 1e-3, 0.2, 0.5, 1.0, 1.6, 2.5, 10.0, 1e4, 1e6)


@pytest.mark.parametrize("a", slow_but([1e-6, 1.6], STADIUMS))
def test_every_sound_orbit_passes_at_any_a(a):
    stadium = Stadium(a)
    for p in (2, 3, 6, 7):
        orbits = solve(representatives(p), stadium)
        for check in check_consistency(orbits.rows(np.isin(orbits.status, EXISTING)), stadium):
            assert not check.failures, check
        assert not restart(orbits.words, stadium, 2, np.random.default_rng(p)).failures


@pytest.mark.slow
@pytest.mark.parametrize("code", ["1^1000 5^1000", "1 2 (02)^300 3 2 (02)^300", "1^7 5^6"])
def test_long_orbits_pass(code):
    orbits = solve(from_strings([parse(code)]), Stadium())
    assert orbits.status.tolist() == ["orbit"]
    found = {check.name: check for check in check_consistency(orbits, Stadium())}
    assert found["reflection"].rows == found["lambda"].rows == 1
    assert not any(check.failures for check in found.values())


@pytest.mark.parametrize("a", slow_but([1.6], [0.2, 1.0, 1.6, 10.0]))
@pytest.mark.parametrize("p", [8, 40, 100])
def test_a_solution_has_the_same_bits_in_any_batch(a, p):
    rng = np.random.default_rng(p)
    if p == 8:
        words = representatives(8)
    else:
        runs = rng.integers(1, 4, size=(60, p))
        texts = ["".join("1" * k if i % 2 == 0 else "3" * k for i, k in enumerate(row)) for row in runs]
        words = from_strings(sorted({text[: p - 1] + "3" for text in texts if text[p - 2] in "13"}))
    orbits = solve(words, Stadium(a))
    for size in (1, 2, 5, 30):
        rows = rng.permutation(len(words))[:size]
        again = solve(words[rows], Stadium(a))
        for name in ("coordinates", "iterations", *NUMBERS):
            assert getattr(again, name).tobytes() == getattr(orbits.rows(rows), name).tobytes()


def moved(orbits: Orbits, name: str, by: float) -> Orbits:
    """Move one number of the first row by a multiple of its error bound."""
    bound = {"coordinates": "error", "length": "length_error", "lyapunov": "lyapunov_error"}[name]
    values = getattr(orbits, name).copy()
    values[0] += by * getattr(orbits, bound)[0]
    return replace(orbits, **{name: values})


@pytest.mark.parametrize(
    ("name", "suspected"),
    [
        ("coordinates", {"reflection", "walls"}),
        ("length", {"lengths"}),
        ("lyapunov", {"lambda", "Hessian"}),
    ],
)
@pytest.mark.parametrize("a", [0.5, 1.6])
def test_consistency_alone_finds_a_moved_number(a, name, suspected):
    """A shift of a thousand bounds is enough for the checks by plane geometry."""
    stadium = Stadium(a)
    orbits = solve(representatives(7), stadium)
    orbits = orbits.rows(orbits.status == "orbit")
    for by, expected in ((1e3, suspected), (0.1, set())):
        found = {c.name: c for c in check_consistency(moved(orbits, name, by), stadium)}
        failing = {check for check in found if found[check].failures}
        assert bool(failing & suspected) == bool(expected)
        assert all(found[check].first == to_strings(orbits.words[:1])[0] for check in failing)


EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def solved() -> Orbits:
    """Return orbits, orbits through a joint, and words that have no orbit, as they are stored."""
    orbits = solve(representatives(6), Stadium(1.0))
    kept = np.isin(orbits.status, EXISTING)
    empty = {name: np.where(kept, getattr(orbits, name), np.nan) for name in NUMBERS if name != "margin"}
    places = np.where(kept[:, None], orbits.coordinates, np.nan)
    assert {"orbit", "boundary", "dynamical"} == set(orbits.status.tolist())
    return replace(orbits, coordinates=places, **empty)


def changed(orbits: Orbits, name: str, row: int, value: float) -> Orbits:
    """Return rows in which one value, or one first coordinate, is changed."""
    values = getattr(orbits, name).copy()
    values[(row, 0) if values.ndim == 2 else row] = value
    return replace(orbits, **{name: values})


def first(orbits: Orbits, name: str, row: int) -> float:
    return float(getattr(orbits, name)[row].flat[0])


@pytest.mark.parametrize("name", BOUNDED)
def test_the_check_of_bounds_states_the_share_used(solved, name):
    row = int(np.flatnonzero(solved.status == "orbit")[3])
    allowed = 2 * first(solved, BOUNDED[name], row)
    for by in (0.5, 1.5):
        moved = changed(solved, name, row, first(solved, name, row) + by * allowed)
        found = {check.name: check for check in check_against(moved, Stadium(1.0))}
        assert found["bounds"].share == pytest.approx(by, rel=0.2)  # bounds are a few last digits wide
        assert found["bounds"].first == (to_strings(solved.words)[row] if by > 1 else None)
        assert found["bounds"].rows == np.isin(solved.status, EXISTING).sum()
        assert found["statuses"].failures == 0


def test_the_sign_of_a_margin_must_match_the_status(solved):
    """At a joint, a margin may have either sign."""
    others = replace(solved, margin=-solved.margin)
    statuses, *_ = check_against(others, Stadium(1.0))
    assert statuses.failures == (solved.status != "boundary").sum() < len(solved)


def test_proofs_accept_exactly_the_allowed_deviations(solved):
    """A margin may be off by the error of a position and its rounding, other numbers by their own bounds."""
    stadium, rows = Stadium(1.0), solved.rows(np.flatnonzero(np.isin(solved.status, EXISTING))[:6])
    check, proved, radius, bits = prove(rows, stadium)
    assert proved == [True] * 6
    assert (check.failures, set(bits)) == (0, {128})
    assert (radius <= rows.error).all()
    place = 4 * EPS * 3.0
    allowed: dict[str, float] = {"margin": first(rows, "error", 2) + place}
    allowed |= {name: first(rows, bound, 2) for name, bound in BOUNDED.items()}
    for name, most in allowed.items():
        for by, right in ((0.3, True), (3.0, False)):
            moved = changed(rows, name, 2, first(rows, name, 2) + by * most)
            check, proved, *_ = prove(moved, stadium)
            assert proved == [right or row != 2 for row in range(6)], (name, by)
    for bound in BOUNDED.values():
        check, proved, *_ = prove(changed(rows, bound, 2, 0.0), stadium)
        assert proved == [row != 2 for row in range(6)]
        assert check.share == np.inf
    wrong = replace(rows, status=np.where(np.arange(6) == 4, "dynamical", rows.status))
    assert prove(wrong, stadium)[1] == [True] * 4 + [False, True]


def test_an_area_that_symmetry_makes_0_is_proved_exactly():
    solved = solve(from_strings(["0103", "0123", "0113"]), Stadium())
    stabilisers = [class_of(word).stabiliser for word in to_strings(solved.words)]
    orbits = solved.with_symmetries(np.array(stabilisers, np.uint8))
    assert (orbits.area_error == 0).tolist() == [True, False, False]
    assert prove(orbits, Stadium())[1] == [True] * 3
    assert prove(changed(orbits, "area", 0, 1e-300), Stadium())[1] == [False, True, True]
