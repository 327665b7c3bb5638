"""Pages by key: the same rows in the same order as the catalogue gives them."""

import contextlib
import sqlite3
from collections import Counter

import numpy as np
import pytest
import sqlalchemy as sa
from quick import slow_but

from orbitdb.errors import StoreError
from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import certificate, cycle
from orbitdb.store.reading import (
    class_index,
    class_values,
    fitting_words,
    index_reading,
    ordered,
    pages,
    pattern_places,
    period_words,
    text_order,
    word_conditions,
)
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.index_reading import load_index
from orbitdb.store.reading.pages import CancelledError, certificate_of, chosen_keys, fetch
from orbitdb.store.reading.period_words import HEAD, ListedWords, expand
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import admissible_words
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import keys, keys_of_period, pack, to_strings

SELECTIONS = [
    Selection(),
    Selection(statuses=(Status.ORBIT,)),
    Selection(statuses=(Status.GEOMETRIC, Status.DYNAMICAL)),
    Selection(time_reversal="self"),
    Selection(periods=((3, 4), (6, 6)), symmetry="1"),
    Selection(periods=((3, 4),)),
    Selection(ranges={"length": (12.0, 20.0), "lambda_c": (None, 0.45)}),
    Selection(contains="13", time_reversal="pair"),
    Selection(where="lambda_c < 0.42 and p > 4"),
    Selection(where="length is null or p = 3"),
    Selection(where="p > (select min(p) + 1 from catalogue)"),
    Selection(where="code like '%13%'"),
    Selection(where="length(code) > 4 or code like '1%'"),
    Selection(where="margin > 0 and code not like :end", parameters={"end": "%_31"}, contains="13"),
    Selection(a=1.0),
    Selection(a=7.0),
]
COLUMNS = ("p", "code", "length", "lambda_d", "status", "symmetry", "representative", "rules", "element")
LONG = "1" * 25 + "3"


@pytest.fixture(scope="module")
def catalogues(tmp_path_factory):
    """Return a plain catalogue, and one that also has pruned words and two long ones, one of them pruned."""
    folder = tmp_path_factory.mktemp("pages")
    Catalogue.create(folder / "plain.db")
    for a, highest in ((1.6, 6), (1.0, 5)):
        for _ in fill_periods(folder / "plain.db", a, range(2, highest + 1)):
            pass
    (folder / "mixed.db").write_bytes((folder / "plain.db").read_bytes())
    for _ in fill_geometric(folder / "mixed.db", range(2, 5)):
        pass
    for word in (LONG, "1" * 23 + "00"):
        fill_word(folder / "mixed.db", word, 1.6)
    return [Catalogue(folder / name) for name in ("plain.db", "mixed.db")]


PAIRS = [  # every column with one selection, and every selection with one column
    *((SELECTIONS[6], column) for column in COLUMNS),
    *zip(SELECTIONS, COLUMNS + COLUMNS, strict=False),
]


@pytest.mark.parametrize(
    ("selection", "column"),
    [pytest.param(*pair, marks=pytest.mark.slow if i % 2 else []) for i, pair in enumerate(PAIRS)],
    ids=lambda value: value if isinstance(value, str) else value.describe(),
)
@pytest.mark.slow
def test_keys_have_the_order_of_the_catalogue(catalogues, selection, column):
    for catalogue in catalogues:
        index = load_index(catalogue, selection.a)
        for descending in (False, True):
            keys = chosen_keys(catalogue, index, selection, column, descending)
            order = f"{column} {'desc' if descending else 'asc'}"
            rows = catalogue.rows(selection, ("code",), order)
            assert [index.word(key) for key in keys[:].tolist()] == [code for (code,) in rows]


def test_a_page_is_what_the_catalogue_has_there(catalogues):
    catalogue = catalogues[1]
    index = load_index(catalogue, 1.6)
    columns = ("code", "p", "status", "length", "rules")
    for order, descending in (("p", False), ("lyapunov", True)):
        keys = chosen_keys(catalogue, index, Selection(), order, descending)
        rows = list(
            catalogue.rows(Selection(), columns, f"{order} {'desc' if descending else 'asc'}", 40, 150)
        )
        assert fetch(catalogue, index, keys[150:190], columns) == rows


def test_a_word_is_found_where_it_stands(catalogues):
    catalogue = catalogues[1]
    index = load_index(catalogue, 1.6)
    keys = chosen_keys(catalogue, index, Selection(), "length")
    for word in ("13", "0132", LONG):
        place = keys.position(word)
        assert place is not None
        assert index.word(int(keys[place : place + 1][0])) == word
    assert keys.position("1213131") is None
    assert keys.position("1" * 30 + "3") is None


def test_a_row_that_has_gone_is_none(catalogues):
    index = load_index(catalogues[1], 1.6)
    other = np.array([int("1010101", 8)])
    assert fetch(catalogues[1], index, other, ("code",)) == [None]


def test_a_bad_filter_is_refused(catalogues):
    index = load_index(catalogues[0], 1.6)
    with pytest.raises(SelectionError, match="lenght"):
        chosen_keys(catalogues[0], index, Selection(where="lenght > 3"))


def test_nobody_waits(catalogues):
    index = load_index(catalogues[0], 1.6)
    for selection in (Selection(), Selection(where="p > 2"), Selection(where="code like '1%'")):
        with pytest.raises(CancelledError):
            chosen_keys(catalogues[0], index, selection, cancelled=lambda: True)


def test_filters_that_hold_for_classes_are_answered_from_them(catalogues, monkeypatch):
    monkeypatch.setattr("orbitdb.store.reading.pages._scanned", None)  # a pass over all words takes minutes
    index = load_index(catalogues[1], 1.6)
    chosen = Selection(where="lambda_c < 0.42 and p > 4", time_reversal="pair")
    assert len(chosen_keys(catalogues[1], index, chosen)) == catalogues[1].count(chosen) > 0


def test_filters_on_texts_are_answered_from_classes(catalogues, monkeypatch):
    for way in ("_scanned", "chosen_words"):
        monkeypatch.setattr(f"orbitdb.store.reading.pages.{way}", None)  # they ask for every word
    index = load_index(catalogues[1], 1.6)
    chosen = Selection(where="margin > 0 and code not like '%0%'", contains="13")
    assert len(chosen_keys(catalogues[1], index, chosen)) == catalogues[1].count(chosen) > 0


def test_a_factor_chooses_words_and_not_whole_classes(catalogues):
    index, chosen = load_index(catalogues[0], 1.6), Selection(contains="321")
    for column, descending in (("length", True), ("code", False)):
        keys = chosen_keys(catalogues[0], index, chosen, column, descending)
        order = f"{column} desc" if descending else column
        words = [code for (code,) in catalogues[0].rows(chosen, ("code",), order)]
        assert [index.word(key) for key in keys[:].tolist()] == words
    assert 0 < len(words) < len(catalogues[0].select(p="4-6")) / 2


def test_a_certificate_is_read_by_its_class(catalogues):
    catalogue = catalogues[0]
    assert certificate_of(catalogue, "013", 1.6) is None
    writer = Writer(catalogue.path, {"command": "test"})
    with writer.writing() as connection:
        number = connection.scalar(sa.select(cycle.c.id).where(cycle.c.word == "013"))
        row = {"stadium": writer.stadium_id(connection, 1.6), "cycle": number, "radius": 1e-30, "bits": 128}
        connection.execute(sa.insert(certificate).values(**row, version="1", run=writer.run_id(connection)))
    writer.close()
    assert certificate_of(catalogue, "013", 1.6) == (1e-30, 128)
    assert certificate_of(catalogue, "013", 1.0) is None


@pytest.mark.slow
def test_empty_fields_are_last_whichever_way_the_order_goes(catalogues):
    for catalogue in catalogues:
        index = load_index(catalogue, 1.6)
        for column in ("length", "lambda_c", "symmetry", "rules", "element"):
            for descending in (False, True):
                keys = chosen_keys(catalogue, index, Selection(), column, descending)
                empty = [row[1] is None for row in fetch(catalogue, index, keys[:], ("code", column))]
                assert empty == sorted(empty)


def in_small_pieces(monkeypatch):
    """Let a small catalogue go the ways of a large one: what is cut into pieces there is cut here, too."""
    for module, sizes in (
        (period_words, {"_PIECE": 100, "_BATCH": 16}),
        (index_reading, {"PIECE": 24}),
        (class_index, {"_PIECE": 50, "_FEW": 8}),
        (class_values, {"_PIECE": 30}),
        (word_conditions, {"_PIECE": 70}),
        (pattern_places, {"_PIECE": 70}),
        (fitting_words, {"_BATCH": 16}),
        (text_order, {"_PIECE": 60}),
        (pages, {"_PIECE": 50}),
        (ordered, {"_PIECE": 64, "_BLOCK": 16, "_LARGE": 20, "_MOST_LARGE": 3}),
    ):
        for name, size in sizes.items():
            monkeypatch.setattr(module, name, size)


@pytest.mark.parametrize(
    ("selection", "column", "descending"),
    [
        pytest.param(Selection(), "p", True, marks=pytest.mark.slow),
        (Selection(statuses=(Status.ORBIT, Status.GEOMETRIC)), "symmetry", True),
        (
            Selection(periods=((5, 6),), where="margin > -1 and code like '%13%'", contains="3"),
            "lambda_c",
            False,
        ),
        pytest.param(Selection(where="code like '%1_' or p = 3"), "length", False, marks=pytest.mark.slow),
        pytest.param(Selection(), "p", False, marks=pytest.mark.slow),
        pytest.param(Selection(periods=((2, 5),)), "length", False, marks=pytest.mark.slow),
        (Selection(where="margin > -0.5"), "code", True),
        pytest.param(Selection(contains="21", time_reversal="pair"), "code", False, marks=pytest.mark.slow),
    ],
    ids=lambda value: value.describe() if isinstance(value, Selection) else str(value),
)
def test_what_is_cut_into_pieces_has_the_same_order(catalogues, monkeypatch, selection, column, descending):
    in_small_pieces(monkeypatch)
    for catalogue in catalogues:
        index = load_index(catalogue, 1.6)
        chosen_keys(catalogue, index, Selection(), column)  # its values are kept
        keys = chosen_keys(catalogue, index, selection, column, descending)
        order = f"{column} {'desc' if descending else 'asc'}"
        words = [word for (word,) in catalogue.rows(selection, ("code",), order)]
        pages = [keys[start : start + 37].tolist() for start in range(0, len(keys), 37)]
        assert [index.word(key) for page in pages for key in page] == words
        for row in range(0, len(words), 101):
            assert keys.position(words[row]) == row
        low, high = keys_of_period(4)
        first = next((row for row, word in enumerate(words) if len(word) == 4), None)
        assert keys.first_within([(low, high)]) == first
        sizes = keys.words_of_classes()
        assert sizes.sum() == len(words)
        assert (sizes <= index.sizes).all()


HOLES = ((3, 3), (6, 6))
"""Periods with others between, of which all pieces are passed over."""

IN_HOLES = [
    (Selection(periods=HOLES), "length", False),
    (Selection(statuses=(Status.ORBIT,)), "class_size", True),
    (Selection(), "margin", True),
    (Selection(where="representative = '111113'"), "length", False),
    (Selection(periods=HOLES), "code", False),
    (Selection(periods=HOLES, where="upper(code) < '2'"), "p", False),
]
MORE_HOLES = [
    *((Selection(periods=HOLES), column, True) for column in (*COLUMNS, "margin", "code", "walls")),
    (Selection(periods=HOLES, where="code like '%1_'"), "lambda_c", True),
    (Selection(periods=HOLES, where="substr(code, 2, 1) = '3'"), "code", True),
    (Selection(periods=((4, 5),), where="element + p > 6"), "length", True),
]


@pytest.mark.parametrize("asked", [IN_HOLES, pytest.param(MORE_HOLES, marks=pytest.mark.slow)])
def test_rows_are_found_wherever_they_stand(catalogues, monkeypatch, asked):
    """By their words, their periods and their classes, as a search through all of them finds them."""
    in_small_pieces(monkeypatch)
    catalogue = catalogues[0]
    index = load_index(catalogue, 1.6)
    periods = [keys_of_period(p) for p in range(2, 7)]
    first = periods[-1][0]
    begun = [(first + (1 << 15), first + (2 << 15)), (first + (3 << 15), first + (4 << 15))]  # 1 and 3
    spans = [*([each] for each in periods), [periods[4], periods[1]], begun, begun[:1], []]
    for selection, column, descending in asked:
        keys = chosen_keys(catalogue, index, selection, column, descending)
        order = f"{column} {'desc' if descending else 'asc'}"
        rows = list(catalogue.rows(selection, ("code", "representative"), order))
        numbers = [index.key(word) for word, _ in rows]
        assert keys[:].tolist() == numbers
        assert [keys[k : k + 2].tolist() for k in (0, 20, len(rows) - 1, len(rows), len(rows) + 9)] == [
            numbers[k : k + 2] for k in (0, 20, len(rows) - 1, len(rows), len(rows) + 9)
        ]
        assert len(keys[3:3]) == len(keys[4:3]) == 0
        for words in spans:
            inside = (k for k, n in enumerate(numbers) if any(low <= n < high for low, high in words))
            assert keys.first_within(words) == next(inside, None), (order, words)
        for row in {0, 1, 2, *range(0, len(rows), 41)}:
            assert keys.position(rows[row][0]) == row
        chosen = {word for word, _ in rows}
        others = (index.word(key) for key in index.keys(np.arange(0, len(index), 29)).tolist())
        for word in ("0", "1213131", "5" * 40, *(word for word in others if word not in chosen)):
            assert keys.position(word) is None
        sizes = {
            index.word(int(n)): k for n, k in zip(index.numbers, keys.words_of_classes(), strict=True) if k
        }
        assert sizes == Counter(least for _, least in rows)


def test_words_that_are_not_all_of_their_classes_are_listed(catalogues, tmp_path):
    """As while a period is filled for the first time: its last words are not there yet."""
    path = tmp_path / "ragged.db"
    path.write_bytes(catalogues[0].path.read_bytes())
    with contextlib.closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("DELETE FROM sequence WHERE p = 6 AND word > '0303'")
    catalogue = Catalogue(path)
    index = load_index(catalogue, 1.6)
    whole = load_index(catalogues[0], 1.6)
    assert isinstance(index.parts[-1].words, ListedWords)
    assert len(index) < len(whole)
    for column in ("p", "length", "code", "representative", "cycle", "status"):
        keys = chosen_keys(catalogue, index, Selection(), column)
        rows = catalogue.rows(Selection(), ("code",), column)
        assert [index.word(key) for key in keys[:].tolist()] == [code for (code,) in rows]
    kept = {part.words.p: part for part in index.parts[:-1]}
    assert load_index(catalogues[0], 1.6, kept) == whole


@pytest.mark.parametrize("p", slow_but([5, 7], [5, 7, 9]))
def test_words_of_classes_come_in_their_order(p):
    words = np.concatenate(list(admissible_words(p)))
    classes = classify(words)
    least = np.unique(classes.representative)
    found = expand(keys(least, p), p)
    assert found.keys(slice(None)).tolist() == keys(pack(words), p).tolist()
    assert least[found.classes(slice(None))].tolist() == classes.representative.tolist()
    assert (found.entries & 7).tolist() == classes.element.tolist()
    assert [found.lower(key) for key in found.keys(slice(0, 9)).tolist()] == list(range(9))
    heads = [text[:HEAD].ljust(HEAD, "0") for text in to_strings(words)]
    assert [f"{head:0{HEAD}o}" for head in found.heads.tolist()] == sorted(set(heads))
    assert found.head_starts.tolist() == [heads.index(head) for head in sorted(set(heads))]


def test_an_impossible_status_is_told_with_its_period(filled):
    fill_word(filled, "131313131132", 1.6)  # its number has fewer digits than its word
    with contextlib.closing(sqlite3.connect(filled)) as plain, plain:
        plain.execute("UPDATE orbit SET status = 'odd' WHERE cycle = (SELECT id FROM cycle WHERE p = 12)")
    with pytest.raises(StoreError, match="without a status of period '12'"):
        load_index(Catalogue(filled), 1.6)


@pytest.mark.parametrize("other", [4, 6])
def test_words_of_classes_of_another_period_are_told_with_theirs(catalogues, tmp_path, other):
    path = tmp_path / "mixed_up.db"
    path.write_bytes(catalogues[0].path.read_bytes())
    with contextlib.closing(sqlite3.connect(path)) as plain, plain:
        last = "(SELECT max(word) FROM sequence WHERE p = 5)"
        foreign = f"(SELECT max(id) FROM cycle WHERE p = {other})"
        plain.execute(f"UPDATE sequence SET cycle = {foreign} WHERE p = 5 AND word = {last}")
        plain.execute(
            "DELETE FROM sequence WHERE p = 5 AND word < '0103'"
        )  # so that they are read one by one
    with pytest.raises(StoreError, match="impossible numbers of classes, of period '5'"):
        load_index(Catalogue(path), 1.6)
