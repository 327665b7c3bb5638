"""How often the statements of `assess` are right, in windows cut from exact and from published levels."""

import numpy as np
import pytest
from calibration import KINDS, Kind, Source, Tally, exact, public, staircase_of, windows
from quick import fuzz_but

from orbitdb import Catalogue, levels
from orbitdb.quantum.weyl import Parity


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    made = Catalogue.create(tmp_path_factory.mktemp("calibration") / "orbits.db", 1.6)
    made.fill("2-10")
    made.fill("2-10", a=1.0)
    return made


@pytest.fixture(scope="module")
def to_40(made_once):
    """All levels of three parities below k = 40 at a = 1.6."""

    def make(path):
        oo, ee, eo = (levels(1.6, 40.0, parity=parity).k for parity in ("oo", "ee", "eo"))
        with path.open("wb") as file:
            np.savez(file, oo=oo, ee=ee, eo=eo)

    return dict(np.load(made_once("levels-to-40", make)))


def holds(statements, margin):
    """Return whether statements are as often right as they say, within a margin and two standard errors."""
    said, right = np.mean(statements, axis=0)
    error = np.sqrt(said * (1 - said) / len(statements))
    return said - margin[0] - 2 * error <= right <= said + margin[1] + 2 * error


@pytest.mark.slow
def test_a_few_windows_are_judged_rightly(catalogue, exact_once):
    tally, rng = Tally(), np.random.default_rng(7)
    source = Source(1.6, Parity.OO, exact_once, 1)
    for kind in KINDS[:3]:
        tally.measure(staircase_of(catalogue, source), windows(rng, source, 20, kind, 4))
    assert tally.refused == 0
    assert sum(right for _, right in tally.first) >= 10


@pytest.mark.fuzz
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_statements_about_windows_of_one_parity_are_as_often_right_as_they_say(catalogue, to_40, kind):
    tally, rng = Tally(), np.random.default_rng(1992)
    for parity, k in to_40.items():
        source = Source(1.6, Parity(parity), k[20:], 21)
        tally.measure(staircase_of(catalogue, source), windows(rng, source, 60, kind, 15))
    assert tally.refused <= 1
    assert holds(tally.first, (0.1, 0.15))
    assert all(right for _, right in tally.sure)
    assert not tally.rows or holds(tally.rows, (0.1, 0.15))
    assert np.mean(tally.within) >= 0.85


@pytest.mark.slow
@pytest.mark.parametrize("kind", fuzz_but(KINDS[1:3], KINDS), ids=lambda kind: kind.name)
def test_statements_about_published_windows_at_770_are_as_often_right_as_they_say(catalogue, kind):
    tally, rng = Tally(), np.random.default_rng(1992)
    source = public()[1]
    tally.measure(staircase_of(catalogue, source), windows(rng, source, 100, kind, 30))
    assert tally.refused <= 1
    assert holds(tally.first, (0.1, 0.15))
    assert len(tally.rows) <= 5 if kind is KINDS[0] else holds(tally.rows, (0.1, 0.15))


def test_windows_lack_inner_levels_and_have_others():
    k = np.arange(1.0, 101.0)
    window = next(windows(np.random.default_rng(1), Source(1.6, None, k, 7), 50, Kind("", 0.1, 0.04), 1))
    assert (len(window.k), len(window.missing), len(window.spurious)) == (52, 5, 2)
    assert window.k[0] == k[window.first - 7]
    assert not np.isin(window.missing, window.k).any()
    assert window.k[0] < window.missing.min() < window.missing.max() < window.k[-1]


@pytest.mark.slow
def test_exact_levels_of_a_range_have_their_numbers(catalogue, exact_once):
    begin = float(exact_once[10]) - 1e-9
    source = exact(catalogue, 1.6, Parity.OO, begin, float(exact_once[14]))
    assert source.first == 11
    assert source.k == pytest.approx(exact_once[10:14])
