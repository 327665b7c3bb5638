"""Figures over a: births, lives, and the entropy, drawn and as commands draw them."""

import math
import shutil
from bisect import bisect_right
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import alter
from figures import heights, legend, named, paths_of, says
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from there import there

from orbitdb import Catalogue, Selection, solve_word
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.cli.figures import orbits, over_a
from orbitdb.entropy.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.plots import births, style
from orbitdb.plots.style import BLUE, ORANGE
from orbitdb.store.reading.lookup import with_existence

A = np.geomspace(0.02, 9.0, 50)


def spans_a(ax, label: str) -> None:
    assert (ax.get_xscale(), ax.get_xlim(), ax.get_ylabel()) == ("log", (A[0], A[-1]), label)


def test_births_and_deaths(rng):
    shares, entropies, changes = Figure().subplots(3)
    periods, places, shown = {}, {}, []
    for p in range(5, 11):
        born, died = np.sort(rng.choice(A, 9)), np.sort(rng.choice(A[25:], 4))
        words, gone = 8 * rng.integers(5, 9, 9), rng.integers(1, 9, 4)
        periods[p], places[p] = births.Steps.of(born, died, words, gone), np.concatenate([born, died])
        some = np.array([words[born <= at].sum() - gone[died <= at].sum() for at in A])
        np.testing.assert_array_equal(periods[p].at(A), some)  # those at a, too
        assert periods[p].words == words.sum() - gone.sum()
        assert (np.diff(periods[p].a) >= 0).all()
        shown.append(some / periods[p].words)
    births.draw_shares(shares, periods, A)
    spans_a(shares, r"$N_c(p; a)\,/\,N_t(p)$")
    assert legend(shares) == [f"$p = {p}$" for p in periods]
    assert len({each.get_linestyle() for each in shares.lines[:4]}) == 4
    for p, share in zip(periods, shown, strict=True):
        np.testing.assert_allclose(named(shares, f"$p = {p}$"), [A, share])
    assert shares.get_ylim() == (0, 1.03)
    births.draw_entropies(entropies, dict(zip(periods, shown, strict=True)), A, 1.2)
    spans_a(entropies, "topological entropy")
    assert legend(entropies) == [*(f"$h({p}; a)$" for p in periods), "bound at every $a$"]
    np.testing.assert_array_equal([each.get_ydata() for each in entropies.lines[:-1]], shown)
    assert entropies.lines[-1].get_ydata() == [1.2, 1.2]
    births.draw_changes(changes, {4: np.zeros(0), **places}, A)
    spans_a(changes, "share of births and deaths")
    assert [each.get_label() for each in changes.patches] == [f"$p = {p}$" for p in (4, *periods)][:6]
    for each, at in zip(changes.patches, [np.zeros(0), *places.values()], strict=False):
        share, edges, _ = each.get_data()
        np.testing.assert_allclose(np.diff(np.log(edges)), math.log(9 / 0.02) / 60)
        bins = Counter(min(bisect_right(edges, place) - 1, 59) for place in at)  # an edge: the bin behind
        assert share.tolist() == [bins[k] / max(len(at), 1) for k in range(60)]


def test_a_number_of_one_orbit_over_a(ax, rng):
    values = np.where(A > 1, rng.uniform(size=50), np.nan)
    births.draw_followed(ax, A, values, "length", [1.0, 3.0], style.GREEN)
    spans_a(ax, "length")
    np.testing.assert_array_equal(ax.lines[0].get_data(), [A, values])
    assert to_hex(ax.lines[0].get_color()) == style.GREEN
    assert [each.get_xdata() for each in ax.lines[1:]] == [[1, 1], [3, 3]]
    assert legend(ax) == ["birth or death"]


def test_bounds_over_a(ax, rng):
    lower, upper = np.sort(rng.uniform(0.2, 1.1, (2, 50)), axis=0)
    drawn = {p: rng.uniform(0.5, 1, (2, 9)) for p in (5, 6)}
    births.draw_entropy_over_a(ax, A, lower, upper, drawn, 1.2)
    assert heights(ax.collections[0]) == {*lower.round(9).tolist(), *upper.round(9).tolist()}
    ((_, caps, (bars,)),) = ax.containers
    np.testing.assert_allclose([each[:, 1] for each in bars.get_segments()], np.stack([lower, upper], axis=1))
    np.testing.assert_array_equal([each[:, 0] for each in bars.get_segments()], np.stack([A, A], axis=1))
    assert len(caps) == 2
    by = [f"$h({p}; a)$, from births" for p in drawn]
    assert sorted(legend(ax)) == [*by, "bound at every $a$", "proved bounds"]
    assert all(np.array_equal(named(ax, f"$h({p}; a)$"), values) for p, values in drawn.items())
    assert named(ax, "bound at")[1].tolist() == [1.2, 1.2]
    assert ax.get_ylim() == pytest.approx((lower.min() - 0.02, 1.22))
    assert ax.get_xscale() == "log"
    says(ax, "$a$", "topological entropy (per bounce)")


def entropy_at(known: Catalogue, a: float) -> float:
    """Return the entropy from the births to period 5, none of which is followed by a death."""
    born = [sum(life.class_size for life in known.births(p) if life.born <= a) for p in range(2, 6)]
    return entropy_of_counts(np.array([0, 0, *born])).h_zeta[-1]


@pytest.mark.usefixtures("few_places")
def test_births_over_a(known):
    made: Any = over_a.draw_births(known, Selection(1.6))
    shares, entropies, changes = made.axes
    lives = known.births(5)
    born = np.array([life.born for life in lives])
    sizes = np.array([life.class_size for life in lives])
    a, drawn = named(shares, "$p = 5$")
    expected = [sizes[born <= at].sum() / sizes.sum() for at in a]
    assert drawn == pytest.approx(expected)
    assert (a[0], a[-1]) == pytest.approx((0.02, 1.5 * born.max()))
    at = next(k for k, each in enumerate(a) if each > 1)
    _, h = named(entropies, "$h(5; a)$")
    assert h[at] == pytest.approx(entropy_at(known, a[at]))
    assert entropies.get_lines()[-1].get_ydata() == pytest.approx([geometric_entropy()] * 2, abs=1e-6)
    assert [text.get_text() for text in changes.get_legend().get_texts()] == ["$p = 5$"]
    assert changes.patches[-1].get_data().values.sum() == pytest.approx(1)
    assert changes.get_xlabel() == "$a$"


def test_periods_without_a_birth_have_nothing_to_draw(known):
    """Words of fewer than five bounces are orbits at every a, or at none."""
    with pytest.raises(InputError, match="no births to draw: 'orbitdb births --p 11' finds them"):
        over_a.draw_births(known, Selection(1.6, periods=((2, 4),)))


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("word", ["01552", "13", pytest.param("010203113", marks=pytest.mark.slow)])
def test_a_life_over_a(word):
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
    assert exponent.get_xlabel() == "$a$"


@pytest.mark.usefixtures("few_places")
def test_the_title_of_a_life_is_as_short():
    orbit = solve_word("1^20 (02)^5 3", 200)
    title = orbits.draw_life(with_existence(orbit)).axes[0].get_title()
    assert title == "1^20 (02)^5 3 is born at $a = 129.651$"


@pytest.mark.usefixtures("few_places")
def test_the_entropy_over_a(known):
    made: Any = over_a.draw_over_a(known, Selection(1.6))
    (ax,) = made.axes
    curve = known.entropy_curve()
    ((_, _, (bars,)),) = ax.containers
    drawn = [(x, *sorted((low, high))) for (x, low), (_, high) in bars.get_segments()]
    assert drawn == [pytest.approx((each.a, each.lower, each.upper)) for each in curve]
    a, h = named(ax, "$h(5; a)$")
    assert (a[0], a[-1]) == pytest.approx((1.6 / 1.1, 3.0 * 1.1))
    here = known.entropy_curve()[0].a
    k = int(np.argmin(np.abs(np.log(a / here))))
    assert h[k] == pytest.approx(entropy_at(known, a[k]))
    assert named(ax, "bound at every")[1] == pytest.approx([geometric_entropy()] * 2)


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("lost", [2, 3, 4, 5])
def test_the_entropy_over_a_is_that_up_to_the_first_period_without_births(known, tmp_path, lost):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(path, f"DELETE FROM birth_fill WHERE p = {lost}")
    made: Any = over_a.draw_over_a(Catalogue(path), Selection(1.6))
    drawn = [str(each.get_label()) for each in made.axes[0].get_lines()]
    assert [each for each in drawn if each[1] == "h"] == [f"$h({lost - 1}; a)$, from births"] * (lost > 2)
