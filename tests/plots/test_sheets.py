"""Sheets of orbits in any order and of given words, figures of any size, and grids of small drawings."""

import io
import sys

import matplotlib
import pytest
from matplotlib.figure import Figure
from PIL import Image
from there import there

from orbitdb import Catalogue
from orbitdb.plots import style
from orbitdb.plots.length_spectrum import times as times_of
from orbitdb.quantum.length_spectrum import Peak

matplotlib.use("agg")


def labels(figure):
    """Return the codes under the drawings of a sheet, in order."""
    return [text.get_text().split("\n")[0] for text in figure.axes[0].texts]


@pytest.fixture
def drawn(monkeypatch):
    """Collect the figures that commands write."""
    from orbitdb.plots import style

    made, save = [], style.save

    def catch(figure, *rest):
        made.append(figure)
        save(figure, *rest)

    monkeypatch.setattr(style, "save", catch)
    return made


def test_a_sheet_draws_each_class_once_in_the_given_order(cli, filled, drawn, tmp_path):
    asked = ("plot", "sheet", "--order", "length", "--limit", "5", "-o", str(tmp_path / "s.svg"))
    found = cli(*asked, "--db", str(filled))
    classes = dict.fromkeys(Catalogue(filled).select(status="orbit", order="length").representative.tolist())
    assert labels(drawn[0]) == list(classes)[:5]
    assert found.err.startswith(
        f"5 of {len(classes)} classes are drawn; --limit {len(classes)} draws them all\n"
    )


def test_words_from_stdin_are_drawn_in_order(cli, filled, drawn, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO("310\n1232131\n001\n"))
    found = cli("plot", "sheet", "-", "-o", str(tmp_path / "s.png"), "--db", str(filled))
    assert found.code == 0
    assert labels(drawn[0]) == ["310", "1232131"]
    assert "001 at a = 1.6 cannot be drawn: geometrically pruned" in found.err


@pytest.mark.slow
def test_a_figure_has_the_given_size_resolution_and_title(cli, filled, drawn, tmp_path):
    path = tmp_path / "f.png"
    asked = ("--size", "5x4", "--dpi", "50", "--title", "Mine", "--p", "3", "-o", str(path))
    for kind in ("sheet", "phase-space"):
        assert cli("plot", kind, *asked, "--force", "--db", str(filled)).code == 0
        with Image.open(path) as image:
            assert image.size == (250, 200)
        assert drawn[-1].get_suptitle() == "Mine"
    assert cli("plot", "orbit", "13", *asked[:6], "-o", str(path), "--force", "--db", str(filled)).code == 0
    assert drawn[-1].axes[0].get_title() == "Mine"


def test_a_sheet_fills_the_given_size_and_its_text_stays_text(cli, filled, drawn, tmp_path):
    path = tmp_path / "f.svg"
    rows = []
    for size in ("12x2", "3x9"):
        asked = ("plot", "sheet", "--p", "3", "--size", size, "-o", str(path), "--force")
        assert cli(*asked, "--db", str(filled)).code == 0
        rows.append(len({round(text.xy[1], 3) for text in drawn[-1].axes[0].texts}))
    assert rows[0] < rows[1]
    assert f">{labels(drawn[-1])[0]}</text>" in path.read_text(encoding="utf-8")


def test_a_size_of_one_number_is_the_width(cli, filled, drawn, tmp_path):
    asked = ("--p", "2-4", "-o", str(tmp_path / "f.svg"), "--force", "--db", str(filled))
    assert cli("plot", "entropy", "--size", "3.39", *asked).code == 0
    assert drawn[0].get_size_inches().tolist() == [3.39, pytest.approx(4.2 * (3.39 / 6.4) ** 0.5)]
    refused = cli("plot", "entropy", "--size", "3.39x", *asked)
    assert "give a width of 1 to 100 inches, and perhaps a height" in refused.err


def test_a_title_is_not_broken_within_an_equation():
    for width in (3.39, 4.0):
        title = style.wrapped("3.0 ± 0.1 of 179 levels are missing at a = 1.6 (P 0.997)", width)
        assert title.replace("\n", " ") == "3.0 ± 0.1 of 179 levels are missing at a = 1.6 (P 0.997)"
        lines = title.split("\n")
        assert not any(line.endswith((" =", " a", "P", "±", "3.0")) or line[0] in "=±" for line in lines)


@pytest.mark.slow
def test_several_half_lengths_are_drawn_together(cli, varied, drawn, tmp_path):
    for kind in ("lyapunov", "lengths"):
        asked = ("plot", kind, "--a", "1", "--a", "1.6", "-o", str(tmp_path / "f.png"), "--force")
        assert cli(*asked, "--db", str(varied)).code == 0
        names = [text.get_text().split(":")[0] for text in drawn[-1].legends[0].get_texts()]
        assert [name for name in names if name.startswith("$a")] == ["$a = 1$", "$a = 1.6$"]
        assert drawn[-1].get_suptitle() == "Orbits at $a = 1$, 1.6"
    refused = cli("plot", "phase-space", "--a", "all", "-o", str(tmp_path / "g.png"), "--db", str(varied))
    assert "plot phase-space draws one a" in refused.err


def test_a_subset_can_be_drawn_as_a_sheet(filled):
    chosen = Catalogue(filled).select(p="2-3", status="orbit", coordinates=True)
    assert labels(chosen.plot("sheet").figure) == chosen.code.tolist()
    later = Catalogue(filled).select(p="2-3", status="orbit").plot("sheet")
    assert labels(later.figure) == chosen.code.tolist()


@pytest.mark.slow
def test_a_grid_of_orbits_does_not_overlap(filled):
    """Titles, numbers and labels do not extend into neighbouring drawings."""
    figure = Figure(figsize=(8, 8))
    chosen = Catalogue(filled).select(p="2-5", status="orbit", coordinates=True)[:8]
    axes = [orbit.plot(ax=ax) for orbit, ax in zip(chosen, figure.subplots(5, 4).flat, strict=False)]
    figure.canvas.draw()
    boxes = [there(ax.get_tightbbox()) for ax in axes]
    for n, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:n])


@pytest.mark.parametrize(("times", "told"), [(1, "13"), (2, "2 × 13"), (0.5, "½ × 13"), (1.5, "1½ × 13")])
def test_half_orbits_are_written_as_halves(times, told):
    assert times_of(Peak(1.0, 1.0, "13", times, 1.0, 1.0)) == told


def test_peaks_of_one_parity_include_half_orbits(filled):
    catalogue = Catalogue(filled)
    peaks = list(catalogue.spectrum((4, 8), k=16, parity="oo").peaks(3))
    halves = [peak for peak in peaks if peak.repetitions % 1]
    assert halves
    for peak in peaks:
        whole = 4.0 if peak.code == "02" else there(catalogue[peak.code].length)
        assert peak.total == pytest.approx(peak.repetitions * whole)
