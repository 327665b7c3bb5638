"""Several questions at one moment, whatever others write meanwhile; and a file that does not exist yet."""

import pickle

import pytest
from processes import run

from orbitdb import Catalogue, InputError, StoreError
from orbitdb.store.where import CancelledError


@pytest.fixture
def catalogue(filled):
    return Catalogue(filled, a=1.6)


@pytest.mark.slow
def test_a_snapshot_does_not_see_what_another_process_writes(catalogue):
    with catalogue.snapshot() as then:
        before = len(then), then.a_values(), then.contents(1.6)
        assert run("fill", "--p", "4", "--a", "2.5", "--db", catalogue.path).returncode == 0
        assert run("delete", "--p", "8", "--a", "1.6", "--yes", "--db", catalogue.path).returncode == 0
        with then.snapshot() as same:
            assert same is then
            assert then.find("13", a=2.5) is None
        assert (len(then), then.a_values(), then.contents(1.6)) == before
        assert len([*then.rows(columns=("code",))]) == before[0]
        assert then.table(p=8)["N_c"] == [then.count(p=8)] != [0]
        assert catalogue.a_values() == [1.6, 2.5]
        assert catalogue.count(p=8) == 0
    assert catalogue.a_values() == [1.6, 2.5]
    assert catalogue.count(p=8) == 0
    assert catalogue.find("13", a=2.5) is not None


def test_questions_without_a_snapshot_see_the_latest_rows(catalogue):
    assert catalogue.a_values() == [1.6]
    Catalogue(catalogue.path).fill(2, a=3.5)
    assert catalogue.a_values() == [1.6, 3.5]


def test_what_is_stored_during_a_snapshot_is_not_seen_by_it(catalogue):
    with catalogue.snapshot() as then:
        assert then.a_values() == [1.6]
        assert [fill.n_c for fill in catalogue.fill("2-3", a=2.5)] == [1, 8]
        assert [sweep.p for sweep in catalogue.sweep([4], a=2.5)] == [4]
        assert (then.a_values(), catalogue.a_values()) == ([1.6], [1.6, 2.5])
    assert catalogue.count(a=2.5) == 9


REFUSED = {
    "fill": lambda then: then.fill(3),
    "fill code": lambda then: then.fill(code="13"),
    "fill_births": lambda then: then.fill_births(3),
    "fill_levels": lambda then: then.fill_levels(5.0),
    "sweep": lambda then: then.sweep(3),
    "simulate": lambda then: then.simulate(1000),
    "prove_bounds": lambda then: then.prove_bounds(4),
    "delete": lambda then: then.delete(1.6),
    "check_writable": lambda then: then.check_writable(),
    "verify": lambda then: then.verify(),
    "engine": lambda then: then.engine,
    "pickle": pickle.dumps,
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_snapshot_is_only_read(catalogue, name):
    with (
        catalogue.snapshot() as then,
        pytest.raises(InputError, match="a snapshot only answers questions: ask the catalogue itself for"),
    ):
        REFUSED[name](then)
    assert catalogue.a_values() == [1.6]


def test_a_snapshot_that_has_ended_says_so(catalogue):
    with catalogue.snapshot() as then:
        listing, statement = then.rows(), then.sql("SELECT count(*) FROM catalogue")
        subset = then.select(p="2-3", status="orbit")
    for ask in (
        lambda: then.count(p=3), lambda: [*listing], lambda: listing.total, lambda: listing.notes,
        lambda: [*statement], lambda: then["13"], lambda: then.snapshot().__enter__().count(),
    ):  # fmt: skip
        with pytest.raises(InputError, match="the snapshot has ended: ask, and read the rows, within"):
            ask()
    assert "the snapshot has ended" in repr(then)
    assert subset.of_period(3)[1].shape == (8, 3)  # coordinates depend on the words and a only


def test_an_error_ends_a_snapshot(catalogue):
    with pytest.raises(InputError), catalogue.snapshot():
        catalogue.select(p="x")
    Catalogue(catalogue.path).fill(2, a=3.5)
    assert catalogue.a_values() == [1.6, 3.5]


def test_rows_that_are_not_read_to_their_end_hold_no_snapshot(catalogue):
    rows = iter(catalogue.rows(columns=("code",)))
    assert next(rows) == ("13",)
    Catalogue(catalogue.path).fill(2, a=3.5)
    assert catalogue.a_values() == [1.6, 3.5]
    assert len([*rows]) == catalogue.count() - 1


def test_rows_of_a_snapshot_are_read_within_it(catalogue):
    catalogue.fill([9])  # more rows than are read at a time
    with catalogue.snapshot() as then:
        rows = iter(then.rows(columns=("code",)))
        next(rows)
    with pytest.raises(InputError, match="the snapshot has ended"):
        list(rows)
    assert catalogue.count(p=3) == 8


def test_a_statement_that_is_not_read_to_its_end_holds_no_snapshot(catalogue):
    statement = catalogue.sql("SELECT p FROM catalogue ORDER BY p")
    assert statement.columns == ("p",)
    assert [fill.p for fill in catalogue.fill(2, a=3.5)] == [2]
    assert catalogue.a_values() == [1.6, 3.5]
    with catalogue.snapshot() as then:
        rows = iter(then.sql("SELECT p FROM catalogue ORDER BY p"))
        assert next(rows) == (2,)
    Catalogue(catalogue.path).fill(2, a=4.5)
    assert catalogue.a_values() == [1.6, 3.5, 4.5]
    with pytest.raises(InputError, match="the snapshot has ended"):
        list(rows)


NUMBERS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT 100000) SELECT max(i) FROM n"


@pytest.mark.parametrize(
    "ask", [lambda catalogue: catalogue.rows(order="length desc"), lambda catalogue: catalogue.sql(NUMBERS)]
)
def test_a_cancelled_snapshot_ends_the_question(catalogue, ask):
    with pytest.raises(CancelledError), catalogue.snapshot(cancelled=lambda: True) as then:
        [*ask(then)]
    assert catalogue.count(p=2) == 1


def test_a_missing_file_is_an_empty_catalogue_if_that_is_allowed(tmp_path):
    path = tmp_path / "orbits.db"
    with pytest.raises(StoreError, match="no catalogue at"):
        Catalogue(path)
    catalogue = Catalogue(path, missing_ok=True)
    copy = pickle.loads(pickle.dumps(catalogue))
    for empty in (catalogue, copy):
        assert empty.missing
        assert (len(empty), empty.a_values(), empty.a) == (0, [], 1.6)
        assert [*empty.rows()] == [*empty.fills()] == []
        assert (empty.find("13"), empty["13"].stored, empty["13"].length) == (None, False, 10.4)
        assert empty.rows(p=3).notes == (
            "period 3 is not filled at a = 1.6: `catalogue.fill(p=3, a=1.6)` fills it",
        )
    assert not any(tmp_path.iterdir())
    Catalogue.create(path).fill([3])
    assert not catalogue.missing
    assert catalogue.count() == copy.count() == 8


def test_other_files_are_refused_whether_or_not_a_missing_one_is_allowed(tmp_path):
    (tmp_path / "text.db").write_text("hello\n" * 50)
    for path, said in ((tmp_path / "text.db", "not an orbitdb catalogue"), (tmp_path, "is a folder")):
        with pytest.raises(StoreError, match=said):
            Catalogue(path, missing_ok=True)
