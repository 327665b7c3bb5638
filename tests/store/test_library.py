"""The catalogue as a Python object: subsets as arrays, classes for averages, words as keys."""

import inspect
import math
import os
import pickle
import re
import shutil
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import sqlalchemy as sa
from processes import run
from same import same
from there import there

from orbitdb import Catalogue, InputError, Status, solve_word
from orbitdb.errors import SelectionError, StoreError
from orbitdb.filling.fill import fill_words
from orbitdb.selection import Selection
from orbitdb.symbols.words import least_rotation


@pytest.fixture
def catalogue(varied):
    return Catalogue(varied)


def test_the_package_is_light_until_a_name_is_used():
    code = "import sys, orbitdb; print('numpy' in sys.modules, 'sqlalchemy' in sys.modules); orbitdb.Stadium"
    code += "; print('numpy' in sys.modules, 'sqlalchemy' in sys.modules)"
    done = run(command=[sys.executable, "-P", "-c", code])
    assert done.stdout.split() == ["False", "False", "True", "False"]


def test_an_unknown_name_of_the_package_is_an_attribute_error():
    import orbitdb

    with pytest.raises(AttributeError, match="no attribute 'orbits_of_all'"):
        orbitdb.orbits_of_all  # noqa: B018
    assert set(dir(orbitdb)) >= {"Catalogue", "Stadium", "solve_word"}


def test_classes_are_orbits_by_default(varied):
    catalogue = Catalogue(varied, a=1.0)
    orbits, boundary = catalogue.classes(p=6), catalogue.classes(p=6, status="boundary")
    assert orbits.words.sum() == catalogue.count(Selection.from_criteria(a=1.0, p=6, status="orbit"))
    assert boundary.words.sum() == catalogue.count(Selection.from_criteria(a=1.0, p=6, status="boundary")) > 0
    with pytest.raises(SelectionError, match="leave out status dynamical"):
        catalogue.classes(status="dynamical")


def test_an_engine_of_sqlalchemy_reads_what_the_catalogue_counts_and_cannot_write(catalogue):
    engine = catalogue.engine
    shortest = pd.read_sql("SELECT p, count(*) AS words FROM catalogue WHERE a = 1 GROUP BY p", engine)
    assert [catalogue.count(a=1.0, p=p, status=()) for p in shortest["p"]] == shortest["words"].tolist() != []
    words = sa.Table("catalogue", sa.MetaData(), autoload_with=engine)
    query = sa.select(words.c.length).where(words.c.code == sa.func.code("310"), words.c.a == 1.0)
    with engine.connect() as connection:
        assert connection.scalar(query) == catalogue.find("310", a=1.0).length
        with pytest.raises(sa.exc.OperationalError, match="readonly"):
            connection.execute(sa.text("DELETE FROM orbit"))


@pytest.mark.parametrize("order", ["p", "length desc", "code"])
def test_coordinates_that_were_not_read_are_read_when_needed(catalogue, order):
    criteria = {"p": "2-5", "status": "orbit,dynamical,boundary", "where": "walls < 3", "order": order}
    read, later = (catalogue.select(**criteria, coordinates=now) for now in (True, False))
    assert later.coordinates is None
    later = later[::-2]
    for n, (first, second) in enumerate(zip(read[::-2], later, strict=True)):
        assert first.code == second.code
        np.testing.assert_array_equal(read[::-2].coordinates_of(n), later.coordinates_of(n))
    for one, other in zip(read[::-2].of_period(4), later.of_period(4), strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.isnan(catalogue.select(p=5, status="dynamical").coordinates_of(0)).all()


def test_a_limit_gives_the_first_entries_and_the_total(catalogue):
    every = catalogue.select(p="2-5", status="orbit", order="length desc")
    some = catalogue.select(p="2-5", status="orbit", order="length desc", limit=7)
    assert some.code.tolist() == every.code[:7].tolist()
    assert (len(some), some.total, str(some)) == (7, 121, "<7 of 121 orbits of period 2 to 5 at a = 1.6>")
    assert len(catalogue.select(p=3, limit=0)) == 0
    enough = catalogue.select(p=3, limit=8, classes=True)
    assert (len(enough), enough.total) == (2, None)
    with pytest.raises(InputError, match="limit = -1"):
        catalogue.select(limit=-1)


@pytest.mark.slow
def test_an_orbit_of_a_subset_reads_its_bounces_when_asked(catalogue):
    """Copies and images have them, too."""
    read, later = (catalogue.select(p=5, status="orbit,dynamical", coordinates=now) for now in (True, False))
    assert not same(read, later)
    assert same(later, pickle.loads(pickle.dumps(later)))
    for one, other in zip(read, later, strict=True):
        for name in ("coordinates", "points", "arclength", "sine", "monodromy"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert (one.points is None) == (one.status != "orbit")
    orbit = catalogue.select(p=5, status="orbit")[3]
    np.testing.assert_array_equal(orbit.reverse().points, orbit.points[::-1])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(orbit)).points, orbit.points)
    with pytest.raises(ValueError, match="read-only"):
        orbit.coordinates[0] = 0


@pytest.mark.parametrize(
    "ask",
    [
        lambda c: c.table(status="dynamical"),
        lambda c: c.table(Selection(time_reversal="self")),
        lambda c: c.select(parameters={"cut": 3}),
        lambda c: c.select(Selection(), p=3),
        lambda c: c.identify(points=[(0, 1), (0, -1), (1, 1)], bounces=3),
        lambda c: c.fill(code=["13"], geometric=True),
        lambda c: c.rows(p=2, offset=-5),
        lambda c: c.rows(p=2, limit=-5),
    ],
)
def test_nothing_given_is_ignored(catalogue, ask):
    with pytest.raises(InputError, match=r"only a and p|not given|not both|a start|for periods|0 or more"):
        ask(catalogue)


def test_words_are_keys_in_any_rotation(catalogue):
    assert "3123" in catalogue
    assert catalogue["3123"].coordinates.tolist() == np.roll(catalogue["1233"].coordinates, 1).tolist()
    assert catalogue["(1)^2 3"].code == "113"
    for word in ("31", "113", "12313"):  # with three different symmetries
        assert catalogue[word].symmetry == solve_word(word, 1.6).symmetry is not None
    for absent in ("1232131", "1313", "00", "9", "", 13):
        assert absent not in catalogue
    with pytest.raises(KeyError, match="1313 repeats 13: ask for the shorter word"):
        catalogue["1313"]


@pytest.mark.parametrize(("word", "status"), [("1001", "geometric"), ("1232131", "orbit"), ("20", "family")])
def test_a_word_that_is_not_stored_is_solved(catalogue, word, status):
    orbit = catalogue[word]
    assert (orbit.code, orbit.status, orbit.stored, word in catalogue) == (word, status, False, False)
    assert orbit == solve_word(word, 1.6)
    assert catalogue["001"].stored  # pruned words of three symbols are stored


def test_a_subset_is_a_sequence_of_orbits(catalogue):
    subset = catalogue.select(p="2-4", status="orbit,dynamical,geometric", coordinates=True, order="length")
    orbits = list(subset)
    assert [(orbit.code, orbit.stored) for orbit in orbits] == [(code, True) for code in subset.code]
    for orbit in (orbits[0], orbits[7], orbits[-1]):
        assert orbit == catalogue[orbit.code]
        assert orbit in subset
    assert {orbit.status for orbit in orbits} == {Status.ORBIT, Status.GEOMETRIC}
    assert orbits[-1].rules == catalogue[orbits[-1].code].rules != ()
    assert subset[-1] == subset[len(subset) - 1] == orbits[-1]
    assert [each in subset for each in ("3123", "1232131", "9", 3123)] == [True, False, False, False]


def test_parts_of_a_subset_are_subsets(catalogue):
    subset = catalogue.select(p="2-5", status="orbit", coordinates=True)
    some = subset[5:50:7]
    assert str(some) == "<7 of 121 orbits of period 2 to 5 at a = 1.6>"
    assert same(some, subset[[5, 12, 19, 26, 33, 40, 47]])
    assert same(some, subset[np.arange(121) % 7 == 5][:7])
    assert list(some) == list(subset)[5:50:7]
    np.testing.assert_array_equal(some.coordinates_of(2), subset.coordinates_of(19))
    assert some[1:][0] == some[1]
    assert str(some[1:]) == "<6 of 121 orbits of period 2 to 5 at a = 1.6>"
    assert same(subset[:], subset)
    assert same(subset[np.ones(121, bool)], subset)
    assert not same(subset, subset[1:])
    assert (len(subset[9:9]), bool(subset[9:9]), list(subset[9:9])) == (0, False, [])
    for wrong, error in (
        (121, IndexError),
        ("13", TypeError),
        (1.5, IndexError),
        (np.ones(3, bool), IndexError),
    ):
        with pytest.raises(error):
            subset[wrong]


@pytest.mark.slow
def test_data_frames_and_arrow_tables_equal_an_export(varied, catalogue, cli, tmp_path):
    from pyarrow import parquet

    subset = catalogue.select(p=3, status="orbit,geometric", coordinates=True)
    chosen = ("--p", "3", "--status", "orbit,geometric", "-c", "+coordinates", "--db", str(varied))
    assert cli("export", str(tmp_path / "x.parquet"), *chosen).code == 0
    exported = parquet.read_table(tmp_path / "x.parquet")
    frame, table = subset.to_pandas(), subset.to_arrow()
    written = [name for name in exported.column_names if name != "coordinates"]
    assert list(frame)[: len(written)] == written
    for name in exported.column_names:
        assert table[name].type == exported[name].type
        known = [value for value in exported[name].to_pylist() if value is not None]
        values = frame[name].dropna()
        if name == "area_slope":  # computed for other batches of words, which are rounded otherwise
            assert values.tolist() == pytest.approx(known, rel=1e-13)
            continue
        assert table[name].to_pylist() == exported[name].to_pylist(), name
        assert [list(v) if name in ("coordinates", "rules") else v for v in values] == known, name
    assert (frame["code"].dtype, frame["class_size"].dtype, frame["p"].dtype) == ("string", "Int64", "int64")
    assert frame.attrs["selection"] == subset.selection.describe()


@pytest.mark.slow
def test_missing_values_of_a_row_are_missing_in_a_data_frame(catalogue):
    frame = catalogue.select(p=3, status="orbit,geometric").to_pandas()
    assert frame["symmetry"].isna().tolist() == (frame["status"] != "orbit").tolist()
    assert frame["symmetry"].notna().any()
    assert catalogue.select(p=3, status="geometric").to_pandas()["symmetry"].dtype == "string"


def test_a_missing_library_is_named_with_its_extra(catalogue, monkeypatch):
    subset = catalogue.select(p=3)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ModuleNotFoundError, match=r"to_pandas\(\) needs pandas: pip install 'orbitdb"):
        subset.to_pandas()
    monkeypatch.setitem(sys.modules, "matplotlib.axes", None)
    monkeypatch.delitem(sys.modules, "orbitdb.plots.paths", raising=False)
    with pytest.raises(ModuleNotFoundError, match=r"plot\(\) needs matplotlib: pip install 'orbitdb\[plot\]"):
        subset.plot("lengths")


def test_a_notebook_shows_a_subset_as_a_table_with_pictures(catalogue):
    subset = catalogue.select(p="3-4", order="length")
    html = subset._repr_html_()
    assert html.count("<svg") == 10
    assert f"and {len(subset) - 10} more" in html
    table = ElementTree.fromstring(f"<div>{html}</div>").find("table/tbody")  # every element must be closed
    texts = ["013", "3", "orbit", "10.8506847", "4.3928510", "1.464284", "0.404846", "4", "xT"]
    assert [cell.text for cell in there(table)[0]][1:] == texts
    left = [cell.text for cell in there(table)[0] if cell.get("style") == "text-align: left"]
    assert left == ["013", "orbit", "xT"]  # numbers on the right, as notebooks do by themselves
    read = catalogue.select(p="3-4", order="length", coordinates=True)._repr_html_()
    assert html.replace("-0.00", "0.00") == read.replace("-0.00", "0.00")
    odd = replace(subset[:1], symmetry=np.array(["<script>"], subset.symmetry.dtype))
    assert "&lt;script&gt;" in odd._repr_html_()
    assert "<svg" not in catalogue.select(p=3, status="geometric")._repr_html_()
    nothing = catalogue.select(p=3, status="orbit", length=(99, None))._repr_html_()
    assert nothing == "<p>0 orbits of period 3 at a = 1.6 with length &gt;= 99</p>"


def test_a_notebook_solves_only_orbits_it_draws(catalogue, tmp_path, monkeypatch):
    path = tmp_path / "long.db"
    Catalogue.create(path)
    for rest in ("11", "113"):
        fill_words(path, ["13" * 99 + rest], 1.6)
    assert Catalogue(path).select(p=200)._repr_html_().count("<svg") == 4
    monkeypatch.setattr("orbitdb.orbits.solve.solve_word", None)
    assert "<svg" not in Catalogue(path).select(p=201)._repr_html_()
    assert "<svg" not in catalogue.select(p=5, status="dynamical")._repr_html_()
    assert "<svg" in catalogue.select(p=3, status="orbit", coordinates=True)._repr_html_()


def test_the_repr_of_a_catalogue_states_its_periods(varied, begin_fill, tmp_path):
    with Catalogue(varied, a=1.0) as catalogue:
        assert repr(catalogue) == "<Catalogue orbits.db: periods 2-6 at a = 1; periods 2-6 at a = 1.6>"
        assert catalogue.fills() == catalogue.fills(a=1.0) != []
        assert catalogue.find("13") == catalogue["13"]
        assert next(iter(catalogue.rows(p=2, columns=("a", "code")))) == (1.0, "13")
    assert repr(Catalogue(varied, a=0.3)).startswith(
        "<Catalogue orbits.db: no complete period at a = 0.3; periods 2"
    )
    path = tmp_path / "new.db"
    with Catalogue.create(path) as catalogue:
        assert repr(catalogue) == "<Catalogue new.db: no complete period at a = 1.6>"
        begin_fill(path, 9, a=0.5).close()
        assert repr(catalogue) == "<Catalogue new.db: part of period 9 at a = 0.5>"
    path.unlink()
    assert "no catalogue at" in repr(catalogue) or "cannot be" in repr(catalogue)


def test_criteria_are_named_parameters_for_completion():
    for method in (Catalogue.select, Catalogue.classes, Catalogue.count, Catalogue.rows):
        assert {"p", "status", "where", "length", "margin"} < set(inspect.signature(method).parameters)


def test_iteration_length_and_membership_agree(varied):
    catalogue = Catalogue(varied, a=1.0)
    words = list(catalogue)
    assert len(words) == len(set(words)) == len(catalogue) == catalogue.count(status="orbit")
    assert catalogue.count(status=()) == 1 + 8 + 32 + 96 + 252 > len(words)
    assert all(least_rotation(word) == word for word in words)
    assert all(word in catalogue for word in words[::9])  # each test is a query


def test_a_catalogue_is_pickled_as_its_path_and_a(varied, tmp_path):
    path = shutil.copy(varied, tmp_path / "orbits.db")
    catalogue = Catalogue(path, a=1.0)
    again = pickle.loads(pickle.dumps(catalogue))
    assert (again.path, again.a, len(again)) == (catalogue.path, 1.0, len(Catalogue(path, a=1.0)))
    os.remove(path)
    with pytest.raises(StoreError, match="no catalogue"):
        pickle.loads(pickle.dumps(again))


def test_a_catalogue_uses_its_own_a_by_default(varied):
    at_one = Catalogue(varied, a=1.0)
    assert at_one["13"].length == pytest.approx(8, rel=1e-15)
    assert at_one.select(p=2).selection.a == 1.0
    assert at_one.select(p=2, a=1.6).length.tolist() == [10.4]
    assert at_one["111333"].status is Status.BOUNDARY
    empty = Catalogue(varied, a=0.3)
    assert (len(empty), bool(empty), "13" in empty) == (0, True, False)


def test_criteria_make_a_selection():
    assert Selection.from_criteria(
        a=2.0, p="2-4", status="orbit", contains="02", margin=(None, 0.1)
    ) == Selection(
        a=2.0, periods=((2, 4),), statuses=(Status.ORBIT,), contains="02", ranges={"margin": (None, 0.1)}
    )
    several = Selection.from_criteria(p=[2, 3, 5], status=["orbit", Status.BOUNDARY])
    assert several == Selection.from_criteria(p="2,3,5", status="orbit,boundary")
    assert Selection.from_criteria(p=range(2, 5)) == Selection.from_criteria(p="2-4")
    assert (
        Selection.from_criteria(p=(2, 4))
        == Selection.from_criteria(p=[2, 4])
        == Selection.from_criteria(p="2,4")
    )
    assert Selection.from_criteria(length=None, lambda_c=(None, None)) == Selection(statuses=(Status.ORBIT,))


@pytest.mark.parametrize("status", ["orbit", "geometric", "dynamical", "boundary", "unresolved", "all"])
def test_descriptions_use_singular_and_plural(status):
    chosen = Selection.from_criteria(a=1.6, status=status, time_reversal="self", exists=(1,))
    one, two = (chosen.describe(count=count).split(" at a = ", 1)[0] for count in (1, 2))
    assert re.fullmatch(r"1 .*(orbit|word|through a joint)", one)
    assert two == "2" + re.sub(r"\b(orbit|word)\b", r"\1s", one)[1:]


def test_descriptions_leave_out_empty_ranges_and_shorten_long_words(catalogue):
    subset = catalogue.select(p=2, status="orbit", length=(None, None))
    assert str(subset) == "<1 orbit of period 2 at a = 1.6>"
    assert Selection(ranges={"length": (None, None)}).describe() == "words at a = 1.6"
    for word, shown in (("13" * 30, "13" * 30), ("13" * 31, "13" * 28 + "1...")):
        assert Selection.from_criteria(p=80, contains=word).describe().endswith(f" containing {shown}")
    assert {*Selection.from_criteria(status="all").statuses} == {*Status} - {Status.FAMILY}
    several = Selection.from_criteria(
        p="2,4-5", status="orbit", time_reversal="self", symmetry="x", contains="13"
    )
    assert several.describe([1.0, 1.6]) == (
        "orbits of period 2, 4 to 5 at a = 1, 1.6 that retrace their path with symmetry x containing 13"
    )


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"colour": (1, 2)}, "criteria are a, p, status, time_reversal, .*, length, .*, lyapunov"),
        (
            {"reversal": "self"},
            "reversal: not a criterion; did you mean time_reversal\\? criteria are a, p, status",
        ),
        ({"range": "length=3:"}, "range: not a criterion; criteria are"),
        ({"status": "good"}, "use orbit, geometric, dynamical, boundary, unresolved, some of them"),
        ({"status": "orbit,family"}, r"never stored: `catalogue\.orbit\('02'\)` describes it"),
        ({"status": Status.FAMILY}, "never stored"),
        ({"symmetry": "T,xT"}, "the smallest group that contains it is x,T,xT$"),
        ({"symmetry": "yT, xT"}, "'yT, xT' is not a group: .* is xy,xT,yT$"),
        ({"status": [""]}, "status"),
        ({"p": "4-2"}, "run backwards: write 2-4"),
        ({"p": "2-1"}, "run backwards: the least period is 2"),
        ({"p": "x"}, "2-8"),
        ({"p": range(3, 3)}, "periods"),
        ({"length": (math.nan, 3)}, "give two numbers"),
        ({"length": (9, 5)}, r"backwards: give \(5, 9\)"),
        ({"length": (0, 10**400)}, "too large"),
        ({"exists": [1 + n / 100 for n in range(101)]}, "exists: 101 values, more than 100"),
        ({"where": "p > 2", "parameters": {"1": 3}}, "'1' is not a name"),
        ({"where": " P "}, "it is a column, not a condition"),
    ],
    ids=str,
)
def test_wrong_criteria_are_refused(catalogue, wrong, said):
    with pytest.raises(SelectionError, match=said):
        catalogue.select(**wrong)


def test_other_libraries_read_a_subset_through_arrow(varied):
    import pyarrow

    subset = Catalogue(varied).select(a=1.6, p="2-4", status="orbit")
    read = pyarrow.table(subset)
    assert read.equals(subset.to_arrow())
    assert read["code"].to_pylist() == subset.code.tolist()


def test_births_of_an_impossible_period_are_refused(filled):
    catalogue = Catalogue(filled)
    for p in (1, 50, -3):
        with pytest.raises(InputError, match=f"^period {p}: the"):
            catalogue.births(p)
    assert catalogue.births(3) == []
