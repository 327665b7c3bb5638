"""Rows and counts that are found class first are those of a pass over the view."""

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st
from quick import slow_but

from orbitdb.filling.blocks import METHODS, Method
from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.orbits.newton import solve
from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.criteria import choose
from orbitdb.store.asking.selection import SelectionError
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading import class_first, counted_words, first_rows, fitting_words, places, reader
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.class_view import class_part

NAMES = ("code", "p", "status", "length", "lambda_c", "rules")
ORDERS = ("p,code", "length", "length desc,code", "lambda_c", "-p,length", "status,length", "code",
          "margin desc", "class_size desc,lyapunov", "element,word", "-code", "element desc,length",
          "time_reversal,lambda_c desc", "lambda_c,status", "-p,status,code", "walls,margin")  # fmt: skip
WHERE = ("lambda_c < 0.5", "length is null", "class_size = 2 or margin < 0.1", "p % 2", "word like '1%'",
         "element = 3", "element & 1 and length > 9", "word > '02' and (p = 4 or length > 9) AND margin > 0",
         "element between 1 and 3 and length > 9", "code like '%31' or length > 9 and p > 3",
         "code like '%13%'", "margin > 0 and word not glob '?1*3' AND code like '%1%'",
         "not code like '1_3%'",
         "representative = word", "status = 'geometric'", "upper(margin is not null) < p")  # fmt: skip

choices = st.fixed_dictionaries(
    {},
    optional={
        "a": st.sampled_from([1.6, 1.0, 2.0]),
        "p": st.sampled_from(["2", "3", "3-5", "6,12", "7", "2-30"]),
        "status": st.sampled_from(["orbit", "dynamical,orbit", "geometric", "boundary", "all"]),
        "time_reversal": st.sampled_from(["self", "pair"]),
        "symmetry": st.sampled_from(["1", "T", "x,T,xT"]),
        "contains": st.sampled_from(["13", "44", "131013", "31202131"]),
        "length": st.tuples(st.none() | st.just(11.0), st.none() | st.just(14.0)),
        "where": st.sampled_from(WHERE),
    },
)
limits = st.none() | st.integers(0, 40)


@pytest.fixture(autouse=True, scope="module")
def in_every_catalogue():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(class_first, "_MANY", 0)
        yield


@pytest.fixture(scope="module")
def ragged(varied, tmp_path_factory):
    """The varied catalogue with half a period more, and a long word of another one."""
    path = tmp_path_factory.mktemp("ragged") / "orbits.db"
    path.write_bytes(varied.read_bytes())
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(METHODS, "newton", Method(solve, 64))
        going = fill_periods(path, 1.6, [7])
        for _ in range(4):
            next(going)
        going.close()
    fill_word(path, "1" * 20 + "3", 1.6)
    fill_word(path, "1001", 1.6)
    return path


SUBSETS = (
    {"p": "4-6"},
    {"p": "4-6", "status": "orbit"},
    {"p": "5-6", "where": "element & 1 and length > 9"},
    {"p": "2-6", "status": "orbit,geometric,dynamical"},
    {"p": "4-6", "contains": "13", "status": "orbit"},
    {"a": 1.0, "p": "4-6", "time_reversal": "pair"},
)
SLICES = ((4, 0), (3, 1), (2, 77), (4, 230))


@pytest.mark.parametrize("first", slow_but([1], [0, 1]))
@pytest.mark.parametrize("shift", slow_but([4], range(len(SUBSETS))))
def test_the_first_rows_and_those_far_behind_are_slices_of_a_pass(varied, monkeypatch, shift, first):
    """In every other order, of a subset or two; what is counted by classes is as many."""
    catalogue = Catalogue(varied)
    for number, order in [*enumerate(ORDERS)][first::2]:
        selection = choose(**SUBSETS[(number + shift) % len(SUBSETS)])
        with monkeypatch.context() as patch:
            patch.setattr(reader, "place_of", lambda *_: None)
            expected = list(catalogue.rows(selection, NAMES, order))
        assert catalogue.count(selection) == len(expected)
        with monkeypatch.context() as patch:
            patch.setattr(first_rows, "_STEPS", (8, 40))
            patch.setattr(first_rows, "_LOOKUPS", 30)
            patch.setattr(class_first, "_FEW", 2)
            for room in (first_rows, places):
                patch.setattr(room, "MOST", 4)
            for limit, offset in SLICES[number % 2 :: 2]:
                rows = list(catalogue.rows(selection, NAMES, order, limit, offset))
                assert rows == expected[offset : offset + limit], (selection, order, limit, offset)


@pytest.mark.slow
@pytest.mark.parametrize("most", [4, 2000])
@given(
    chosen=choices,
    order=st.sampled_from(ORDERS),
    limit=limits,
    offset=st.integers(0, 5) | st.integers(0, 400),
)
def test_rows_are_those_of_a_pass(ragged, varied, most, chosen, order, limit, offset):
    selection = choose(**chosen)
    for catalogue in (Catalogue(ragged), Catalogue(varied)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(first_rows, "_STEPS", (most // 4, most))
            for room in (first_rows, places):
                patch.setattr(room, "MOST", most)
            patch.setattr(class_first, "_FEW", most // 2)
            patch.setattr(counted_words, "_PIECE", 5)
            patch.setattr(fitting_words, "_BATCH", 7)
            found = list(catalogue.rows(selection, NAMES, order, limit, offset))
            patch.setattr(reader, "place_of", lambda *_: None)
            assert found == list(catalogue.rows(selection, NAMES, order, limit, offset))


@pytest.mark.parametrize(
    "order", slow_but(["length desc", "-lambda_c,p", "rules"], ["length", "length desc", "-lambda_c,p",
                                                                "margin,length", "rules"])
)  # fmt: skip
@pytest.mark.parametrize("limit", slow_but([None, 3], [None, 3, 2000]))
def test_rows_without_a_value_are_last(ragged, order, limit):
    rows = list(Catalogue(ragged).rows(choose(), (order.lstrip("-").split(",")[0].split()[0],), order, limit))
    empty = [value is None for (value,) in rows]
    assert empty == sorted(empty)
    assert limit != 3 or not any(empty)


@given(choices)
@pytest.mark.slow
def test_counts_are_those_of_a_pass(ragged, chosen):
    selection, catalogue = choose(**chosen), Catalogue(ragged)
    with catalogue.reading() as connection, answering(connection, selection, Patience()):
        query = sa.select(sa.func.count()).select_from(view).where(*conditions_of(selection))
        assert catalogue.count(selection) == connection.scalar(query)


@pytest.mark.parametrize(
    ("chosen", "order", "wanted"),
    [
        ({"where": "lambda_c < 0.35", "p": "2-6"}, "p,code", None),
        ({"status": "orbit"}, "length", 10),
        ({"status": "orbit"}, "lambda_c desc", 30),
        ({"length": (None, 12.0)}, "code", 5),
    ],
)
def test_what_is_of_few_classes_needs_no_pass(filled, monkeypatch, chosen, order, wanted):
    monkeypatch.setattr(class_first, "_FEW", 30)
    with Catalogue(filled).reading() as connection:
        words = class_first.few_words(connection, choose(**chosen), order, wanted, Patience())
    assert words is not None
    assert len(words) <= 8 * 30


@pytest.mark.parametrize(
    ("chosen", "order", "limit", "offset", "words"),
    [
        ({"contains": "13"}, "p,code", 3, 40, 3),
        ({"where": "code like '%31' and margin > 0"}, "p,code", 2, 0, 2),
        ({"contains": "0101"}, "length", None, 0, 0),
        ({"status": "orbit"}, "p,code", 3, 100, 3),
    ],
)
def test_what_patterns_ask_of_words_needs_no_pass(filled, monkeypatch, chosen, order, limit, offset, words):
    monkeypatch.setattr(places, "MOST", 4)
    monkeypatch.setattr(first_rows.Asked, "rows", None)  # it asks the view
    with Catalogue(filled).reading() as connection:
        place = places.place_of(connection, choose(**chosen), order, limit, offset, Patience())
    assert place is not None
    assert (len(place.words), place.before) == (words, offset)
    assert Catalogue(filled).count(choose(**chosen)) >= words


def test_what_is_of_many_classes_needs_one(filled, monkeypatch):
    monkeypatch.setattr(class_first, "_FEW", 30)
    with Catalogue(filled).reading() as connection:
        assert class_first.few_words(connection, choose(), "element", 10, Patience()) is None
        assert class_first.few_words(connection, choose(status="orbit"), "length", 31, Patience()) is None


def test_a_small_catalogue_needs_a_pass(filled, monkeypatch):
    words = Catalogue(filled).count()
    for many in (words, words + 1):
        monkeypatch.setattr(class_first, "_MANY", many)
        with Catalogue(filled).reading() as connection:
            found = class_first.few_words(connection, choose(status="orbit"), "length", 3, Patience())
        assert (found is None) == (many > words)


def test_bad_expressions_are_refused(filled):
    for where in ("lambda_c <", "nothing = 3", "word = (SELECT word FROM sequence)", "randomblob(9) > 1",
                  "p in (SELECT p FROM catalogue WHERE p in (SELECT 3))"):  # fmt: skip
        for ask in (Catalogue(filled).count, lambda chosen: list(Catalogue(filled).rows(chosen))):
            with pytest.raises(SelectionError):
                ask(choose(where=where))


def test_pruned_words_of_a_period_in_the_making_count_once(tmp_path):
    path = tmp_path / "orbits.db"
    Catalogue.create(path)
    for _ in fill_geometric(path, [3]):
        pass
    going = fill_periods(path, 1.6, [3])
    next(step for step in going if step.words)
    going.close()  # all its words are stored, but not that these are all
    catalogue = Catalogue(path)
    assert catalogue.count(choose()) == len(list(catalogue.rows(choose(), ("code",)))) == 70


@pytest.mark.parametrize(
    ("where", "kept"),
    [
        ("element = 3 and lambda_c < :cut", "(\nlambda_c < :cut\n)"),
        ("word like 'a and b' and (p > 3 and element) and margin > 0", "(\nmargin > 0\n)"),
        ("element = 3 or lambda_c < :cut", None),
        ("length between element and 9", None),
        ("not length > 9 and element = 3", "(\nnot length > 9\n)"),
    ],
)
def test_what_classes_fulfil_of_an_expression(where, kept):
    given = {"cut": 0.38} if ":cut" in where else {}
    part = class_part(choose(where=where, parameters=given, contains="13", status="orbit"))
    assert part.contains is None
    assert (part.where and part.where.replace(" \n", "\n").replace("\n ", "\n")) == kept
    assert part.parameters == (given if kept and ":cut" in kept else {})
