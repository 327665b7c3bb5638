"""How often the statements of `assess` are right, in windows cut from exact levels."""

import numpy as np
import pytest
from calibration import Tally, exact, matched, measure, windows

from orbitdb import Catalogue

# what must hold: first numbers, levels found and false ones; statements with P above .99, and from .9 on,
# within two standard errors of so few
FIRST, FOUND, FALSE, SURE, LIKELY = 0.95, 0.94, 0.02, 0.98, 0.90


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    made = Catalogue.create(tmp_path_factory.mktemp("calibration") / "orbits.db", 1.6)
    made.fill("2-10")
    return made


@pytest.fixture(scope="module")
def to_40(made_once):
    """All levels of three parities below k = 40 at a = 1.6."""

    def make(path):
        with path.open("wb") as file:
            np.savez(file, oo=exact(1.6, "oo", 40.0), ee=exact(1.6, "ee", 40.0), eo=exact(1.6, "eo", 40.0))

    return dict(np.load(made_once("levels-to-40", make)))


@pytest.mark.slow
def test_a_few_windows_are_judged_rightly(catalogue, exact_once):
    tally = measure(catalogue, windows(np.random.default_rng(7), 1.6, "oo", exact_once, 8))
    assert tally.first >= 7
    assert tally.found >= FOUND * tally.missing
    assert tally.false <= 1


@pytest.mark.slow
@pytest.mark.parametrize("spurious", [False, True])
def test_statements_about_windows_of_one_parity_are_as_often_right_as_they_say(catalogue, to_40, spurious):
    tally, rng = Tally(), np.random.default_rng(1992)
    for parity, k in to_40.items():
        for window in windows(rng, 1.6, parity, k, 20, spurious):
            tally.add(window, catalogue.assess(window.k, parity=parity, window=True))
    first, found, false = tally.shares()
    assert first >= FIRST
    assert found >= FOUND
    assert false < FALSE
    for name, right in tally.claims.items():
        share = SURE if ">" in name else LIKELY
        assert np.mean(right) >= share - 2 * np.sqrt(share * (1 - share) / len(right))


def test_missing_levels_are_paired_once():
    assert matched(np.array([1.0, 2.0]), np.array([1.4])) == 1
    assert matched(np.array([1.0, 2.0]), np.array([0.0, 3.0])) == 2
    assert matched(np.array([1.0]), np.array([2.6])) == 0
