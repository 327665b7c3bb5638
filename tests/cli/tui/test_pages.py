"""Pages of a chosen subset, and where words stand in it: as the catalogue gives its rows."""

import contextlib
import sqlite3

import pytest
import sqlalchemy as sa

from orbitdb.cli.tui.jumping import place_of
from orbitdb.cli.tui.source import Ordering, Pages, head_of
from orbitdb.errors import StoreError
from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.engines import driver
from orbitdb.store.file.tables import certificate, cycle
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.lookup import certificate_of
from orbitdb.store.reading.order import periods_of
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.symmetry import members

LONG, PRUNED = "1" * 25 + "3", "00" + "1" * 23
EVERYTHING = Selection(statuses=tuple(Status))
CHOSEN = (
    (EVERYTHING, Ordering()),
    (EVERYTHING, Ordering("code", True)),
    (Selection(), Ordering("element")),
    (Selection(), Ordering("length", True)),
    (Selection(contains="321"), Ordering("lambda_c")),
    (Selection(where="code like '%1_' or p = 3"), Ordering("code")),
    (Selection(periods=((3, 3), (6, 6)), time_reversal="self"), Ordering("margin", True)),
    (Selection(statuses=(Status.GEOMETRIC,)), Ordering("code")),
)
COLUMNS = ("code", "p", "length", "status", "symmetry", "representative", "element", "maslov")


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    """Return one with pruned words and two long words, one of them pruned."""
    path = tmp_path_factory.mktemp("pages") / "orbits.db"
    Catalogue.create(path)
    for _ in (*fill_periods(path, 1.6, range(2, 7)), *fill_geometric(path, range(2, 5))):
        pass
    for word in (LONG, PRUNED):
        fill_word(path, word, 1.6)
    return Catalogue(path)


def pages_of(catalogue, selection, ordering, columns=COLUMNS):
    return Pages(catalogue, catalogue.choose(selection, str(ordering)), columns)


@pytest.mark.parametrize(("selection", "ordering"), CHOSEN, ids=str)
def test_rows_stand_where_the_catalogue_has_them(catalogue, selection, ordering):
    rows = list(catalogue.rows(selection, COLUMNS, str(ordering)))
    pages = pages_of(catalogue, selection, ordering)
    assert len(pages) == len(rows) > 0
    for place in {*range(0, len(rows), 41), len(rows) - 1}:
        assert pages.row(place) == rows[place]
        assert pages.position(rows[place][0]) == place
    words = {row[0] for row in rows}
    everything = [code for (code,) in catalogue.rows(EVERYTHING, ("code",))]
    others = [word for word in (*everything[::29], LONG, PRUNED, "1" * 30 + "3") if word not in words]
    assert [pages.position(word) for word in others] == [None] * len(others)


@pytest.mark.parametrize(("selection", "ordering"), CHOSEN, ids=str)
def test_digits_lead_to_what_is_first(catalogue, selection, ordering):
    pages = pages_of(catalogue, selection, ordering)
    words = [code for (code,) in catalogue.rows(selection, ("code",), str(ordering))]
    for typed in ("5", "12", "01", "13", "0133", "26", "25", "99", "000", "1111", "1" * 24, "4"):
        period = len(typed) <= 2 and typed[0] != "0" and [w for w in words if len(w) == int(typed)]
        fits = period or [w for w in words if w == typed] or [w for w in words if w.startswith(typed)]
        place, _ = place_of(pages, typed)
        assert (None if place is None else words[place]) == (fits[0] if fits else None), typed


def test_long_words_have_their_own_period(catalogue):
    chosen = catalogue.choose(EVERYTHING)
    rows = catalogue.rows(EVERYTHING, ("p",))
    with catalogue.reading() as connection:
        periods = periods_of(connection, chosen.ids)
    assert [p for (p,) in rows] == periods.repeat(chosen.counts).tolist()
    for word in members(LONG):
        place = pages_of(catalogue, Selection(), Ordering("code")).position(word)
        assert next(catalogue.rows(Selection(), ("code",), "code", 1, place)) == (word,)


def test_the_first_rows_are_those_of_all(catalogue):
    head, pages = (
        head_of(catalogue, Selection(), COLUMNS, 20),
        pages_of(catalogue, Selection(), Ordering()),
    )
    assert not head.whole
    assert 20 <= len(head) < len(pages)
    assert [head.row(place) for place in range(len(head))] == [pages.row(place) for place in range(len(head))]


def test_nobody_waits(catalogue):
    with pytest.raises(CancelledError):
        place_of(pages_of(catalogue, Selection(), Ordering()), "54", lambda: True)
    two = Selection(periods=((2, 2),))  # so few rows that the query ends before it asks
    with pytest.raises(CancelledError):
        list(catalogue.rows(two, ("code",), cancelled=lambda: True))


def test_a_bad_filter_is_refused(catalogue):
    with pytest.raises(SelectionError, match="lenght"):
        pages_of(catalogue, Selection(where="lenght > 3"), Ordering())


def test_a_row_that_has_gone_is_told(catalogue, tmp_path):
    path = tmp_path / "altered.db"
    path.write_bytes(catalogue.path.read_bytes())
    pages = pages_of(Catalogue(path), Selection(), Ordering())
    with contextlib.closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("DELETE FROM orbit")
    with pytest.raises(StoreError, match="altered"):
        pages.row(0)


def test_a_certificate_is_read_by_its_class(catalogue):
    with catalogue.reading() as connection:
        assert certificate_of(driver(connection), "013", 1.6) is None
    writer = Writer(catalogue.path, {"command": "test"})
    with writer.writing() as connection:
        number = connection.scalar(sa.select(cycle.c.id).where(cycle.c.word == "013"))
        row = {"stadium": writer.stadium_id(connection, 1.6), "cycle": number, "radius": 1e-30, "bits": 128}
        connection.execute(sa.insert(certificate).values(**row, version="1", run=writer.run_id(connection)))
    writer.close()
    with catalogue.reading() as connection:
        assert certificate_of(driver(connection), "013", 1.6) == (1e-30, 128)
        assert certificate_of(driver(connection), "013", 1.0) is None
