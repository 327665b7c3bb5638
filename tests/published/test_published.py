"""Numbers that others have published, computed by other means; each has its source."""

import math
from pathlib import Path

import numpy as np
import pytest
from quick import fuzz_but
from there import there

from orbitdb import Catalogue, levels, solve_word
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import search
from orbitdb.entropy_bounds.windows import geometric_entropy

# Half the lengths of orbits at a = 1: repository dionatandiego11/hipotese-riemann, file catalogo_o1.csv.
HALF_LENGTHS = {
    "0123": 4.472135955,
    "0103": 4.828427125,
    "011255": 4.889431983,
    "111555": 5.0,
    "01112555": 5.014969587,
    "11115555": 5.061467459,
}

# Levels of the quarter stadium, a = 1, odd in x and y, by the scaling method (program vergini): repository
# ktkonrad/qc, file results/qust_all_counts.txt. The last one has the largest error found.
LEVELS = {100.088506: 2e-6, 100.283590: 2e-6, 100.192329: 1.4e-4}

# a at which the gap between the n-th level, even in x and y, and the next is least: Neuberger, Neuberger and
# Noid, math/0105217.
AVOIDED_CROSSINGS = {3: 0.785, 4: 1.51}

# Bounds on the topological entropy per bounce: at most, in every stadium, Cinc and Troubetzkoy,
# arXiv 2203.15344; at least, in long ones, Misiurewicz and Zhang, arXiv 2006.03882.
AT_MOST, AT_LEAST = math.log(3.49066), math.log(1 + math.sqrt(2))


@pytest.mark.parametrize("code", HALF_LENGTHS)
def test_lengths_at_a_1(code):
    orbit = solve_word(code, 1.0)
    assert there(orbit.length) / 2 == pytest.approx(HALF_LENGTHS[code], abs=6e-10)


@pytest.mark.slow
@pytest.mark.parametrize("published", fuzz_but([100.192329], LEVELS))
def test_levels_near_k_100(published):
    found = levels(1.0, (published - 0.003, published + 0.003), parity=["oo"])
    assert len(found.k) == 1
    assert found.k[0] == pytest.approx(published, abs=LEVELS[published])
    assert found.error[0] < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("number", AVOIDED_CROSSINGS)
def test_avoided_crossings(number):
    """Near its least value, the square of the gap is a parabola in a; the energies are those of unit area."""
    published = AVOIDED_CROSSINGS[number]
    half_lengths = published + np.array([-0.02, 0.0, 0.02])
    gaps = []
    for a in half_lengths.tolist():
        k = levels(a, 5.0, parity=["ee"]).k
        gaps.append((k[number] ** 2 - k[number - 1] ** 2) * Stadium(a).area)
    curve = np.polyfit(half_lengths - published, np.square(gaps), 2)
    assert curve[0] > 0
    assert -curve[1] / (2 * curve[0]) == pytest.approx(0, abs=0.003)


def test_the_entropy_of_the_geometric_rules_is_below_the_published_bound():
    assert geometric_entropy() == pytest.approx(math.log(3.38298), abs=2e-6)
    assert geometric_entropy() < AT_MOST - 0.03


@pytest.mark.parametrize("a", [1.6, 10.0, 1000.0])
def test_proved_bounds_on_the_entropy_lie_between_the_published_ones(a):
    *_, bounds = search(Stadium(a), edges=6)
    assert AT_LEAST < bounds.lower <= bounds.upper < AT_MOST


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "levels", "first", "gaps"),
    [
        ("k100", 108, 1377, [(101.386919, 101.605151, 7)]),
        ("k104", 166, 1492, [(106.998214, 107.208064, 6), (108.395894, 108.601001, 6)]),
    ],
)
def test_windows_near_k_100_begin_with_the_right_level_and_lack_the_right_ones(
    tmp_path, name, levels, first, gaps
):
    text = (Path(__file__).parent / f"quarter_stadium_{name}.txt").read_text()
    k = np.array(" ".join(line for line in text.splitlines() if line[0] != "#").split(), float)
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.0)
    catalogue.fill("2-10")
    window = catalogue.assess(k, parity="oo", window=True)
    assert (len(k), window.first, window.spurious) == (levels, first, 0)
    assert window.first_probability > 0.95
    assert window.missing == pytest.approx(sum(count for *_, count in gaps), abs=0.3)
    assert len(window.gaps) == len(gaps)
    for gap, (after, before, missing) in zip(window.gaps, gaps, strict=True):
        assert gap.after is not None
        assert gap.before is not None
        assert gap.after <= after < before <= gap.before
        assert gap.levels <= 2
        assert (gap.missing, gap.spurious) == (missing, 0)
        assert gap.probability > 0.7
    assert [n for n in np.diff(window.number) if n > 1] == [count + 1 for *_, count in gaps]
