"""The checks of stored orbits accept everything within the rows' own bounds, and little more."""

from dataclasses import replace

import numpy as np
import pytest
from solutions import representatives
from there import there

from orbitdb.billiard.stability import Links, hessian
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.solve import solve
from orbitdb.verification.check_orbits import check_consistency, with_bounds

USED = {"walls": 0.99, "reflection": 0.7, "lengths": 0.15, "lambda": 0.05, "Hessian": 0.002}
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
    assert (np.abs(found.lyapunov - exact.lyapunov) <= found.lyapunov_error).all()
    assert np.median(found.lyapunov_error) < 1e-3
    in_run = (found.words == np.roll(found.words, -1, axis=1)).any(axis=1)
    with np.errstate(all="ignore"):  # coinciding bounces cause divisions by 0
        lost = with_bounds(replace(still, error=none[bare], coordinates=0 * found.coordinates), stadium)
    assert np.isinf(lost.error[in_run]).sum() == in_run.sum() > 0
