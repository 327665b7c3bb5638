"""Figures of `orbitdb plot`: the numbers drawn are those that the library returns."""

import shutil
from bisect import bisect_right
from collections import Counter
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import answer
from figures import by_period, legend, named, says, texts
from made_levels import keep_made_levels
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from quick import slow_but
from solutions import entropy, lyapunov
from there import there

from orbitdb import Catalogue, Selection, Stadium, solve_word
from orbitdb.answers.complete_periods import read_complete_periods, sum_rules_of
from orbitdb.answers.entropy import enclosure
from orbitdb.answers.stadium_levels import orbits_for, read_orbits
from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.billiard.stability import birkhoff
from orbitdb.errors import InputError
from orbitdb.orbits.least_values import least_length
from orbitdb.orbits.status import Status
from orbitdb.plots import length_spectrum, staircase
from orbitdb.plots.registry import figure_of, load_function
from orbitdb.plots.work_precision import work_precision
from orbitdb.quantum.bouncing_balls import family_count
from orbitdb.quantum.length_spectrum import Spectrum
from orbitdb.quantum.weyl import weyl
from orbitdb.symbols.words import from_strings

WHOLE = Selection(1.6, periods=((2, 5),))


def draw(kind: str, catalogue: Any, chosen: Any, limit: int) -> Any:
    """Draw a figure of a subset; `limit` is the number of orbits on a sheet."""
    more = {"limit": limit} if kind == "sheet" else {}
    return load_function(figure_of(kind).whole)(catalogue, chosen, **more)


LONG = "time_reversal = 'self' and class_size > 0 and margin > 1e-9 and lambda_c < 99"


@pytest.mark.parametrize(("kind", "where"), [("sheet", LONG), ("sheet", None), ("lyapunov", LONG)])
@pytest.mark.slow
def test_titles_fit_into_their_figures(known, kind, where):
    chosen = Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,), where=where)
    made = draw(kind, known, chosen, 9)
    (title,) = (text for text in made.texts if text.get_text() == made.get_suptitle())
    FigureCanvasAgg(made).draw()
    drawn, whole = title.get_window_extent(), made.bbox
    assert whole.x0 < drawn.x0 < drawn.x1 < whole.x1
    assert drawn.y1 < whole.y1
    assert all(drawn.y0 > ax.get_window_extent().y1 for ax in made.axes)
    assert made.get_suptitle().endswith("...") == (where is not None and len(where) > 100)


@pytest.mark.slow
def test_the_figure_of_entropy_shows_whole_periods_and_proved_bounds(known):
    made = draw("entropy", known, WHOLE, 0)
    (ax,) = made.axes
    found = entropy(known.classes(a=1.6, p="2-5"), 5)
    p, k_0 = named(ax, "$K_0")
    assert p.tolist() == [2, 3, 4, 5]
    assert k_0 == pytest.approx(found.K_0)
    assert ax.containers == []  # no error bars: a change between two periods bounds nothing
    p, h_zeta = named(ax, "$h(p)$")
    assert p.tolist() == [2, 3, 4, 5]
    np.testing.assert_allclose(h_zeta, found.h_zeta)
    (band,) = ax.patches
    proved = answer(known.path, enclosure, 1.6).bounds
    assert (band.get_y(), band.get_height()) == pytest.approx((proved.lower, proved.upper - proved.lower))
    assert made.get_suptitle() == "Words of period 2 to 5 at $a = 1.6$"
    by_period(ax, "topological entropy\n(per bounce)")
    inside = [*k_0[1:], *found.h_zeta[2:], proved.lower, proved.upper]
    room = 0.12 * (max(inside) - min(inside))
    assert ax.get_ylim() == pytest.approx((min(inside) - room, max(inside) + room))
    assert ax.get_xlim() == (1.3, 5.5)
    low, high = ax.get_ylim()
    for caret, values in zip(ax.lines[2:], (h_zeta, k_0), strict=True):  # what is below the axis
        below = p[values < low].tolist()
        assert caret.get_xydata().tolist() == [[period, pytest.approx(low)] for period in below]
        assert 2 in below
    assert np.nanmax([h_zeta, k_0]) < high
    beside = [line.get_transform().transform((2.0, low)) for line in ax.lines[2:]]
    assert 4 < beside[1][0] - beside[0][0] < 20  # pixels
    assert "$h(p)$" in [text.get_text()[:6] for text in made.legends[0].get_texts()]
    assert made.notes == ("h_zeta lies outside the proved bounds at periods 2-5",)
    upper = draw("entropy", known, Selection(1.6, periods=((3, 5),)), 0)
    p, higher = named(upper.axes[0], "$K_0")
    assert (p.tolist(), higher.tolist()) == ([3, 4, 5], k_0[1:].tolist())


@pytest.mark.slow
def test_the_figure_of_exponents_shows_every_method(known):
    made = draw("lyapunov", known, Selection(1.6, periods=((2, 6),)), 0)
    subset = known.classes(a=1.6, p="2-6")
    found = lyapunov(subset, 6)
    rules = sum_rules_of(answer(known.path, read_complete_periods, Selection(1.6, periods=((2, 6),))))
    trajectory = known.reference(a=1.6)
    assert len(made.axes) == 2
    for ax, name, unit in zip(made.axes, ("lambda_d", "lambda_c"), ("bounce", "length $R$"), strict=True):
        for label, column in (("average", ""), ("mean of", "_pair"), ("zeta", "_zeta")):
            p, values = named(ax, label)
            assert p.tolist() == [2, 3, 4, 5, 6]
            np.testing.assert_allclose(values, getattr(found, f"{name}{column}"))
        np.testing.assert_array_equal(named(ax, "sum rules")[1], getattr(rules, f"{name}_sum_rule"))
        edges = ax.collections[0].get_paths()[0].vertices[:, 1]
        error = getattr(rules, f"{name}_sum_rule_error")
        assert edges.max() - edges.min() == pytest.approx(2 * error.max(), rel=0.1)
        assert named(ax, "random")[1].tolist() == [getattr(trajectory, name)] * 2
        (band,) = ax.patches
        assert band.get_height() == pytest.approx(4 * getattr(trajectory, f"{name}_error"))
        assert ax.get_ylabel() == rf"$\langle \{name} \rangle$ (per {unit})"
        assert len(legend(ax)) == 5
    by_period(made.axes[1], r"$\langle \lambda_c \rangle$ (per length $R$)")
    assert [text.get_text() for text in made.legends[0].get_texts()] == legend(made.axes[1])
    assert made.get_suptitle() == "Words of period 2 to 6 at $a = 1.6$"
    assert made.axes[0].get_xlabel() == ""
    assert made.notes == ()
    assert_later_periods_fill(made.axes)
    bare = draw("lyapunov", known, Selection(1.0, periods=((3, 4),)), 0)
    curves = [each for each in bare.axes[1].get_lines() if not str(each.get_label()).startswith("_")]
    assert [str(each.get_label())[:4] for each in curves] == [
        "aver",
        "mean",
        "zeta",
        "sum ",
    ]
    assert any("`catalogue.simulate(a=1)`" in line for line in bare.notes)


@pytest.mark.slow
def test_exponents_at_several_a_have_bars_for_every_error(known):
    chosen = [Selection(a, periods=((2, 6),)) for a in (1.6, 1.0)]
    made: Any = load_function("averages.lyapunov")(known, *chosen)
    for ax, name in zip(made.axes, ("lambda_d", "lambda_c"), strict=True):
        expected = []
        for subset in chosen:
            found = known.lyapunov(subset)
            values, errors = (np.array(found[f"{name}_sum_rule{end}"], float) for end in ("", "_error"))
            expected.append(
                [
                    (p, pytest.approx(value - error), pytest.approx(value + error))
                    for p, value, error in zip(found["p"], values, errors, strict=True)
                ]
            )
        bars = [[(p, start, end) for (p, start), (_, end) in each.get_segments()] for each in ax.collections]
        assert bars == expected
        assert legend(ax) == [f"$a = {a}$: sum rules (bars: error)" for a in ("1.6", "1")]


def assert_later_periods_fill(axes: Any) -> None:
    """Check that the later half of the periods fills the axes, and that carets mark earlier points beyond."""
    for ax in axes:
        low, high = ax.get_ylim()
        curves = [each for each in ax.lines if not str(each.get_label()).startswith("_")]
        values = [np.asarray(each.get_ydata(), float) for each in curves]
        later = np.concatenate([each[len(each) // 2 :] for each in values])
        later = later[np.isfinite(later)]
        assert (later.min() - low, high - later.max()) == pytest.approx([0.12 * np.ptp(later)] * 2)
        carets = [each for each in ax.lines if str(each.get_label()).startswith("_")]
        marked = sorted(point for each in carets for point in each.get_xydata().tolist())
        beyond = [
            (p, value)
            for each, of in zip(curves, values, strict=True)
            for p, value in zip(each.get_xdata(), of, strict=True)
            if value > high or value < low
        ]
        assert [p for p, _ in marked] == sorted(p for p, _ in beyond)
        assert {edge for _, edge in marked} <= {low, high}


def test_a_sheet_leaves_out_words_that_are_not_orbits(known):
    every = Selection(1.6, periods=((5, 5),))
    orbits, words = (
        set(known.select(chosen).representative.tolist())
        for chosen in (Selection(1.6, periods=((5, 5),), statuses=(Status.ORBIT,)), every)
    )
    _, drawn = draw("sheet", known, every, 99).axes[0].collections
    assert len(drawn.get_segments()) == len(orbits) < len(words)


LIMITS = [
    (3, ["3 of 8 classes are drawn; `limit=8` draws them all"]),
    pytest.param(8, [], marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("limit", "told"), LIMITS)
def test_a_sheet_shows_every_class_up_to_its_limit(known, limit, told):
    chosen = Selection(1.6, periods=((4, 4),), statuses=(Status.ORBIT,))
    made = draw("sheet", known, chosen, limit)
    (ax,) = made.axes
    classes = list(dict.fromkeys(known.select(chosen).representative.tolist()))
    orbits = [solve_word(word, 1.6) for word in classes[:limit]]
    labels = [text.get_text() for text in ax.texts]
    assert labels == [
        f"{orbit.code}\n$L = {orbit.length:.4f}$, $\\lambda_d = {orbit.lambda_d:.4f}$" for orbit in orbits
    ]
    outlines, paths = ax.collections
    walls, drawn = [path.vertices for path in outlines.get_paths()], paths.get_segments()
    assert len(walls) == len(drawn) == len(orbits)
    middles = [(wall.min(axis=0) + wall.max(axis=0)) / 2 for wall in walls]
    for middle, path, orbit in zip(middles, drawn, orbits, strict=True):
        np.testing.assert_allclose(path[:-1] - middle, there(orbit.points), atol=1e-12)
    np.testing.assert_allclose([text.xy for text in ax.texts], np.array(middles) - [0, 1.12])
    np.testing.assert_allclose(ax.lines[0].get_xydata(), np.concatenate([path[:-1] for path in drawn]))
    title = "Classes of orbits of period 4 at $a = 1.6$"
    assert made.get_suptitle().replace("\n", " ") == title
    assert [*made.notes] == told
    assert (ax.get_aspect(), ax.axison) == (1, False)
    across, down = ({round(middle[k], 6) for middle in middles} for k in (0, 1))
    assert (len(across), len(down)) == ((2, 4) if limit == 8 else (2, 2))
    assert ax.get_xlim() == pytest.approx((-2.9, 2 * 5.8 - 2.9))
    assert ax.get_ylim() == pytest.approx((min(down) - 2.15, 1.25))


def test_the_figure_of_phase_space_shows_every_bounce(known):
    chosen = Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,))
    made = draw("phase-space", known, chosen, 0)
    (ax,) = made.axes
    (bar,) = ax.child_axes
    subset = known.select(chosen, coordinates=True)
    orbits = [solve_word(word, 1.6) for word in subset.code.tolist()]
    places = [birkhoff(Stadium(1.6), from_strings([o.code]), there(o.coordinates)[None]) for o in orbits]
    expected = np.concatenate([np.column_stack([each.ravel() for each in place]) for place in places])
    (dots,) = ax.collections
    np.testing.assert_allclose(dots.get_offsets(), expected, atol=1e-9)
    colours = [there(orbit.lambda_d) for orbit in orbits for _ in orbit.code]
    np.testing.assert_allclose(dots.get_array(), colours)
    assert made.get_suptitle() == "Orbits of period 2 to 4 at $a = 1.6$"
    assert bar.get_ylabel() == r"$\lambda_d$ (per bounce)"


def test_the_figure_of_lengths_claims_no_more_than_is_proved(known):
    made = draw("lengths", known, Selection(1.6, periods=((2, 6),), statuses=(Status.ORBIT,)), 0)
    _, end, *_ = made.axes[0].get_lines()
    proved = least_length(6, 1.6)
    assert round(proved, 2) > proved  # so rounding up would show
    assert proved - 0.01 < end.get_xdata()[0] <= proved
    said = [text.get_text() for text in made.legends[0].get_texts()]
    assert any(f"up to $L = {end.get_xdata()[0]:.2f}" in line for line in said)
    each_a = (Selection(a, periods=((2, 6),), statuses=(Status.ORBIT,)) for a in (1.6, 1.0))
    both = load_function(figure_of("lengths").whole)(known, *each_a)
    ends = [line.get_xdata()[0] for line in both.axes[0].get_lines() if line.get_linestyle() == "--"]
    assert ends == pytest.approx([least_length(6, a) for a in (1.6, 1.0)], abs=0.01)


@pytest.mark.slow
def test_the_figure_of_lengths_shows_every_orbit_and_where_it_is_complete(known):
    made = draw("lengths", known, Selection(1.6, periods=((2, 4),), statuses=(Status.ORBIT,)), 0)
    above, below = made.axes
    (bar,) = below.child_axes
    steps, end = above.get_lines()
    lengths = sorted(
        there(solve_word(w, 1.6).length) for w in known.select(a=1.6, p="2-4", status="orbit").code
    )
    assert steps.get_ydata()[-1] == len(lengths) == 41
    assert (steps.get_xdata()[0], steps.get_xdata()[-1]) == pytest.approx((lengths[0], lengths[-1]))
    assert steps.get_drawstyle() == "steps-post"
    assert above.get_yscale() == "log"
    assert above.get_ylabel() == "orbits no longer than $L$"
    complete = end.get_xdata()[0]
    assert complete == pytest.approx(least_length(4, 1.6), abs=0.01)
    assert complete < there(solve_word("11113", 1.6).length)
    (said,) = (text.get_text() for text in made.legends[0].get_texts())
    assert f"complete, by proof, up to $L = {complete:.2f}" in said
    assert (bar.get_ylabel(), below.get_ylabel()) == ("orbits per unit of $L/R$", "period $p$ (bounces)")
    assert (above.get_xlabel(), made.get_suptitle()) == ("", "Orbits of period 2 to 4 at $a = 1.6$")
    (mesh,) = below.collections
    edges = np.linspace(lengths[0] - 0.5, lengths[-1] + 0.5, 121)
    np.testing.assert_allclose(mesh.get_coordinates()[0, :, 0], edges)
    np.testing.assert_array_equal(mesh.get_coordinates()[:, 0, 1], [1.5, 2.5, 3.5, 4.5])
    for p, row in zip((2, 3, 4), mesh.get_array(), strict=True):
        codes = known.select(a=1.6, p=p, status="orbit").code
        bins = Counter(bisect_right(edges, there(solve_word(word, 1.6).length)) - 1 for word in codes)
        assert row.filled(0) * (edges[1] - edges[0]) == pytest.approx([bins[k] for k in range(120)])
        assert row.mask.tolist() == [not bins[k] for k in range(120)]
    assert (isinstance(mesh.norm, LogNorm), mesh.get_cmap().name) == (True, "viridis")
    says(below, "length $L/R$", "period $p$ (bounces)")
    assert all(tick == round(tick) for tick in below.get_yticks())
    gap = draw("lengths", known, Selection(1.6, periods=((3, 4),), statuses=(Status.ORBIT,)), 0)
    assert (len(gap.axes[0].get_lines()), gap.legends) == (1, [])


@pytest.mark.parametrize("kind", slow_but(["lengths"], ["lengths", "phase-space", "sheet"]))
def test_figures_report_missing_periods(known, kind):
    made = draw(kind, known, Selection(1.6, periods=((2, 2), (7, 7)), statuses=(Status.ORBIT,)), 9)
    assert made.notes[0].startswith("period 7 is not filled at a = 1.6 (filled: periods 2-6; some at")


@pytest.mark.slow
def test_the_figures_of_levels_show_levels_and_orbits(known, tmp_path):
    path = Path(shutil.copy(known.path, tmp_path / "levels.db"))
    catalogue, chosen, stadium = Catalogue(path, 1.6), Selection(1.6), Stadium(1.6)
    with pytest.raises(
        InputError, match=r"no levels are stored from .*`catalogue\.fill_levels\(k=\(0, 30\), a=1\.6\)` finds"
    ):
        staircase.staircase(catalogue, chosen)
    k = sorted(chain(*keep_made_levels(path).values()))
    made: Any = staircase.staircase(catalogue, chosen)
    (ax,) = made.axes
    at, rest = named(ax, "levels")
    assert 0 < at[0] < 0.1
    assert 8.9 < at[-1] <= 9
    np.testing.assert_allclose(rest, np.searchsorted(k, at) - weyl(stadium, None)(at))
    classes, _ = answer(path, read_orbits, chosen)
    orbits = orbits_for(stadium, classes, None, np.array([9.0])).at(at)[0]
    np.testing.assert_allclose(named(ax, "orbits, cut off")[1], orbits - weyl(stadium, None)(at))
    np.testing.assert_allclose(named(ax, "bouncing balls")[1], family_count(stadium, at, 12.0))
    assert made.get_suptitle() == f"{len(k)} levels at $a = 1.6$, all parities, $k$ below 9"
    assert legend(ax) == ["levels", r"orbits, cut off at length $X = 10\,R$", "bouncing balls alone"]
    says(ax, "$kR$", "levels below $k$\nminus Weyl's law")
    spectrum: Any = length_spectrum.spectrum(catalogue, chosen)
    found = catalogue.spectrum(resolution=1000)
    for label, values in (("levels", np.abs(there(found.quantum))), ("orbits", -np.abs(found.orbits))):
        lengths, drawn = named(spectrum.axes[0], label)
        np.testing.assert_allclose(lengths, np.linspace(1, 12, 1000))
        np.testing.assert_allclose(drawn, values)
    drawn_beside(spectrum.axes[0], found, 1)
    assert {text.get_text() for text in spectrum.axes[0].texts} == {peak.code for peak in found.peaks(1)}
    assert spectrum.get_suptitle() == "Length spectrum at $a = 1.6$, all parities, $k$ below 9"
    assert [*spectrum.notes] == found.notes()


def drawn_beside(ax: Any, found: Spectrum, side: int) -> None:
    """Check the axes and labels of a length spectrum; peaks are labelled above it if side > 0, else below."""
    (band,) = ax.patches
    assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx((found.complete_length, 12))
    assert legend(ax) == [*["levels"] * (side > 0), "orbits, downwards", "orbits may be missing"]
    peaks = found.peaks(1)
    for text, peak in zip(ax.texts, peaks, strict=True):
        assert text.xy == (peak.length, side * peak.height)
        assert (np.sign(text.xyann[1]), text.get_va()) == (side, "bottom" if side > 0 else "top")
    low = -np.abs(found.orbits).max()
    high = 0 if found.quantum is None else np.abs(found.quantum).max()
    assert ax.get_xlim() == (1, 12)
    below, above = (0.04, 0.16)[::side]
    assert ax.get_ylim() == pytest.approx((low - below * (high - low), high + above * (high - low)))
    ax.figure.draw_without_rendering()
    assert [float(text.get_text()) for text in ax.get_yticklabels()] == np.abs(ax.get_yticks()).tolist()
    says(ax, "length $x/R$", r"$|F(x)|$")


def test_the_length_spectrum_can_be_drawn_without_levels(known):
    made: Any = length_spectrum.spectrum(known, Selection(1.6))
    drawn_beside(made.axes[0], known.spectrum((1.0, 12.0), resolution=1000), -1)


def test_the_figure_of_methods_shows_run_time_against_error(rng):
    methods = ("balls", "newton", "relaxation", "root")
    rows = [
        WorkPrecision(method, 0.0, 1, 0.0, seconds, 0, error, *[0.0] * 5)
        for method in methods
        for error, seconds in rng.uniform(1e-16, 1e-3, (3, 2)).tolist()
    ]
    made = work_precision(rows, "p = 4")
    (ax,) = made.axes
    assert ax.get_title() == "Run time against error, $p = 4$"
    assert len(made.legends[0].get_texts()) == 4
    assert len(legend(ax)) == 4
    for method, label in zip(methods, ("ball arithmetic", "Newton", "relaxation", "scipy"), strict=True):
        mine = [(row.coordinates_max, row.seconds_per_sequence) for row in rows if row.method == method]
        assert named(ax, label).T.tolist() == [[*each] for each in mine]
    assert ax.lines[-1].get_xdata() == [np.finfo(float).eps / 2] * 2
    assert texts(ax) == {"double": (np.finfo(float).eps / 2, 0)}
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    says(ax, "largest error of a coordinate (units of $R$, rad)", "run time per word (s)")
