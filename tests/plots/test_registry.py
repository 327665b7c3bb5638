"""The registry of figures: names, options, what is said of nothing to draw, and figures of any width."""

import re
import shutil
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from figures import texts_are_readable
from made_levels import keep_made_levels

from orbitdb import Catalogue, Selection, escape, solve_word
from orbitdb.errors import InputError
from orbitdb.plots import averages, screen, style
from orbitdb.plots.registry import FIGURES, NAMES, EmptyFigureError, figure_of, load_function

matplotlib.use("agg")
COLUMNS = (8.6 / 2.54, 17.8 / 2.54)
"""Widths of one column and of two columns of a journal, in inches."""


def test_every_figure_has_its_functions_and_says_what_it_shows():
    for figure in FIGURES:
        functions = [path for path in (figure.whole, figure.axes) if path]
        assert functions
        assert all(callable(load_function(path)) for path in functions)
        assert bool(figure.shows) == (bool(figure.whole) and not figure.when)
    assert len({*NAMES}) == len(NAMES)


def test_a_variant_is_chosen_by_its_option():
    assert figure_of("entropy").whole == "averages.entropy"
    assert figure_of("entropy", ["over_a", "p"]).whole == "over_a.entropy_over_a"
    assert figure_of("sheet", ["code"]).source == "orbits"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["phase_space", "Phase space"])
def test_hyphens_underscores_and_blanks_are_the_same(cli, filled, tmp_path, name):
    from matplotlib import pyplot

    target = tmp_path / "f.png"
    assert cli("plot", name, "--p", "3", "-o", str(target), "--db", str(filled)).code == 0
    assert target.exists()
    ax = Catalogue(filled).select(p=3, status="orbit", coordinates=True).plot(name)
    assert ax.get_ylabel() == r"$\sin\alpha$"
    pyplot.close("all")


def test_an_unknown_figure_is_refused_with_those_that_there_are(cli, filled, tmp_path):
    refused = cli("plot", "circle", "-o", str(tmp_path / "f.png"), "--db", str(filled))
    assert refused.code == 2
    assert "circle" in refused.err
    assert "phase-space" in refused.err


EMPTY = {
    "births": ("births", "orbitdb births --p 11"),
    "entropy --over-a": ("proved bounds", "orbitdb bounds"),
    "lengths --p 9": ("period 9", "orbitdb fill --p 9"),
    "phase-space --p 9": ("period 9", "orbitdb fill --p 9"),
    "sheet --p 9": ("period 9", "orbitdb fill --p 9"),
    "entropy --p 9": ("period 9", "orbitdb fill --p 9"),
    "lyapunov --p 9": ("period 9", "orbitdb fill --p 9"),
    "staircase": ("levels", "orbitdb levels"),
    "rigidity": ("levels", "orbitdb levels"),
}


@pytest.mark.parametrize("figure", EMPTY)
def test_an_empty_figure_is_not_drawn_but_says_what_is_missing(cli, filled, tmp_path, figure):
    target = tmp_path / "f.png"
    outcome = cli("plot", *figure.split(), "-o", str(target), "--db", str(filled))
    assert outcome.code != 0
    assert not target.exists()
    assert all(text in outcome.err for text in EMPTY[figure])


WORD = {"code": "010203113"}
FEW: dict[str, dict[str, Any]] = {
    "orbit": WORD,
    "reverse": WORD,
    "life": WORD,
    "field": {"code": "1232131"},
    "sheet": {"p": "2-5", "limit": 8},
    "births": {"p": "2-5"},
    "wave": {"code": "0123", "k": 4.5, "parity": "ee"},
    "husimi": {"code": "0123", "k": 4.5, "parity": "ee"},
    **{name: {} for name in ("spectrum", "staircase", "spacings", "rigidity")},
}
"""What draws each figure with few orbits or levels; the others show periods up to 5."""


def drawn(name: str, catalogue: Catalogue, width: float) -> style.Picture:
    """Draw a figure with few orbits, levels or trajectories."""
    if name == "escape":
        with style.sized((width, None)):
            made: style.Picture = load_function("escape.escape")(
                escape(1.6, "top:-0.3:0.3", trajectories=5000)
            )
        return made
    return catalogue.plot(name, size=width, **FEW.get(name, {"p": "2-5"}))


@pytest.fixture(scope="session")
def whole(known, made_once) -> Catalogue:
    """The catalogue to draw, with levels."""

    def make(path: Path) -> None:
        shutil.copy(known.path, path)
        keep_made_levels(path)

    return Catalogue(made_once("whole", make), 1.6)


QUICK = {"orbit", "births"}
CASES = [
    pytest.param(
        name, width, marks=pytest.mark.fuzz if width > 4 else [] if name in QUICK else pytest.mark.slow
    )
    for name in NAMES
    if name != "assess"  # which needs more orbits: it has a test of its own
    for width in COLUMNS
]


@pytest.mark.usefixtures("few_places")
@pytest.mark.parametrize(("name", "width"), CASES)
def test_a_figure_fits_a_column_and_its_text_can_be_read(whole, name, width):
    """Each text is inside the figure, has 7 points or more and is clear of others; axes keep their room."""
    made = drawn(name, whole, width)
    assert made.get_size_inches()[0] == width
    assert made.get_size_inches()[1] < 2.2 * width
    texts_are_readable(made)
    for ax in made.axes:
        assert ax.get_window_extent().height > made.bbox.height / (3.5 * len(made.axes))


@pytest.mark.parametrize(
    ("name", "given", "told"),
    [
        ("circle", {}, "use one of orbit, reverse, life"),
        ("births", {"code": "13"}, "plot births does not use code"),
        ("births", {"selection": "13"}, "plot births does not use code"),
        ("lengths", {"order": "p"}, "plot lengths does not use order"),
        ("orbit", {}, "give it as `code='1232131'`"),
        ("orbit", {"code": ["13", "0123"]}, "plot orbit draws one word"),
        ("orbit", {"code": "13", "a": [1, 2]}, "several a: plot orbit draws one a"),
        ("orbit", {"code": "13", "size": (3, 0)}, "give a width of 1 to 100 inches"),
        ("wave", {"k": 8.0}, "`parity='ee'`"),
        ("wave", {"k": (8, 9), "parity": "ee"}, "`k=20.17`"),
        ("spacings", {"levels": [1.0, 2.0]}, "such as {'oo': k}, or name one parity"),
    ],
)
def test_a_figure_refuses_arguments_that_it_cannot_use(known, name, given, told):
    with pytest.raises(InputError, match=re.escape(told)):
        known.plot(name, **given)


def test_python_draws_what_the_command_draws(cli, known, tmp_path):
    target = tmp_path / "orbit.svg"
    asked = ("1^3 3", "--a", "1.6", "--size", "5x4", "--title", "mine", "--opening", "right:0.2:0.3")
    assert cli("plot", "orbit", *asked, "-o", str(target), "--db", str(known.path)).code == 0
    made = known.plot("orbit", code="1^3 3", a=1.6, size=(5, 4), title="mine", opening="right:0.2:0.3")
    assert style.as_bytes(made, "svg", str(made.get_label())) == target.read_bytes()
    assert made._repr_png_().startswith(b"\x89PNG")


def test_a_figure_says_which_a_it_chose(tmp_path, cli):
    own = Catalogue.create(tmp_path / "own.db")
    own.fill(3, a=2)
    made = own.plot("sheet", p=3)
    assert [note for note in made.notes if "a = 2" in note]
    assert "at $a = 2$" in made.get_suptitle()


def test_nothing_to_draw_is_an_error_with_lines(known):
    with pytest.raises(EmptyFigureError) as caught:
        load_function("lengths.lengths")(known, Selection(1.6, periods=((9, 9),)))
    assert "`catalogue.fill(p=9, a=1.6)` fills it" in caught.value.lines[0]


@pytest.mark.slow
@pytest.mark.parametrize("in_phase_space", [False, True])
def test_the_screen_saves_an_orbit_as_a_figure(tmp_path, in_phase_space):
    from orbitdb.cli.tui.export import save_orbit

    for ending in ("png", "svg"):
        target = tmp_path / f"orbit.{ending}"
        assert str(target) in save_orbit(solve_word("1232131", 1.6), in_phase_space, target)
        assert target.stat().st_size > 1000


def test_the_screen_saves_its_averages_as_plot_draws_them(known):
    found = known.statistics(Selection(1.6, periods=((2, 6),)))
    made = screen.statistics(found, known.reference(a=1.6), "orbits")
    entropies = averages.entropy(known, Selection(1.6, periods=((2, 6),))).axes
    exponents = averages.lyapunov(known, Selection(1.6, periods=((2, 6),))).axes
    for mine, other in zip(made.axes, [*entropies, *exponents], strict=True):
        assert mine.get_ylim() == other.get_ylim()
        assert mine.get_ylabel() == other.get_ylabel()
        assert [*mine.get_legend_handles_labels()[1]] == [*other.get_legend_handles_labels()[1]]
    assert len(made.legends) == 1
    assert [ax.get_legend() for ax in made.axes] == [None] * 3


def test_the_screen_saves_its_counts_with_the_unit():
    made: Any = screen.counts([("2", 5), ("3", 8)], "length (radius)", "orbits")
    (ax,) = made.axes
    assert [bar.get_width() for bar in ax.containers[0]] == [5, 8]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["2", "3"]
    assert ax.yaxis_inverted()  # from the top down, as on the screen
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("number", "length (radius)")
