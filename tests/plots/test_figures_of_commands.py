"""What `orbitdb plot` draws: the numbers on the axes of each figure are those of the library."""

import math
import shutil
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import alter
from made_levels import keep_made_levels
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from solutions import entropy, lyapunov

from orbitdb import Catalogue, Selection, Stadium, solve_word
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.billiard.stability import birkhoff
from orbitdb.catalogue.spectrum import read_classes
from orbitdb.catalogue.whole_periods import read_whole, sum_rules_of
from orbitdb.cli.figures import orbits, over_a, subsets
from orbitdb.entropy.bounds import search
from orbitdb.entropy.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.filling.births import fill_births
from orbitdb.orbits.least_values import least_length
from orbitdb.orbits.orbit import Status
from orbitdb.plots.style import BLUE, ORANGE
from orbitdb.quantum.amplitudes import orbit_terms, weyl
from orbitdb.quantum.lengths import counted, family_count
from orbitdb.store.reading.lookup import with_existence
from orbitdb.store.writing.records import add_reference, keep_bounds
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.words import from_strings
from orbitdb.trajectories.ensemble import Reference

TRAJECTORY = Reference(0.8871, 0.0002, 0.3754, 0.0003, 2.3634, 0.0004, 12_345, 67, 89)
WHOLE = Selection(1.6, periods=((2, 5),))


@pytest.fixture(scope="module")
def known(varied, tmp_path_factory) -> Catalogue:
    """The varied catalogue with births, a trajectory, and bounds at two a."""
    path = Path(shutil.copy(varied, tmp_path_factory.mktemp("drawn") / "orbits.db"))
    for _ in fill_births(path, range(2, 6)):
        pass
    writer = Writer(path, {})
    add_reference(writer, 1.6, TRAJECTORY)
    for a in (1.6, 3.0):
        for level in search(Stadium(a), 3):
            keep_bounds(writer, level, "doubles", None)
    writer.close()
    return Catalogue(path, 1.6)


def draw(kind: str, catalogue: Any, chosen: Any, limit: int) -> Figure:
    """Draw a figure of a subset; the limit is of orbits on a sheet."""
    more = {"limit": limit} if kind == "sheet" else {}
    return getattr(subsets, f"draw_{kind.replace('-', '_')}")(catalogue, chosen, **more)


def line(ax, label: str):
    """Return the places of the line whose label begins so, and its heights."""
    (found,) = (each for each in ax.get_lines() if str(each.get_label()).startswith(label))
    return np.asarray(found.get_xdata()).tolist(), np.asarray(found.get_ydata())


def paths_of(ax, count: int) -> list:
    """Return the closed paths of so many bounces, and their colours."""
    return [
        (each.get_xydata()[:-1], each.get_color())
        for each in ax.get_lines()
        if len(each.get_xydata()) == count + 1 and np.array_equal(*each.get_xydata()[[0, -1]])
    ]


def entropy_at(known: Catalogue, a: float) -> float:
    """Return the entropy from the births to period 5, none of which is followed by a death."""
    born = [sum(life.class_size for life in known.births(p) if life.born <= a) for p in range(2, 6)]
    return entropy_of_counts(np.array([0, 0, *born])).h_zeta[-1]


def arrows(ax) -> list:
    """Return the directions in which the path is drawn."""
    tips = [each for each in ax.texts if isinstance(each, Annotation) and each.arrow_patch is not None]
    return [np.subtract(each.xy, each.xyann) for each in tips]


@pytest.mark.parametrize(("word", "same"), [("010232", True), ("1232131", False)])
def test_the_reverse_is_the_orbit_backwards(word, same):
    orbit = solve_word(word, 1.6)
    made = orbits.draw_reverse(orbit)
    above, below = made.axes
    ((there, colour),) = paths_of(above, orbit.p)
    ((back, other),) = paths_of(below, orbit.p)
    assert np.array_equal(there, orbit.points)
    assert np.array_equal(back, orbit.points[::-1])
    assert (colour, other) == (BLUE, BLUE if same else ORANGE)
    ahead = np.diff(orbit.points, axis=0)[0]
    assert np.dot(arrows(above)[0], ahead) > 0 > np.dot(arrows(below)[-2], ahead)
    caption = f"{word},  $a = 1.6$,  $L = {orbit.length:.4f}\\,R$,  $\\lambda = {orbit.lyapunov:.4f}$"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted, too"
    assert above.get_title() == f"(a) {caption}"
    reverse = below.get_title().removeprefix("(b) its time reverse ").removesuffix(f": {kind}")
    np.testing.assert_allclose(solve_word(reverse, 1.6).points, back, atol=1e-12)
    alone = orbits.draw_orbit(orbit)
    assert alone.axes[0].get_title() == caption
    assert np.array_equal(paths_of(alone.axes[0], orbit.p)[0][0], orbit.points)
    assert made.get_size_inches().tolist() == [6.4, 2 * alone.get_size_inches()[1]]


def test_a_long_word_is_short_in_a_title():
    assert orbits.short("1" * 29 + "3") == "1" * 29 + "3"
    assert orbits.short("1" * 30 + "3") == "1^30 3"
    assert orbits.short("0102031323" * 4 + "3") == "0102031323" * 3 + "0102031..."


@pytest.mark.usefixtures("few_places")
def test_the_title_of_a_life_is_as_short():
    orbit = solve_word("1^20 (02)^5 3", 200)
    title = orbits.draw_life(with_existence(orbit)).axes[0].get_title()
    assert title == "1^20 (02)^5 3 is born at $a = 129.651$"


LONG = "time_reversal = 'self' and class_size > 0 and margin > 1e-9 and lambda_c < 99"


@pytest.mark.parametrize(
    ("kind", "where"),
    [
        ("sheet", LONG),
        ("sheet", None),
        ("lyapunov", LONG),
    ],
)
@pytest.mark.slow
def test_titles_stay_in_their_figure(known, kind, where):
    chosen = Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,), where=where)
    made = draw(kind, known, chosen, 9)
    (title,) = (text for text in made.texts if text.get_text() == made.get_suptitle())
    FigureCanvasAgg(made).draw()
    drawn, whole = title.get_window_extent(), made.bbox
    assert whole.x0 < drawn.x0 < drawn.x1 < whole.x1
    assert drawn.y1 < whole.y1
    assert all(drawn.y0 > ax.get_window_extent().y1 for ax in made.axes)
    assert made.get_suptitle().endswith("...") == (where is not None and len(where) > 100)


def test_the_entropy_of_whole_periods_with_proved_bounds(known, capsys):
    made = draw("entropy", known, WHOLE, 0)
    (ax,) = made.axes
    found = entropy(known.classes(a=1.6, p="2-5").rows(), 5)
    p, k_0 = line(ax, "$K_0")
    assert p == [2, 3, 4, 5]
    assert k_0 == pytest.approx(found.K_0)
    assert ax.containers == []  # no bars: a change from one period to the next bounds nothing
    shown = dict(zip(*line(ax, "$h(p)$"), strict=True))
    expected = dict(zip(found.p.tolist(), found.h_zeta.tolist(), strict=True))
    assert {4, 5} <= set(shown) == set(expected) & set(shown)
    assert shown == {p: pytest.approx(expected[p]) for p in shown}
    (band,) = ax.patches
    proved = known.entropy_bounds(1.6)
    assert (band.get_y(), band.get_height()) == pytest.approx((proved.lower, proved.upper - proved.lower))
    assert made.get_suptitle() == "words of period 2 to 5 at a = 1.6"
    assert "$h(p)$" in [text.get_text()[:6] for text in made.legends[0].get_texts()]
    assert capsys.readouterr().err == "h_zeta lies outside the proved bounds at periods 2-3\n"
    gaps = draw("entropy", known, Selection(1.6, periods=((3, 5),)), 0)
    p, k_0 = line(gaps.axes[0], "$K_0")
    assert (p, np.isnan(k_0).tolist()) == ([3, 4, 5], [False, True, False])
    assert "the zeta function lacks p = 2 (not chosen)" in capsys.readouterr().err


def test_the_exponents_by_every_method(known, capsys):
    made = draw("lyapunov", known, Selection(1.6, periods=((2, 6),)), 0)
    subset = known.classes(a=1.6, p="2-6")
    found = lyapunov(subset.rows(), 6)
    rules = sum_rules_of(read_whole(known, Selection(1.6, periods=((2, 6),))))
    assert len(made.axes) == 2
    for ax, name, unit in zip(made.axes, ("lambda_d", "lambda_c"), ("bounce", "length $R$"), strict=True):
        for label, column in (("average", ""), ("mean of", "_pair"), ("zeta", "_zeta")):
            p, values = line(ax, label)
            assert p == [2, 3, 4, 5, 6]
            np.testing.assert_allclose(values, getattr(found, f"{name}{column}"))
        np.testing.assert_array_equal(line(ax, "sum rules")[1], getattr(rules, f"{name}_sum_rule"))
        edges = ax.collections[0].get_paths()[0].vertices[:, 1]
        error = getattr(rules, f"{name}_sum_rule_error")
        assert edges.max() - edges.min() == pytest.approx(2 * error.max(), rel=0.1)
        assert line(ax, "random")[1].tolist() == [getattr(TRAJECTORY, name)] * 2
        (band,) = ax.patches
        assert band.get_height() == pytest.approx(4 * getattr(TRAJECTORY, f"{name}_error"))
        assert ax.get_ylabel() == rf"$\langle \{name} \rangle$ (per {unit})"
    assert made.get_suptitle() == "words of period 2 to 6 at a = 1.6"
    assert made.axes[0].get_xlabel() == ""
    assert capsys.readouterr().err == ""
    bare = draw("lyapunov", known, Selection(1.0, periods=((3, 4),)), 0)
    assert [str(each.get_label())[:4] for each in bare.axes[1].get_lines()] == ["aver", "mean", "zeta"]
    told = capsys.readouterr().err
    assert "the zeta function lacks p = 2 (not chosen)" in told
    assert "'orbitdb simulate --a 1'" in told
    assert "sum rules need all orbits up to a period; p = 2 is missing" in told


@pytest.mark.parametrize(("limit", "told"), [(8, ""), (3, "3 of 8 classes are drawn; --limit 8 draws all\n")])
def test_a_sheet_has_every_class(known, capsys, limit, told):
    chosen = Selection(1.6, periods=((4, 4),), statuses=(Status.ORBIT,))
    made = draw("sheet", known, chosen, limit)
    (ax,) = made.axes
    classes = sorted({solve_word(word, 1.6).representative for word in known.select(chosen).codes.tolist()})
    orbits = [solve_word(word, 1.6) for word in classes[:limit]]
    labels = [text.get_text() for text in ax.texts]
    assert labels == [f"{orbit.code} ({orbit.class_size})" for orbit in orbits]
    walls, drawn = (each.get_segments() for each in ax.collections)
    assert len(walls) == len(drawn) == len(orbits)
    for wall, path, orbit in zip(walls, drawn, orbits, strict=True):
        middle = (wall.min(axis=0) + wall.max(axis=0)) / 2
        np.testing.assert_allclose(path[:-1] - middle, orbit.points, atol=1e-12)
    title = "Classes of orbits of period 4 at a = 1.6: least word (class size)"
    assert made.get_suptitle().replace("\n", " ") == title
    assert capsys.readouterr().err == told
    across, down = ({round(wall.mean(axis=0)[k], 6) for wall in walls} for k in (0, 1))
    assert (len(across), len(down)) == ((2, 4) if limit == 8 else (2, 2))
    assert made.get_size_inches().tolist() == pytest.approx(
        [max(4, 2 * 5.8 * 0.26), len(down) * 3.1 * 0.26 + 0.6 + 0.17 * made.get_suptitle().count("\n")]
    )


def test_the_bounces_in_phase_space(known):
    chosen = Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,))
    made = draw("phase-space", known, chosen, 0)
    ax, bar = made.axes
    subset = known.select(chosen, coordinates=True)
    orbits = [solve_word(word, 1.6) for word in subset.codes.tolist()]
    places = [birkhoff(Stadium(1.6), from_strings([o.code]), o.coordinates[None]) for o in orbits]
    expected = np.concatenate([np.column_stack([each.ravel() for each in place]) for place in places])
    (dots,) = ax.collections
    np.testing.assert_allclose(dots.get_offsets(), expected, atol=1e-9)
    colours = [orbit.lambda_d for orbit in orbits for _ in orbit.code]
    np.testing.assert_allclose(dots.get_array(), colours)
    assert made.get_suptitle() == "orbits of period 2 to 4 at a = 1.6"
    assert bar.get_ylabel() == r"$\lambda_d$ (per bounce)"


def test_the_lengths(known):
    made = draw("lengths", known, Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,)), 0)
    above, below, bar = made.axes
    steps, end = above.get_lines()
    lengths = sorted(solve_word(w, 1.6).length for w in known.select(a=1.6, p="2-4", status="orbit").codes)
    assert steps.get_ydata()[-1] == len(lengths) == 41
    assert (steps.get_xdata()[0], steps.get_xdata()[-1]) == pytest.approx((lengths[0], lengths[-1]))
    complete = end.get_xdata()[0]
    assert complete == pytest.approx(least_length(4, 1.6), abs=0.01)
    assert complete < solve_word("11113", 1.6).length
    (said,) = (text.get_text() for text in made.legends[0].get_texts())
    assert f"complete, by proof, up to $L = {complete:.2f}" in said
    assert (bar.get_ylabel(), below.get_ylabel()) == ("orbits per unit of $L/R$", "period $p$ (bounces)")
    assert (above.get_xlabel(), made.get_suptitle()) == ("", "orbits of period 2 to 4 at a = 1.6")
    gap = draw("lengths", known, Selection(1.6, periods=((3, 4),), statuses=(Status.ORBIT,)), 0)
    assert (len(gap.axes[0].get_lines()), gap.legends) == (1, [])


@pytest.fixture
def few_places(monkeypatch) -> None:
    """Draw curves over a through few points; every one is as dear as an orbit."""
    monkeypatch.setattr(orbits, "PLACES", 12)
    monkeypatch.setattr(over_a, "PLACES", 12)
    monkeypatch.setattr(over_a, "PLACES_OF_BOUNDS", 12)


@pytest.mark.usefixtures("few_places")
def test_births_over_a(known):
    made = over_a.draw_births(known, Selection(1.6))
    shares, entropies, changes = made.axes
    lives = known.births(5)
    born = np.array([life.born for life in lives])
    sizes = np.array([life.class_size for life in lives])
    a, drawn = line(shares, "$p = 5$")
    expected = [sizes[born <= at].sum() / sizes.sum() for at in a]
    assert drawn == pytest.approx(expected)
    assert (a[0], a[-1]) == pytest.approx((0.02, 1.5 * born.max()))
    at = next(k for k, each in enumerate(a) if each > 1)
    _, h = line(entropies, "$h(5; a)$")
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
    ends = [end for life in orbit.exists for end in life if end]
    made = orbits.draw_life(orbit)
    path, length, exponent = made.axes
    start = ends[0] if ends else 1.6
    title = f"{word} {'is born' if ends else 'exists'} at $a = {start:.6g}$"
    assert path.get_title() == title
    ((points, _),) = paths_of(path, len(word))
    np.testing.assert_allclose(points, solve_word(word, start * (1 + 1e-9)).points, atol=1e-6)
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
        lives = [any(low < at < (high or math.inf) for low, high in orbit.exists) for at in a.tolist()]
        assert (~np.isnan(values)).tolist() == lives
        k = lives.index(True)
        assert values[k] == pytest.approx(getattr(solve_word(word, float(a[k])), name))
        assert all(np.abs(a / end - 1).min() < 1e-8 for end in ends)
    assert exponent.get_xlabel() == "$a$"


@pytest.mark.usefixtures("few_places")
def test_the_entropy_over_a(known):
    (ax,) = over_a.draw_over_a(known, Selection(1.6)).axes
    curve = known.entropy_curve()
    ((_, _, (bars,)),) = ax.containers
    drawn = [(x, *sorted((low, high))) for (x, low), (_, high) in bars.get_segments()]
    assert drawn == [pytest.approx((each.a, each.lower, each.upper)) for each in curve]
    a, h = line(ax, "$h(5; a)$")
    assert (a[0], a[-1]) == pytest.approx((1.6 / 1.1, 3.0 * 1.1))
    here = known.entropy_curve()[0].a
    k = int(np.argmin(np.abs(np.log(np.array(a) / here))))
    assert h[k] == pytest.approx(entropy_at(known, a[k]))
    assert line(ax, "bound at every")[1] == pytest.approx([geometric_entropy()] * 2)


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize("lost", [2, 3, 4, 5])
def test_the_entropy_over_a_is_that_up_to_the_first_period_without_births(known, tmp_path, lost):
    path = Path(shutil.copy(known.path, tmp_path / "orbits.db"))
    alter(path, f"DELETE FROM birth_fill WHERE p = {lost}")
    (ax,) = over_a.draw_over_a(Catalogue(path), Selection(1.6)).axes
    drawn = [str(each.get_label()) for each in ax.get_lines()]
    assert [each for each in drawn if each[1] == "h"] == [f"$h({lost - 1}; a)$, from births"] * (lost > 2)


@pytest.mark.parametrize("kind", ["lengths", "phase-space", "sheet"])
def test_a_period_that_is_not_there_is_told(known, capsys, kind):
    draw(kind, known, Selection(1.6, periods=((2, 2), (7, 7)), statuses=(Status.ORBIT,)), 9)
    assert capsys.readouterr().err.startswith(
        "period 7 is not filled at a = 1.6 (filled: periods 2-6; some at"
    )


def test_the_figures_of_levels(known, tmp_path, capsys):
    path = Path(shutil.copy(known.path, tmp_path / "levels.db"))
    catalogue, chosen, stadium = Catalogue(path, 1.6), Selection(1.6), Stadium(1.6)
    with pytest.raises(InputError, match=r"no levels to draw: .* --k 0:30 --a 1\.6' finds"):
        subsets.draw_levels(catalogue, chosen)
    k = sorted(chain(*keep_made_levels(path).values()))
    made = subsets.draw_levels(catalogue, chosen)
    above, below = made.axes
    assert line(above, "levels")[0] == [0, *k]
    at, rest = line(below, "levels, less")
    assert (at[0], at[-1]) == (0.5, 9)
    np.testing.assert_allclose(rest, np.searchsorted(k, at) - weyl(stadium, None)(at))
    np.testing.assert_allclose(line(above, "Weyl")[1], weyl(stadium, None)(at))
    classes, _, highest = read_classes(catalogue, chosen)
    balls = family_count(stadium, np.array(at), 12.0)
    np.testing.assert_allclose(below.get_lines()[1].get_ydata(), balls)
    orbits_too = balls + counted(orbit_terms(classes, 12.0), np.array(at))
    np.testing.assert_allclose(line(below, "bouncing balls and orbits")[1], orbits_too)
    assert f"to $p = {highest}$" in made.legends[0].get_texts()[-1].get_text()
    assert made.get_suptitle() == f"{len(k)} levels at a = 1.6, k below 9"
    assert "lengths up to 12: a partial sum" in capsys.readouterr().err
    spectrum = subsets.draw_length_spectrum(catalogue, chosen)
    found = catalogue.spectrum((1.0, 12.0), points=1000)
    for label, values in (("levels", np.abs(found.quantum)), ("orbits", -np.abs(found.orbits))):
        lengths, drawn = line(spectrum.axes[0], label)
        np.testing.assert_allclose(lengths, np.linspace(1, 12, 1000))
        np.testing.assert_allclose(drawn, values)
    assert {text.get_text() for text in spectrum.axes[0].texts} == {peak.code for peak in found.peaks(1)}
    assert spectrum.get_suptitle() == "length spectrum at a = 1.6, k below 9"
    assert capsys.readouterr().err.splitlines() == found.notes()
