"""Sum rules from power series: the tilted sums and the averages are those of the orbits themselves."""

import numpy as np
import pytest

from orbitdb.averages import sum_rules as module
from orbitdb.averages.sum_rules import beginning, next_tilts, orbits_of_exponents, swept_sum_rules
from orbitdb.averages.tilt_moments import TiltedOrbits, TiltMoments, from_bytes, to_bytes
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.sums import exponents
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.symmetry import SIZES


@pytest.mark.parametrize("k", range(4))
def test_series_give_the_sums_near_their_centre(k):
    rng = np.random.default_rng(k)
    orbits = TiltedOrbits(*(rng.normal(size=size) for size in (3000, (k, 3000), 3000, 3000)))
    centre, step = rng.normal(size=k) / 3, rng.normal(size=k) / 50
    parts = [
        TiltMoments.of(centre, TiltedOrbits(*(column[..., part] for column in vars(orbits).values())))
        for part in (slice(0, 1000), slice(1000, 3000))
    ]
    moments = TiltMoments.joined(parts)
    assert TiltMoments.joined(parts[::-1]) == moments
    assert from_bytes(to_bytes({k: moments})) == {k: moments}
    found, expected = moments.at(centre + step), orbits.at(centre + step)
    for name in ("total", "slope", "spread", "rest", "legs"):
        close = pytest.approx(getattr(expected, name), rel=1e-9, abs=1e-9 * expected.total)
        assert getattr(found, name) == close, name
    assert abs(found.total - expected.total) <= found.missing + 1e-12 * expected.total


def test_bytes_of_something_else_are_refused():
    good = to_bytes({2: TiltMoments.none(np.zeros(2))})
    for wrong in (good[:-8], np.full(9, 7.0).tobytes(), np.full(9, np.nan).tobytes()):
        with pytest.raises(ValueError, match="moments"):
            from_bytes(wrong)


@pytest.mark.parametrize("a", [0.5, pytest.param(1.6, marks=pytest.mark.slow)])
def test_averages_are_those_of_all_orbits(monkeypatch, a):
    first, last = (7, 9) if a == 0.5 else (9, 12)
    monkeypatch.setattr(module, "EXACT", last)
    beginning.cache_clear()
    expected = swept_sum_rules(a, [], last)
    monkeypatch.setattr(module, "EXACT", first)
    beginning.cache_clear()
    moments: list[dict[int, TiltMoments]] = []
    for p in range(first + 1, last + 1):
        parts = [
            orbits_of_exponents(SIZES[words.stabiliser[part.orbits]], part, a)
            for words in least_words(Span.whole(p))
            for part in exponents(words.codes, p, Stadium(a))
        ]
        orbits = TiltedOrbits.joined(parts)
        tilts = next_tilts(a, moments).items()
        moments.append({level: TiltMoments.of(mu, orbits.held(level)) for level, mu in tilts})
    found = swept_sum_rules(a, moments, last + 1)
    less = swept_sum_rules(a, [{min(each): each[min(each)]} for each in moments], last)
    beginning.cache_clear()
    beyond = expected.p > first
    assert (less.level == expected.level - beyond).all()
    np.testing.assert_allclose(less.lambda_l[beyond], expected.lambda_l_below[beyond], rtol=0, atol=1e-7)
    assert np.isnan(less.lambda_l_below[beyond]).all()
    assert found.level[:-1].tolist() == expected.level.tolist()
    np.testing.assert_allclose(found.lambda_l[:-1], expected.lambda_l, rtol=0, atol=1e-7)
    np.testing.assert_allclose(found.lambda_l_error[:-1], expected.lambda_l_error, rtol=0, atol=1e-6)
    assert np.isnan(found.lambda_l[-1])
