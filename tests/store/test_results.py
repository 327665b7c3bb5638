"""Results by period, histograms and proved bounds, from the library, commands and rows."""

import re
from collections import Counter
from itertools import product

import numpy as np
import pytest
from contents import alter, ask, made
from rules import broken_by_hand
from there import there

from orbitdb import Catalogue, InputError
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import search
from orbitdb.filling.fill import fill_periods
from orbitdb.selection import Selection
from orbitdb.symbols.words import SYMBOLS


@pytest.fixture
def catalogue(filled_once):
    return Catalogue(filled_once, a=1.6)


def test_counts_reproduce_table_1_of_the_paper(catalogue):
    found = catalogue.table()
    assert found["N_c"] == [1, 8, 32, 80, 188, 376, 1424]
    assert found["N"] == [2, 24, 130, 400, 1154, 2632, 11522]
    assert found.to_pandas()["N_t"].tolist() == [1, 8, 32, 96, 252, 712, 2096]


def test_fills_count_the_words_that_break_each_rule(catalogue):
    for fill in catalogue.fills()[:4]:
        texts = ["".join(symbols) for symbols in product(SYMBOLS, repeat=fill.p)]
        words = [w for w in texts if all(w < w[i:] + w[:i] for i in range(1, fill.p))]
        broken = Counter(rule for word in words for rule in broken_by_hand(word))
        assert (fill.primitive, fill.pruned) == (len(words), tuple(broken[rule] for rule in range(1, 7)))


def test_a_subset_gives_the_results_of_the_catalogue(catalogue, varied):
    chosen = catalogue.select(p="2-8")
    entropies, averages = catalogue.entropy(p="2-8"), catalogue.lyapunov(p="2-8")
    for name in ("p", "N", "K_0", "h_zeta"):
        assert chosen.entropy()[name] == entropies[name]
    found = chosen.averages()
    for name in found.columns:
        np.testing.assert_allclose(_numbers(found[name]), _numbers(averages[name]), rtol=1e-14, atol=1e-15)
    for each in (catalogue, Catalogue(varied, a=1.0)):  # includes words through a joint
        assert each.select(p="2-8", status="all").table().columns == each.table().columns
        found = each.select(p="2-8").table()
        assert [found["N_t"], found["boundary"], found["unresolved"]] == 3 * [len(found) * [None]]
        assert "N_t, boundary and unresolved are blank" in found.notes[0]
        assert each.select(p="2-8", status="all").table().notes == ()
        assert found["N_c"] == each.table()["N_c"]


def test_averages_of_a_subset_have_no_sum_rules(catalogue):
    chosen = catalogue.select(p="2-8", status="orbit")
    found = chosen[chosen.length < 14].averages()
    assert set(found["lambda_d_sum_rule"]) == {None}
    assert any("part" in note for note in found.notes)
    assert found["lambda_d"][0] == catalogue.lyapunov(p=2)["lambda_d"][0]


def test_missing_periods_are_noted(catalogue):
    found = catalogue.entropy(p="7-12")
    assert any("not filled" in note for note in found.notes)
    assert found["h_zeta"] == catalogue.entropy(p="2-8")["h_zeta"][-2:]
    nothing = catalogue.entropy(p=12)
    assert repr(nothing) == "\n".join(["<no orbits of period 12 at a = 1.6>", *nothing.facts, *nothing.notes])
    assert catalogue.table(Selection(periods=((0, 1),))).notes == ("no words of period 0 to 1 at a = 1.6",)
    with pytest.raises(InputError, match="exp or det"):
        catalogue.lyapunov(weight="none")


def test_divisors_missing_from_sums_are_noted(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    made(catalogue.path, fill_periods(catalogue.path, 1.6, [3, 4, 6]))
    found = catalogue.table()
    assert found["N"] == [24, None, None]
    assert [note for note in found.notes if "N also needs" in note] == [
        "p = 4: N also needs p = 2 (not filled)", "p = 6: N also needs p = 2 (not filled)"
    ]  # fmt: skip


def test_a_result_is_shown_as_a_table(catalogue):
    found = catalogue.table(p="2-4")
    assert str(found).splitlines()[0].split() == list(found.columns)
    cells = re.findall("<td>(.*?)</td>", found._repr_html_())
    assert cells == [text for line in str(found).splitlines()[1 : 1 + len(found)] for text in line.split()]
    assert max(map(len, cells)) < 12  # six digits


def _numbers(values):
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def test_bins_have_round_edges(filled_once):
    lengths = Catalogue(filled_once).histogram("length", p="2-5", bins=10)
    assert lengths.edges == pytest.approx(np.arange(10, 23, 2))
    fine = Catalogue(filled_once).histogram("lambda_d", p="2-5", bins=10).edges
    assert fine.tolist() == [float(f"{edge:.2f}") for edge in fine]
    alone = Catalogue(filled_once).histogram("length", p=2, bins=10)
    assert (alone.counts.tolist(), alone.edges.tolist()) == ([1], [10.0, 11.0])
    none = Catalogue(filled_once).histogram("born", bins=10)
    assert (len(none.edges), len(none.counts), none.without) == (0, 0, Catalogue(filled_once).count())


@pytest.mark.slow
@pytest.mark.parametrize("column", ["code", "element", "area", "cycle", "lenght"])
def test_only_columns_that_all_words_of_a_class_share_are_counted(filled_once, column):
    """The signed area differs between mirror images, so the representative's cannot stand for all words."""
    for count in (lambda c: c.count(by=[column]), lambda c: c.histogram(column), lambda c: c.histogram("p")):
        with pytest.raises(InputError, match="the columns are"):
            count(Catalogue(filled_once))


@pytest.mark.parametrize(("least", "most", "logarithmic"), [(1, 1000, False), (1, 1001, True), (0, 1, False)])
def test_bins_are_logarithmic_if_values_span_decades(filled, least, most, logarithmic):
    alter(
        filled,
        f"UPDATE orbit SET margin = {least} WHERE margin > 0",
        f"UPDATE orbit SET margin = {most} WHERE cycle IN (SELECT id FROM cycle WHERE p = 2)",
    )
    margins = Catalogue(filled).histogram("margin", where="margin >= 0", bins=10)
    assert margins.logarithmic is logarithmic
    spaces = np.diff(np.log(margins.edges) if logarithmic else margins.edges)
    assert np.ptp(spaces) < 1e-9 * spaces[0]
    assert (margins.counts[-1], margins.counts[0]) == (1, margins.counts.sum() - 1)


@pytest.mark.slow
def test_proved_bounds_are_stored_once_and_read_back(filled, cli):
    for options in (["--edges", "4", "--prove"], ["--edges", "11"], ["--a", "0.5", "--edges", "4"]):
        assert cli("bounds", *options, "--db", str(filled)).code == 0
    catalogue = Catalogue(filled)
    *_, found = search(Stadium(1.6), edges=11)
    closest = there(catalogue.entropy_bounds())
    assert (closest.lower, closest.upper, closest.edges) == (found.lower, found.upper, 11)
    assert (closest.windows, closest.undecided, closest.arithmetic) == (
        found.windows,
        found.undecided,
        "doubles",
    )
    surer = there(catalogue.entropy_bounds(a=1.6, arithmetic="balls"))
    assert (surer.edges, surer.arithmetic) == (4, "balls")
    assert surer.width > closest.width
    *_, line = catalogue.table(p=3).facts
    sources = f"proved from {closest.basis}; {surer.between} from {surer.basis}"
    assert line.endswith(f"{closest.between}, {sources}")
    assert [(each.a, each.edges) for each in catalogue.entropy_curve()] == [(0.5, 4), (1.6, 11)]
    assert [each.a for each in catalogue.entropy_curve(arithmetic="balls")] == [1.6]
    assert catalogue.entropy_bounds(a=3) is None
    with pytest.raises(InputError, match="use doubles or balls"):
        catalogue.entropy_bounds(arithmetic="faith")
    assert catalogue.a_values() == [1.6]
    before = [ask(filled, f"SELECT * FROM {table}") for table in ("entropy_bound", "run")]
    assert len(before[0]) == 3 + 10 + 3
    cli("bounds", "--edges", "5", "--db", str(filled))
    assert [ask(filled, f"SELECT * FROM {table}") for table in ("entropy_bound", "run")] == before
    alter(filled, "UPDATE entropy_bound SET lower = 0 WHERE edges = 11")
    cli("bounds", "--edges", "11", "--db", str(filled))
    assert catalogue.entropy_bounds() == closest
    alter(filled, "DELETE FROM entropy_bound WHERE proof = 'doubles'")
    assert surer.between not in catalogue.table(p=3).facts[0]  # wider than what a moment finds
