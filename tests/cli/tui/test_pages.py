"""Pages by key: the same rows in the same order as the catalogue gives them."""

import numpy as np
import pytest
import sqlalchemy as sa

from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import certificate, cycle
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.pages import CancelledError, certificate_of, chosen_keys, fetch, load_index
from orbitdb.store.writing.writer import Writer

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
    Selection(a=1.0),
    Selection(a=7.0),
]
COLUMNS = ("p", "code", "length", "lambda_d", "status", "symmetry", "representative", "rules", "element")
LONG = "1" * 25 + "3"


@pytest.fixture(scope="module")
def catalogues(tmp_path_factory):
    """Return a plain catalogue, and one that also has pruned words and one of order 26."""
    folder = tmp_path_factory.mktemp("pages")
    Catalogue.create(folder / "plain.db")
    for a, highest in ((1.6, 6), (1.0, 5)):
        for _ in fill_periods(folder / "plain.db", a, range(2, highest + 1)):
            pass
    (folder / "mixed.db").write_bytes((folder / "plain.db").read_bytes())
    for _ in fill_geometric(folder / "mixed.db", range(2, 5)):
        pass
    fill_word(folder / "mixed.db", LONG, 1.6)
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
            assert [index.word(key) for key in keys.tolist()] == [code for (code,) in rows]


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
        place = index.position(keys, word)
        assert place is not None
        assert index.word(int(keys[place])) == word
    assert index.position(keys, "1213131") is None
    assert index.position(keys, "1" * 30 + "3") is None


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


def test_a_factor_chooses_words_and_not_whole_classes(catalogues):
    index, chosen = load_index(catalogues[0], 1.6), Selection(contains="0132")
    keys = chosen_keys(catalogues[0], index, chosen, "length", True)
    words = [code for (code,) in catalogues[0].rows(chosen, ("code",), "length desc")]
    assert [index.word(key) for key in keys.tolist()] == words
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
                empty = [row[1] is None for row in fetch(catalogue, index, keys, ("code", column))]
                assert empty == sorted(empty)
