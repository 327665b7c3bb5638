"""Rows against new solutions: what is off in one number of one row is found, and how far off it is."""

from dataclasses import replace

import numpy as np
import pytest
from solutions import representatives

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import EXISTING, NUMBERS, Orbits
from orbitdb.symbols.words import to_strings
from orbitdb.verification.recomputation import BOUNDED, check_against, check_bits
from orbitdb.verification.rigorous import prove

EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def solved() -> Orbits:
    """Orbits, orbits through a joint, and words that are none, as they are stored."""
    orbits = solve(representatives(6), Stadium(1.0))
    kept = np.isin(orbits.status, EXISTING)
    empty = {name: np.where(kept, getattr(orbits, name), np.nan) for name in NUMBERS if name != "margin"}
    places = np.where(kept[:, None], orbits.coordinates, np.nan)
    assert {"orbit", "boundary", "dynamical"} == set(orbits.status.tolist())
    return replace(orbits, coordinates=places, **empty)


def changed(orbits: Orbits, name: str, row: int, value: float) -> Orbits:
    """Return rows of which one has another value, or another first coordinate."""
    values = getattr(orbits, name).copy()
    values[(row, 0) if values.ndim == 2 else row] = value
    return replace(orbits, **{name: values})


def first(orbits: Orbits, name: str, row: int) -> float:
    return float(getattr(orbits, name)[row].flat[0])


@pytest.mark.parametrize("name", BOUNDED)
def test_of_bounds_the_share_is_told_that_is_used(solved, name):
    row = int(np.flatnonzero(solved.status == "orbit")[3])
    allowed = 2 * first(solved, BOUNDED[name], row)
    for by in (0.5, 1.5):
        moved = changed(solved, name, row, first(solved, name, row) + by * allowed)
        found = {check.name: check for check in check_against(moved, solved)}
        assert found["bounds"].share == pytest.approx(by, rel=0.2)  # bounds are a few last digits wide
        assert found["bounds"].first == (to_strings(solved.words)[row] if by > 1 else None)
        assert found["bounds"].rows == np.isin(solved.status, EXISTING).sum()
        assert found["statuses"].failures == found["unresolved"].failures == 0


def test_margins_have_the_side_of_the_status(solved):
    """At a joint it may be either."""
    others = replace(solved, margin=-solved.margin)
    statuses, *_ = check_against(others, solved)
    assert statuses.failures == (solved.status != "boundary").sum() < len(solved)


@pytest.mark.parametrize("name", ["coordinates", "iterations", *NUMBERS])
def test_a_last_bit_is_found(solved, name):
    assert check_bits(solved, solved).failures == 0
    for status in ("orbit", "dynamical"):
        row = int(np.flatnonzero(solved.status == status)[2])
        value = first(solved, name, row)
        other = value + 1 if name == "iterations" else 0.0 if np.isnan(value) else np.nextafter(value, np.inf)
        found = check_bits(changed(solved, name, row, other), solved)
        assert (found.failures, found.first) == (1, to_strings(solved.words)[row])


def test_proofs_know_how_far_a_number_may_be(solved):
    """A margin may be off by the error of a place and its rounding, others by their own bounds."""
    stadium, rows = Stadium(1.0), solved.rows(np.flatnonzero(np.isin(solved.status, EXISTING))[:6])
    check, proved, radius, bits = prove(rows, stadium)
    assert proved.all()
    assert (check.failures, set(bits)) == (0, {128})
    assert (radius <= rows.error).all()
    place = 4 * EPS * 3.0
    allowed = {"margin": first(rows, "error", 2) + place} | {
        name: first(rows, bound, 2) for name, bound in BOUNDED.items()
    }
    for name, most in allowed.items():
        for by, right in ((0.3, True), (3.0, False)):
            moved = changed(rows, name, 2, first(rows, name, 2) + by * most)
            check, proved, *_ = prove(moved, stadium)
            assert proved.tolist() == [right or row != 2 for row in range(6)], (name, by)
    for bound in BOUNDED.values():
        check, proved, *_ = prove(changed(rows, bound, 2, 0.0), stadium)
        assert proved.tolist() == [row != 2 for row in range(6)]
        assert check.share == np.inf
    wrong = replace(rows, status=np.where(np.arange(6) == 4, "dynamical", rows.status))
    assert prove(wrong, stadium)[1].tolist() == [True] * 4 + [False, True]
