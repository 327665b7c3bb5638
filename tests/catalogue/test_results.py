"""Results of a catalogue have public names, show themselves as tables, and give data frames."""

import re
import shutil
from pathlib import Path

import pytest
from made_levels import keep_made_levels
from quick import slow_but

import orbitdb
from orbitdb import Catalogue, InputError, Rows, Selection
from orbitdb.answers.entropy import outside
from orbitdb.entropy_bounds.bounds import EntropyBounds


def with_levels(catalogue):
    copy = Path(shutil.copy(catalogue.path, catalogue.path.with_name("levels.db")))
    keep_made_levels(copy)
    return Catalogue(copy)


HELD = {
    "Subset": lambda c: c.select(p="2-4", status="orbit"),
    "Result": lambda c: c.table(),
    "Spectrum": lambda c: c.spectrum((4, 9), resolution=20),
    "Levels": lambda c: with_levels(c).levels(parity="ee"),
    "OrbitClasses": lambda c: c.classes(p="2-4"),
    "Fill": lambda c: c.fill("3-3")[-1],
    "Sweep": lambda c: c.sweep([6])[-1],
    "Life": lambda c: c.births(4)[0],
    "EntropyBounds": lambda c: c.prove_bounds(edges=4),
    "Reference": lambda c: c.simulate(bounces=20_000),
    "Verification": lambda c: c.verify(p="2-3"),
    "Trajectory": lambda c: c.identify(start=(0, 0.5, 1.2)),
    "FieldOrbits": lambda c: c.field(0.05, p="2-4"),
}
"""Every type of result, by its public name."""

FIRST = {
    "Subset": ("code", "13"),
    "Result": ("N_c", 1),
    "Spectrum": ("length", 4.0),
    "Levels": ("parity", "ee"),
    "OrbitClasses": ("words", 1),
    "Fill": ("N_c", 8),
    "Sweep": ("N_t", 252),
    "Life": ("representative", "0103"),
    "EntropyBounds": ("edges", 4),
    "Reference": ("seed", 0),
    "Verification": ("failures", 0),
    "Trajectory": ("sequence_first", -33),
    "FieldOrbits": ("kappa", 0.05),
}
"""A column of each result, with its first value."""


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    catalogue = Catalogue.create(tmp_path_factory.mktemp("results") / "c.db")
    catalogue.fill("2-5")
    catalogue.fill_births([4])
    return catalogue


@pytest.mark.slow
@pytest.mark.parametrize("name", HELD)
def test_a_result_has_a_public_name_a_short_repr_and_a_data_frame(catalogue, name):
    found = HELD[name](catalogue)
    assert isinstance(found, getattr(orbitdb, name))
    assert repr(found).count("\n") <= 26
    assert len(repr(found).splitlines()[0]) < 300
    frame = found.to_pandas()
    column, first = FIRST[name]
    assert frame[column].iloc[0] == first
    for values in (column for _, column in frame.items() if column.dtype == object):
        assert not all(value is None or isinstance(value, float) for value in values)


LISTS = {
    "p": lambda c: c.fill("2-3"),
    "upper": lambda c: c.entropy_curve(),
    "code": lambda c: c.identify(length=10.4),
    "strength": lambda c: c.scars((1, 3), code="13", parity="ee"),
    "N_t": lambda c: c.sweeps(),
}
"""A column of each list of results."""


@pytest.mark.parametrize("column", slow_but(set(LISTS) - {"strength"}, LISTS))
def test_a_list_of_results_is_a_data_frame_of_its_entries(catalogue, column):
    listed = LISTS[column](catalogue)
    frame = listed.to_pandas()
    assert len(frame) == len(listed)
    assert not listed or column in frame


@pytest.mark.slow
def test_scars_are_of_the_a_that_was_asked_for(catalogue, varied):
    there = Catalogue(varied, 1.0).scars((1, 3), code="13", parity="ee")
    assert catalogue.scars((1, 3), code="13", parity="ee", a=1.0) == there
    assert catalogue.scars((1, 3), code="13", parity="ee") != there


def test_missing_numbers_of_a_data_frame_are_nan(catalogue):
    frame = catalogue.lyapunov(p="4-5").to_pandas()
    assert set(frame.dtypes.drop("p").map(str)) == {"float64"}
    assert catalogue.entropy(p="4-5", status="orbit").to_pandas()["h_zeta"].dtype == float
    assert catalogue.select(p=4).to_pandas()["dies"].dtype == float


@pytest.mark.parametrize(
    "criteria", [{"status": "orbit,boundary"}, {"exists": 1.0}, {"where": "born is null"}, {"born": (0, 0.6)}]
)
def test_a_subset_has_the_entropies_and_averages_of_the_catalogue(criteria, varied, tmp_path):
    """Also at an a with orbits through joints, and if births are stored for some of its periods."""
    shutil.copy(varied, tmp_path / "orbits.db")
    catalogue = Catalogue(tmp_path / "orbits.db", 1.0)
    catalogue.fill_births(5)
    subset = catalogue.select(**criteria)
    for found, expected in (
        (subset.entropy(), catalogue.entropy(**criteria)),
        (subset.averages(), catalogue.lyapunov(**criteria)),
    ):
        for name, values in found.columns.items():
            assert values == [value if value is None else pytest.approx(value) for value in expected[name]]


def test_averages_of_words_that_are_no_orbits_are_refused(varied):
    catalogue, told = Catalogue(varied, 1.0), "leave out status dynamical"
    with pytest.raises(InputError, match=told):
        catalogue.lyapunov(status="dynamical")
    with pytest.raises(InputError, match=told):
        catalogue.select(status="dynamical").averages()


def test_a_subset_says_whose_births_are_not_stored(catalogue):
    subset = catalogue.select(p="2-3")
    assert (subset.born != subset.born).all()
    assert [note for note in subset.notes if "births of periods 2-3 are not stored" in note]
    assert subset[:2].notes == subset.notes
    assert str(subset) == "<9 orbits of period 2 to 3 at a = 1.6>"


def test_a_result_shows_its_rows_and_notes_at_the_prompt(catalogue, monkeypatch):
    table = catalogue.table(p="2-4")
    assert repr(table) == str(table)
    assert str(table).splitlines()[0].split() == list(table.columns)
    assert str(table).splitlines()[2].split()[:4] == ["3", "8", "8", "24"]
    monkeypatch.setenv("COLUMNS", "40")
    found = catalogue.lyapunov()
    *_, left_out = repr(found).splitlines()[: 2 + len(found)]
    shown = repr(found).splitlines()[0].split()
    assert [*shown, *left_out.removeprefix("and the columns ").split(", ")] == list(found.columns)
    assert max(map(len, repr(found).splitlines()[: 1 + len(found)])) <= 40


def test_a_long_result_shows_its_first_twenty_rows(catalogue):
    subset = catalogue.select(p="2-4", order="length")
    assert str(subset) == "<41 orbits of period 2 to 4 at a = 1.6>"
    title, heading, *rows, more = repr(subset).splitlines()
    assert (title, heading.split()[:2], more) == (str(subset), ["code", "p"], "... and 21 more rows")
    assert [row.split()[0] for row in rows] == subset.code[:20].tolist()
    assert repr(subset[:1]).splitlines()[2].split()[:3] == ["13", "2", "orbit"]
    births = catalogue.births(4)
    assert repr(births).splitlines()[0].startswith("representative")
    assert (type(births[1:]), births[1:][0], births[-1]) == (type(births), births[1], [*births][-1])
    assert repr(births[:0]) == "[]"


def test_several_a_are_one_table(catalogue):
    found = catalogue.table(a=[1.6, 2.0], p="2-4")
    assert found.columns["a"] == [1.6] * 3 + [2.0]  # births give the counts of period 4 only
    assert found["N_c"][:3] == catalogue.table(p="2-4")["N_c"]
    assert any(note.startswith("a = 2: ") or "at a = 2" in note for note in found.notes)
    one, both = catalogue.entropy(p="2-4"), catalogue.entropy(a=iter([1.6]), p="2-4")
    assert both["h_zeta"] == one["h_zeta"]
    with pytest.raises(InputError, match="ask for each a alone"):
        both.plot()
    with pytest.raises(InputError, match="give one a or more"):
        catalogue.lyapunov(a=[])


def test_lists_and_results_are_tables_in_notebooks(catalogue):
    shown = catalogue.field([0.02, 0.05], p=2), catalogue.info(), catalogue.sql("SELECT p FROM life")
    for found in (catalogue.fills(), catalogue.births(4), catalogue.table(), *shown):
        html = found._repr_html_()
        assert html.count("<tr>") == 1 + len(found.to_pandas())
        assert re.search("<th[^>]*>p</th>", html)
    many = Rows(catalogue.births(4)[:1] * 30)
    assert many._repr_html_().count("<tr>") == 21
    assert "and 10 more" in many._repr_html_()


def test_results_at_several_a_are_one_table(varied):
    catalogue = Catalogue(varied)
    table = catalogue.table(a=(1.0, 1.6), p="2-3")
    assert table["a"] == [1.0, 1.0, 1.6, 1.6]
    alone = [catalogue.table(a=a, p="2-3") for a in (1.0, 1.6)]
    assert list(table.rows(["p", "N_c"])) == [row for each in alone for row in each.rows(["p", "N_c"])]
    notes = catalogue.entropy(a=(1.0, 1.6), p=7).notes
    assert [note.count("at a = 1 ") or note.count("at a = 1.6 ") for note in notes] == [1, 1]


def test_an_entropy_beyond_either_bound_is_noted():
    bounds = EntropyBounds(1.6, 5, 1.0, 1.1, 1, 0)
    assert "periods 2, 4" in outside([2, 3, 4, 5], [0.9, 1.05, 1.2, None], bounds, Selection())
    assert outside([2], [0.9], bounds, Selection(contains="13")) == ""  # of some orbits


def test_averages_over_some_orbits_are_not_those_of_trajectories(varied):
    told = [Catalogue(varied, 1.6).lyapunov(p="2-4", contains=pattern) for pattern in (None, "13")]
    of_all = [
        sum("exact means" in line or "catalogue.simulate" in line for line in (*found.facts, *found.notes))
        for found in told
    ]
    assert of_all == [2, 0]
