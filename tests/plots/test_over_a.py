"""Figures over a: births, lives and entropy, as commands draw them."""

import math
import re
import shutil
from bisect import bisect_right
from collections import Counter
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import alter
from figures import heights, legend, named, paths_of, says
from matplotlib.colors import to_hex
from matplotlib.markers import CARETDOWN
from there import there

from orbitdb import Catalogue, Selection, solve_word
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.entropy_bounds.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.orbits.solve import with_existence
from orbitdb.plots import over_a
from orbitdb.plots.style import BLUE, ORANGE


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
    made: Any = over_a.births(mortal, Selection(1.6))
    shares, entropies, changes = made.axes
    ends = {p: [e for life in mortal.births(p) for e in (life.born, life.dies) if e] for p in (5, 6)}
    assert all(any(life.dies for life in mortal.births(p)) for p in (5, 6))
    for k, p in enumerate((5, 6)):
        a, drawn = named(shares, f"$p = {p}$")
        in_the_end = orbits_at(mortal, p, 1e9)
        assert drawn == pytest.approx([orbits_at(mortal, p, at) / in_the_end for at in a])
        assert (a[0], a[-1]) == pytest.approx((0.02, 1.5 * max(chain(*ends.values()))))
        _, h = np.array(entropies.lines[k].get_data())
        at = next(k for k, each in enumerate(a) if each > 1)
        assert h[at] == pytest.approx(entropy_at(mortal, p, a[at]))
        share, edges, _ = changes.patches[k].get_data()
        np.testing.assert_allclose(np.diff(np.log(edges)), math.log(a[-1] / a[0]) / 60)
        bins = Counter(bisect_right(edges, place) - 1 for place in ends[p])
        assert share == pytest.approx([bins[k] / len(ends[p]) for k in range(60)])
    assert entropies.get_lines()[-1].get_ydata() == pytest.approx([geometric_entropy()] * 2, abs=1e-6)
    periods = ["$p = 5$", "$p = 6$"]
    assert legend(shares) == periods
    assert [text.get_text() for text in made.legends[0].get_texts()] == [*periods, "upper bound at every $a$"]
    colours = [to_hex(each.get_color()) for each in shares.lines]
    assert colours == [to_hex(each.get_color()) for each in entropies.lines[:2]]
    assert colours == [to_hex(each.get_edgecolor()) for each in changes.patches]
    labels = r"$N_c(p; a)\,/\,N_t(p)$", "entropy $h(p; a)$", "share of births\nand deaths"
    for ax, label in zip(made.axes, labels, strict=True):
        assert (ax.get_xscale(), ax.get_xlim(), ax.get_ylabel()) == ("log", (a[0], a[-1]), label)
    assert (shares.get_ylim(), changes.get_xlabel()) == ((0, 1.03), "half length $a/R$")
    assert shares.get_xlabel() == ""


def test_periods_without_births_are_refused(known):
    """Words of fewer than five bounces are orbits at every a or at no a."""
    with pytest.raises(InputError, match=r"no births to draw: `catalogue\.fill_births\(p=11\)` finds them"):
        over_a.births(known, Selection(1.6, periods=((2, 4),)))


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("word", ["01552", "13", pytest.param("010203113", marks=pytest.mark.slow)])
def test_the_figure_of_a_life_follows_an_orbit_over_a(word):
    orbit = with_existence(solve_word(word, 1.6))
    exists = there(orbit.exists)
    ends = [end for life in exists for end in life if end]
    made: Any = over_a.life(orbit)
    path, length, exponent = made.axes
    start = ends[0] if ends else 1.6
    title = f"{word} {'is born' if ends else 'exists'} at $a = {start:.6g}$"
    assert path.get_title() == title
    ((points, _),) = paths_of(path, len(word))
    np.testing.assert_allclose(points, there(solve_word(word, start * (1 + 1e-9)).points), atol=1e-6)
    for ax, name, colour, label in (
        (length, "length", BLUE, "length $L/R$"),
        (exponent, "lyapunov", ORANGE, r"$\lambda$"),
    ):
        curve, *marks = ax.get_lines()
        assert ([mark.get_xdata()[0] for mark in marks], ax.get_ylabel()) == (ends, label)
        assert to_hex(curve.get_color()) == colour
        a, values = curve.get_data()
        assert (np.diff(a) > 0).all()
        assert a[0] == pytest.approx(exists[0][0] / 1.25 or min([0.1, *(end / 2 for end in ends)]))
        assert a[-1] == pytest.approx(max([5, *(4 * end for end in ends)]))
        lives = [any(low < at < (high or math.inf) for low, high in exists) for at in a.tolist()]
        assert (~np.isnan(values)).tolist() == lives
        k = lives.index(True)
        assert values[k] == pytest.approx(getattr(solve_word(word, float(a[k])), name))
        assert all(np.abs(a / end - 1).min() < 1e-8 for end in ends)
        assert (ax.get_xscale(), ax.get_xlim()) == ("log", (a[0], a[-1]))
    assert exponent.get_xlabel() == "half length $a/R$"
    told = [
        f"{said} {end:.4g}"
        for life in exists
        for end, said in zip(life, ("born", "dies"), strict=True)
        if end
    ]
    assert [text.get_text() for text in length.texts] == told


@pytest.mark.usefixtures("few_places")
def test_the_title_of_a_life_abbreviates_a_long_word():
    orbit = solve_word("1^20(02)^5 3", 200)
    title = over_a.life(with_existence(orbit)).axes[0].get_title()
    assert title == "1^20(02)^5 3 is born at $a = 129.651$"


@pytest.mark.usefixtures("few_places")
def test_the_figure_of_entropy_over_a_shows_bounds_and_births(known):
    made: Any = over_a.entropy_over_a(known, Selection(1.6))
    (ax,) = made.axes
    curve = known.entropy_curve()
    drawn = [
        (x, *sorted((low, high)))
        for _, _, (bars,) in ax.containers
        for (x, low), (_, high) in bars.get_segments()
    ]
    assert drawn == [pytest.approx((each.a, each.lower, each.upper)) for each in curve]
    named_bounds = [each for each in legend(ax) if each.startswith("proved")]
    for text, each in zip(named_bounds, curve, strict=True):
        a, lower, upper = map(float, re.findall(r"[\d.]+", text))
        assert (a, lower, upper) == pytest.approx((each.a, each.lower, each.upper), abs=1e-5)
        assert lower <= each.lower < each.upper <= upper  # still a bound
    told = ["$h(6; a)$, estimated from births", "upper bound at every $a$", *named_bounds]
    assert (
        sorted(legend(ax)) == sorted(text.get_text() for text in made.legends[0].get_texts()) == sorted(told)
    )
    assert ax.get_xscale() == "log"
    says(ax, "half length $a/R$", "topological entropy\n(per bounce)")
    a, h = named(ax, "$h(6; a)$")
    assert (a[0], a[-1]) == pytest.approx(ax.get_xlim())
    assert a[0] < 1.6 < 3.0 < a[-1]
    here = known.entropy_curve()[0].a
    k = int(np.argmin(np.abs(np.log(a / here))))
    assert h[k] == pytest.approx(entropy_at(known, 6, a[k]))
    assert named(ax, "upper bound")[1] == pytest.approx([geometric_entropy()] * 2)
    useful = [each.lower for each in curve if each.lower > 0]
    low = min([geometric_entropy() - 0.1, *useful, *h[np.isfinite(h)]]) - 0.02
    assert ax.get_ylim() == pytest.approx((low, geometric_entropy() + 0.02))


@pytest.mark.usefixtures("few_places")
def test_a_trivial_bound_does_not_stretch_the_axis_of_the_entropy(known, monkeypatch):
    curve = known.entropy_curve()
    trivial = replace(curve[0], a=0.5, lower=0.0, upper=0.1)
    monkeypatch.setattr(Catalogue, "entropy_curve", lambda _: [trivial, *curve])
    made: Any = over_a.entropy_over_a(known, Selection(1.6))
    (ax,) = made.axes
    low, _ = ax.get_ylim()
    assert low > 0.5
    carets = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == CARETDOWN]
    assert carets == [[[0.5, low]]]
    assert "at a = 0.5, it lies outside the bounds, which are proved" in made.notes[0]


@pytest.mark.usefixtures("few_places")
def test_the_legend_of_births_names_the_periods_of_the_first_panel_alone(known, monkeypatch):
    changes = {p: (np.array([0.0, p / 4]), np.array([1, 1])) for p in (2, 3, 4, 5)}
    monkeypatch.setattr(over_a, "_changes", lambda *_: changes)
    shares, _, below = over_a.births(known, Selection(1.6)).axes
    assert legend(shares) == ["$p = 2$ (top only)", "$p = 3$ (top only)", "$p = 4$", "$p = 5$"]
    assert len(below.patches) == 2


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("lost", [2, 3, 4, 5])
def test_the_entropy_over_a_ends_before_the_first_period_without_births(known, tmp_path, lost):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(path, f"DELETE FROM birth_fill WHERE p = {lost}")
    made: Any = over_a.entropy_over_a(Catalogue(path), Selection(1.6))
    drawn = [str(each.get_label()) for each in made.axes[0].get_lines()]
    assert [each for each in drawn if each[1] == "h"] == [f"$h({lost - 1}; a)$, estimated from births"] * (
        lost > 2
    )


@pytest.mark.usefixtures("few_places")
def test_births_with_a_gap_give_no_entropy(known, tmp_path):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(path, "DELETE FROM birth_fill WHERE p = 4")
    shares, entropies, _ = over_a.births(Catalogue(path), Selection(1.6)).axes
    assert legend(shares) == ["$p = 5$", "$p = 6$"]
    assert legend(entropies) == ["upper bound at every $a$"]
    assert len(entropies.lines) == 1


@pytest.mark.usefixtures("few_places")
def test_many_bounds_are_joined_by_a_band(known, ax):
    curve = [
        replace(bounds, a=bounds.a * factor) for factor in (0.5, 1, 2) for bounds in known.entropy_curve()
    ]
    curve.sort(key=lambda bounds: bounds.a)
    over_a.draw_bounds(ax, curve)
    ((_, _, (bars,)),) = ax.containers
    drawn = [(x, *sorted((low, high))) for (x, low), (_, high) in bars.get_segments()]
    assert drawn == [pytest.approx((each.a, each.lower, each.upper)) for each in curve]
    band = next(each for each in ax.collections if each.get_label().startswith("interpolated"))
    assert heights(band) == {round(end, 9) for each in curve for end in (each.lower, each.upper)}


@pytest.mark.slow
@pytest.mark.parametrize(("low", "high"), [(0.1, 5), (0.02, 150), (1e-4, 1e4), (1.4, 3.3), (1.55, 1.65)])
def test_an_axis_over_a_has_a_few_plain_numbers(ax, low, high):
    over_a.over_a(ax, low, high)
    ax.figure.draw_without_rendering()
    labels = [text.get_text() for text in ax.get_xticklabels()]
    assert [float(text) for text in labels] == pytest.approx([*ax.get_xticks()])
    assert 2 <= len(labels) <= 9
    assert all(low <= tick <= high for tick in ax.get_xticks())
    assert not [text.get_text() for text in ax.get_xticklabels(minor=True) if text.get_text()]
    assert (ax.get_xlim(), ax.get_xlabel()) == ((low, high), "half length $a/R$")


def test_a_curve_of_the_entropy_says_why_it_has_ends_and_gaps(ax):
    """Each end inside the figure is marked once, even of a single point; the ends of the axis are not."""
    a = np.arange(1.0, 10.0)
    values = np.array([np.nan, 1, 2, np.nan, 3, np.nan, 4, 5, 6])
    over_a._mark_ends(ax, a, values, BLUE)
    assert named(ax, "no estimate beyond: no usable zero")[0].tolist() == [2, 3, 5, 7]
    over_a._mark_ends(ax, a, np.ones(9), BLUE)
    over_a._mark_ends(ax, a, np.full(9, np.nan), BLUE)
    assert len(ax.lines) == 1
