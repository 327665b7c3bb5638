"""The checks of stored orbits accept everything within the rows' own bounds, and little more."""

from dataclasses import replace

import numpy as np
import pytest
from bounce_checks import Row, checked, exponents
from solutions import representatives
from there import there

from orbitdb.billiard.stability import Links, hessian
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.status import EXISTING, NUMBERS, Orbits
from orbitdb.verification.check import Check
from orbitdb.verification.invariants import check_consistency, with_bounds

CHECKS = ("walls", "margins", "reflection", "residuals", "lengths", "lambda", "signature", "Hessian")
USED = {"margins": 0.99, "reflection": 0.7, "lengths": 0.15, "lambda": 0.05, "Hessian": 0.002}
"""Shares of the tolerance that some moved rows reach."""


def moved_by(orbits: Orbits, stadium: Stadium, move: np.ndarray) -> Orbits:
    """Return rows whose bounces are off by their full bounds, with exact length and lambda."""
    size, nothing = np.abs(move).max(axis=1), np.zeros(len(orbits))
    places = orbits.coordinates + move
    links = Links.of(stadium, orbits.words, places)
    residual = np.abs(links.cos_in - links.cos_out).max(axis=1)
    return replace(
        orbits,
        coordinates=places,
        residual=residual,
        error=size,
        length_error=nothing,
        lyapunov_error=nothing,
    )


@pytest.mark.parametrize(("a", "p", "size"), [(0.3, 7, 1e-6), (6.0, 5, 1e-4)])
def test_rows_at_their_bounds_pass_and_nearly_exhaust_them(a, p, size):
    stadium = Stadium(a)
    orbits = solve(representatives(p), stadium)
    ends = np.where(STRAIGHT[orbits.words], a, HALF_PI) - np.abs(orbits.coordinates)
    orbits = orbits.rows((orbits.status == "orbit") & (ends.min(axis=1) > 2 * size))
    rng = np.random.default_rng(p)
    largest = dict.fromkeys(USED, 0.0)
    for _ in range(20):
        move = size * rng.choice([-1.0, 1.0], orbits.coordinates.shape)
        for check in check_consistency(moved_by(orbits, stadium, move), stadium):
            assert not check.failures, check
            if check.name in largest:
                largest[check.name] = max(largest[check.name], there(check.share))
    for name, share in USED.items():
        assert largest[name] > share, (name, largest)


def off_by(orbits: Orbits, size: float, error: float) -> Orbits:
    """Return rows whose bounces and numbers are off by `size`, with `error` as the stated bounds."""
    rng, told = np.random.default_rng(3), np.full(len(orbits), error)
    numbers = {name: getattr(orbits, name) + size * rng.uniform(1, 2, len(orbits)) for name in NUMBERS[:4]}
    places = orbits.coordinates + size * rng.uniform(-1, 1, orbits.coordinates.shape)
    return replace(orbits, coordinates=places, error=told, length_error=told, lyapunov_error=told, **numbers)


def row_of(orbits: Orbits, i: int, a: float) -> Row:
    numbers = {name: float(getattr(orbits, name)[i]) for name in NUMBERS}
    word, x = tuple(orbits.words[i].tolist()), tuple(orbits.coordinates[i].tolist())
    return Row(a, word, x, orbits.status[i] == "boundary", **numbers)


@pytest.mark.parametrize(("a", "p"), [pytest.param(0.3, 6, marks=pytest.mark.slow), (1.0, 4), (1.6, 6)])
def test_deviations_and_tolerances_agree_with_a_check_bounce_by_bounce(a, p):
    """Some rows can be checked in full, others only partly; some are slightly off, with bounds of 0."""
    stadium = Stadium(a)
    exact = solve(representatives(p), stadium)
    exact = exact.rows(np.isin(exact.status, EXISTING))
    exact = exact.rows(np.arange(0, len(exact), max(1, len(exact) // 6)))
    told = dict.fromkeys(CHECKS, 0)
    mirrored = replace(exact, coordinates=-exact.coordinates)  # their runs go backwards
    for size, error in ((1e-7, 0.0), (1e-4, 2e-4), (2e-3, 1e-3), (2e-2, 1e-2), (0.1, 3e-2)):
        rows = off_by(mirrored if size == 0.1 else exact, size, error)
        alone = {name: Check(name, 0) for name in CHECKS}
        for i in range(len(rows)):
            expected = checked(row_of(rows, i, a))
            for check in check_consistency(rows.rows(np.array([i])), stadium):
                count, worst, share = expected[check.name]
                assert check.rows == count, check
                alone[check.name] = alone[check.name].joined(check)
                near = 0.3 if check.name == "lambda" and not error else 1e-5
                if check.name == "signature":
                    assert check.failures == (worst > 0)
                elif count:
                    assert (check.worst, check.share) == pytest.approx((worst, share), rel=near), check
        for check in check_consistency(rows, stadium):
            one = alone[check.name]
            assert check == replace(one, worst=check.worst, share=check.share)
            assert (check.worst or 0, check.share or 0) == pytest.approx((one.worst or 0, one.share or 0))
            told[check.name] += check.rows
    assert all(told.values())


@pytest.mark.parametrize("a", [0.5, 3.0])
def test_bounds_derived_for_rows_without_them_hold_and_are_sharp(a):
    """Rows without bounds, as from the relaxation, are moved where forces show it least; others stay."""
    stadium = Stadium(a)
    exact = solve(representatives(6), stadium)
    exact = exact.rows(exact.status == "orbit")
    values, vectors = np.linalg.eigh(hessian(stadium, exact.words, exact.coordinates))
    softest = np.abs(values).argmin(axis=1)[:, None, None]
    move = 1e-6 * np.take_along_axis(vectors, softest, axis=2)[:, :, 0]
    rows = moved_by(exact, stadium, move)
    bare = np.arange(len(rows)) % 5 > 0
    none = np.where(bare, np.nan, 1e-3)
    found = with_bounds(replace(rows, error=none, length_error=none, lyapunov_error=none), stadium)
    for bounds in (found.error, found.length_error, found.lyapunov_error):
        assert (bounds[~bare] == 1e-3).all()
    found, exact, off = found.rows(bare), exact.rows(bare), np.abs(move).max(axis=1)[bare]
    assert found.error / off == pytest.approx(2 * np.sqrt(6), rel=1e-2)
    links = Links.of(stadium, found.words, found.coordinates)
    short = np.abs(links.after.sum(axis=1) - exact.length)
    assert (short <= found.length_error).all()
    sizes = np.abs(np.linalg.eigvalsh(hessian(stadium, found.words, found.coordinates)))
    place = 4 * np.finfo(float).eps * (a + 2)
    expected = 2 * np.sqrt(6) * (found.residual + 2 * place) / sizes.min(axis=1)
    np.testing.assert_allclose(found.error, expected, rtol=1e-10)
    expected = 6 * (sizes.max(axis=1) * found.error**2 + 2 * place)
    np.testing.assert_allclose(found.length_error, expected, rtol=1e-10)
    still = with_bounds(replace(found, error=found.error * np.nan, residual=0 * found.residual), stadium)
    np.testing.assert_allclose(still.error, 4 * np.sqrt(6) * place / sizes.min(axis=1), rtol=1e-10)
    spread = [exponents(row_of(found, i, a))[1] for i in range(len(found))]
    np.testing.assert_allclose(found.lyapunov_error, spread, rtol=1e-6)
    in_run = (found.words == np.roll(found.words, -1, axis=1)).any(axis=1)
    with np.errstate(all="ignore"):  # coinciding bounces cause divisions by 0
        lost = with_bounds(replace(still, error=none[bare], coordinates=0 * found.coordinates), stadium)
    assert np.isinf(lost.error[in_run]).sum() == in_run.sum() > 0
