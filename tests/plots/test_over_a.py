"""Figures over a: births, lives and entropy, as commands draw them."""

import math
import shutil
from bisect import bisect_right
from collections import Counter
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import alter, answer
from figures import heights, legend, named, paths_of, says
from matplotlib.colors import to_hex
from there import there

from orbitdb import Catalogue, Selection, solve_word
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.cli.figures import averages, orbits
from orbitdb.entropy.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.plots.style import BLUE, ORANGE
from orbitdb.store.lookup import with_existence


def orbits_at(known: Catalogue, p: int, a: float) -> int:
    """Return the number of words of a period that are orbits at half length a."""
    lives = known.births(p)
    return sum(life.class_size for life in lives if (life.born or 0.0) <= a < (life.dies or math.inf))


def entropy_at(known: Catalogue, highest: int, a: float) -> float:
    """Return the entropy at half length a from the births of all periods up to the highest."""
    return entropy_of_counts(
        np.array([0, 0, *(orbits_at(known, p, a) for p in range(2, highest + 1))])
    ).h_zeta[-1]


@pytest.mark.usefixtures("few_places")
def test_the_figure_of_births_counts_births_and_deaths(known, tmp_path):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(
        path,
        "INSERT INTO change (cycle, number, a, error, kind, run)"
        " SELECT cycle, number + 1, 1.4 * a, error, 'died', run FROM change WHERE a > 0 AND cycle % 3 = 0",
    )
    mortal = Catalogue(path)
    made: Any = answer(path, averages.draw_births, Selection(1.6))
    shares, entropies, changes = made.axes
    ends = {p: [e for life in mortal.births(p) for e in (life.born, life.dies) if e] for p in (5, 6)}
    assert all(any(life.dies for life in mortal.births(p)) for p in (5, 6))
    for k, p in enumerate((5, 6)):
        a, drawn = named(shares, f"$p = {p}$")
        in_the_end = orbits_at(mortal, p, 1e9)
        assert drawn == pytest.approx([orbits_at(mortal, p, at) / in_the_end for at in a])
        assert (a[0], a[-1]) == pytest.approx((0.02, 1.5 * max(chain(*ends.values()))))
        _, h = named(entropies, f"$h({p}; a)$")
        at = next(k for k, each in enumerate(a) if each > 1)
        assert h[at] == pytest.approx(entropy_at(mortal, p, a[at]))
        share, edges, _ = changes.patches[k].get_data()
        np.testing.assert_allclose(np.diff(np.log(edges)), math.log(a[-1] / a[0]) / 60)
        bins = Counter(bisect_right(edges, place) - 1 for place in ends[p])
        assert share == pytest.approx([bins[k] / len(ends[p]) for k in range(60)])
    assert entropies.get_lines()[-1].get_ydata() == pytest.approx([geometric_entropy()] * 2, abs=1e-6)
    periods = ["$p = 5$", "$p = 6$"]
    assert legend(shares) == [each.get_label() for each in changes.patches] == periods
    assert legend(entropies) == ["$h(5; a)$", "$h(6; a)$", "bound at every $a$"]
    labels = r"$N_c(p; a)\,/\,N_t(p)$", "topological entropy", "share of births and deaths"
    for ax, label in zip(made.axes, labels, strict=True):
        assert (ax.get_xscale(), ax.get_xlim(), ax.get_ylabel()) == ("log", (a[0], a[-1]), label)
        assert [text.get_text() for text in ax.get_legend().get_texts()][:1] == [
            "$h(5; a)$" if ax is entropies else "$p = 5$"
        ]
    assert (shares.get_ylim(), changes.get_xlabel(), made.legends) == ((0, 1.03), "$a$", [])


def test_periods_without_births_are_refused(known):
    """Words of fewer than five bounces are orbits at every a or at no a."""
    with pytest.raises(InputError, match="no births to draw: 'orbitdb births --p 11' finds them"):
        answer(known.path, averages.draw_births, Selection(1.6, periods=((2, 4),)))


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("word", ["01552", "13", pytest.param("010203113", marks=pytest.mark.slow)])
def test_the_figure_of_a_life_follows_an_orbit_over_a(word):
    orbit = with_existence(solve_word(word, 1.6))
    exists = there(orbit.exists)
    ends = [end for life in exists for end in life if end]
    made: Any = orbits.draw_life(orbit)
    path, length, exponent = made.axes
    start = ends[0] if ends else 1.6
    title = f"{word} {'is born' if ends else 'exists'} at $a = {start:.6g}$"
    assert path.get_title() == title
    ((points, _),) = paths_of(path, len(word))
    np.testing.assert_allclose(points, there(solve_word(word, start * (1 + 1e-9)).points), atol=1e-6)
    for ax, name, colour, label in (
        (length, "length", BLUE, "length $L$"),
        (exponent, "lyapunov", ORANGE, r"$\lambda$"),
    ):
        curve, *marks = ax.get_lines()
        assert ([mark.get_xdata()[0] for mark in marks], ax.get_ylabel()) == (ends, label)
        assert to_hex(curve.get_color()) == colour
        a, values = curve.get_data()
        assert (np.diff(a) > 0).all()
        assert a[0] == pytest.approx(min([0.1, *(end / 2 for end in ends)]))
        assert a[-1] == pytest.approx(max([5, *(4 * end for end in ends)]))
        lives = [any(low < at < (high or math.inf) for low, high in exists) for at in a.tolist()]
        assert (~np.isnan(values)).tolist() == lives
        k = lives.index(True)
        assert values[k] == pytest.approx(getattr(solve_word(word, float(a[k])), name))
        assert all(np.abs(a / end - 1).min() < 1e-8 for end in ends)
        assert (ax.get_xscale(), ax.get_xlim()) == ("log", (a[0], a[-1]))
    assert exponent.get_xlabel() == "$a$"


@pytest.mark.usefixtures("few_places")
def test_the_title_of_a_life_abbreviates_a_long_word():
    orbit = solve_word("1^20 (02)^5 3", 200)
    title = orbits.draw_life(with_existence(orbit)).axes[0].get_title()
    assert title == "1^20 (02)^5 3 is born at $a = 129.651$"


@pytest.mark.usefixtures("few_places")
def test_the_figure_of_entropy_over_a_shows_bounds_and_births(known):
    made: Any = answer(known.path, averages.draw_over_a, Selection(1.6))
    (ax,) = made.axes
    curve = known.entropy_curve()
    ((_, _, (bars,)),) = ax.containers
    drawn = [(x, *sorted((low, high))) for (x, low), (_, high) in bars.get_segments()]
    assert drawn == [pytest.approx((each.a, each.lower, each.upper)) for each in curve]
    assert heights(ax.collections[0]) == {round(end, 9) for each in curve for end in (each.lower, each.upper)}
    told = [
        "$h(6; a)$, from births",
        "between the bounds (not proved)",
        "bound at every $a$",
        "proved bounds",
    ]
    assert sorted(legend(ax)) == sorted(text.get_text() for text in made.legends[0].get_texts()) == told
    lowest = min(min(each.lower for each in curve), geometric_entropy() - 0.1)
    assert ax.get_ylim() == pytest.approx((lowest - 0.02, geometric_entropy() + 0.02))
    assert ax.get_xscale() == "log"
    says(ax, "$a$", "topological entropy (per bounce)")
    a, h = named(ax, "$h(6; a)$")
    assert (a[0], a[-1]) == pytest.approx((1.6 / 1.1, 3.0 * 1.1))
    here = known.entropy_curve()[0].a
    k = int(np.argmin(np.abs(np.log(a / here))))
    assert h[k] == pytest.approx(entropy_at(known, 6, a[k]))
    assert named(ax, "bound at every")[1] == pytest.approx([geometric_entropy()] * 2)


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("lost", [2, 3, 4, 5])
def test_the_entropy_over_a_ends_before_the_first_period_without_births(known, tmp_path, lost):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(path, f"DELETE FROM birth_fill WHERE p = {lost}")
    made: Any = answer(path, averages.draw_over_a, Selection(1.6))
    drawn = [str(each.get_label()) for each in made.axes[0].get_lines()]
    assert [each for each in drawn if each[1] == "h"] == [f"$h({lost - 1}; a)$, from births"] * (lost > 2)
