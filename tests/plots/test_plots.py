"""Figures show the given data, and files have the format that their extension names."""

import os
import sys
import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import processes
import pytest
from matplotlib import rc_context
from matplotlib.image import imread
from quick import slow_but
from there import there

from orbitdb import Catalogue, Selection, Stadium, solve_word
from orbitdb.answers.lyapunov import AVERAGES
from orbitdb.answers.results import Result
from orbitdb.plots import paths, style
from orbitdb.plots.averages import compare_exponents
from orbitdb.svg import symbol_labels

WORDS = ["13", "1232131", "010232", "111333", "11133"]
SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("word", WORDS)
def test_every_bounce_carries_its_symbol_outside_the_stadium(word):
    orbit = solve_word(word, Stadium(1.6))
    points, labels = there(orbit.points), symbol_labels(Stadium(1.6), there(orbit.points), orbit.code)
    places = np.array([place for place, *_ in labels])
    for symbol, point in zip(orbit.code, points, strict=True):
        nearest = np.hypot(*(places - point).T).argmin()
        assert symbol in labels[nearest][2].split(", ")
    for place, outward, text in labels:
        x, y = np.add(place, np.multiply(0.2, outward))
        assert np.hypot(x - np.clip(x, -1.6, 1.6), y) == pytest.approx(1.2)
        sides = {"0": (0, -1), "2": (0, 1), "1": (-1, 0), "4": (-1, 0), "3": (1, 0), "5": (1, 0)}
        for across, up in (sides[symbol] for symbol in text.split(", ")):
            assert np.dot(outward, (across, up)) > 0  # the wall or semicircle that the symbol names


def test_a_bounce_that_an_orbit_passes_both_ways_has_both_symbols():
    """111333 turns round nowhere, 111232 retraces its run: each of the outer bounces is 1 and then 4."""
    retraced = solve_word("0111044", 1.6)
    assert retraced.points is None or "1, 4" in {
        text for *_, text in symbol_labels(Stadium(1.6), retraced.points, retraced.code)
    }


@pytest.mark.parametrize(
    ("ending", "head"), slow_but(1, [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
)
def test_files_match_their_extensions_and_are_reproducible(tmp_path, ending, head):
    stadium, orbit = Stadium(1.2), solve_word("1232131", Stadium(1.2))
    for name in "ab":
        with style.figure(4, 3) as made:
            paths.draw_orbit(made.add_subplot(), stadium, there(orbit.points), orbit.code)
        style.save(made, tmp_path / f"{name}.{ending}", ending, "an orbit")
    first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in "ab")
    assert first.startswith(head)
    assert first == second


def test_a_figure_has_its_size_whatever_the_users_style_says(tmp_path):
    with rc_context({"savefig.bbox": "tight"}):
        with style.figure(4, 3) as made:
            made.add_subplot().plot([0, 1])
        style.save(made, tmp_path / "a.png", "png", "a line", dpi=100)
    assert imread(tmp_path / "a.png").shape[:2] == (300, 400)


def test_exponents_at_several_a_are_compared_by_the_best_method_of_each(ax):
    columns = {name: [float(k)] * 3 for k, average in enumerate(AVERAGES) for name in average.columns}
    best, second = (average.of("lambda_d") for average in AVERAGES[:-3:-1])
    results = [
        Result(Selection(a), {"p": [2, 3, 4], **columns, best: columns[best] if a == 1 else [None] * 3})
        for a in (1.0, 1.6)
    ]
    compare_exponents(ax, results, "lambda_d")
    drawn = [np.asarray(line.get_ydata()).tolist() for line in ax.lines]
    assert drawn == [columns[best], columns[second]]


def test_the_svg_path_goes_through_the_bounces():
    stadium = Stadium(1.2)
    orbit = solve_word("1232131", stadium)
    root = ET.fromstring(there(orbit._repr_svg_()))
    (path,) = root.iter(f"{SVG}polygon")
    drawn = np.array([pair.split(",") for pair in path.attrib["points"].split()], dtype=float)
    scale = 480 / (2 * (1.2 + 1 + 0.3))
    np.testing.assert_allclose(drawn / scale * [1, -1], there(orbit.points), atol=0.01 / scale)


@pytest.mark.slow
def test_drawing_keeps_the_settings_of_a_notebook_backend(tmp_path):
    """The first figure loads the backend, which shows figures only while matplotlib is interactive."""
    (tmp_path / "notebook_backend.py").write_text(
        "import matplotlib\n"
        "from matplotlib.backends.backend_agg import FigureCanvas\n"
        "matplotlib.interactive(True)\n"
    )
    drawing = (
        "import matplotlib\n"
        "from orbitdb import solve_word\n"
        "solve_word('13', 1.6).plot()\n"
        "print(matplotlib.is_interactive())\n"
    )
    env = os.environ | {"MPLBACKEND": "module://notebook_backend", "PYTHONPATH": str(tmp_path)}
    done = processes.run("-c", drawing, command=[sys.executable], cwd=tmp_path, env=env)
    assert done.stdout.split() == ["True"], done.stderr


def test_words_without_an_isolated_orbit_have_no_picture():
    assert solve_word("0", Stadium())._repr_svg_() is None
    assert solve_word("02", Stadium()).points is None


@pytest.mark.slow
def test_orbits_and_subsets_can_be_drawn_into_axes(varied):
    from matplotlib import pyplot

    subset = Catalogue(varied).select(p="2-4", coordinates=True)
    left: Any
    _, (left, right) = pyplot.subplots(1, 2)
    assert subset.plot(ax=left) is left
    orbits, (dots,) = subset[subset.status == "orbit"], left.collections
    assert there(dots.get_array()).tolist() == np.repeat(orbits.lambda_d, orbits.p).tolist()
    bounces = [np.stack([there(each.arclength), there(each.sine)], axis=1) for each in orbits]
    np.testing.assert_allclose(np.asarray(dots.get_offsets()), np.concatenate(bounces), 1e-12, 1e-12)
    assert subset.plot("lengths", ax=right) is right
    assert (right.get_xlabel(), right.get_ylabel()) == ("length $L/R$", "orbits no longer than $L$")
    steps = np.asarray(right.lines[0].get_xydata())
    assert steps.tolist() == [[length, n] for n, length in enumerate(np.sort(orbits.length), 1)]
    for ax in (left, right):
        assert ax.get_title().replace("\n", " ") == style.titled(subset.selection.describe())
    orbit = Catalogue(varied)["3123"]
    ax = orbit.plot()
    assert ax.get_title() == orbit.code
    drawn = [np.asarray(line.get_xydata()) for line in ax.lines]
    assert any(len(path) == 5 and np.array_equal(path[:-1], there(orbit.points)) for path in drawn)
    pyplot.close("all")
    with pytest.raises(ValueError, match=r"1001 at .* cannot be drawn: geometrically pruned"):
        solve_word("1001", 1.6).plot()
    later = Catalogue(varied).select(p="2-4").plot("phase-space")  # without coordinates
    assert np.array_equal(later.collections[0].get_offsets(), dots.get_offsets())
    others: dict[Any, str] = {"circle": "", "symbol plane": "; symbol-plane is a figure of another result"}
    for kind, more in others.items():
        with pytest.raises(ValueError, match=f"'{kind}': use phase-space, lengths, sheet{more}$"):
            subset.plot(kind)
    with pytest.raises(ValueError, match="nothing to draw"):
        Catalogue(varied).select(p=3, status="geometric").plot("lengths")
