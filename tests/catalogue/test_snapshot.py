"""Several questions at one moment, whatever others write meanwhile; and a file that does not exist yet."""

import os
import pickle
import subprocess
import sys
import threading

import pytest
from processes import run
from quick import slow_but

from orbitdb import Catalogue, InputError, StoreError
from orbitdb.store.where import CancelledError


@pytest.fixture
def catalogue(filled):
    return Catalogue(filled, a=1.6)


@pytest.mark.slow
def test_a_snapshot_does_not_see_what_another_process_writes(catalogue):
    with catalogue.snapshot():
        before = len(catalogue), catalogue.a_values(), catalogue.contents(1.6)
        assert run("fill", "--p", "4", "--a", "2.5", "--db", catalogue.path).returncode == 0
        assert run("delete", "--p", "8", "--a", "1.6", "--yes", "--db", catalogue.path).returncode == 0
        with catalogue.snapshot():  # joins the outer one
            assert catalogue.find("13", a=2.5) is None
        assert (len(catalogue), catalogue.a_values(), catalogue.contents(1.6)) == before
        assert len([*catalogue.rows(columns=("code",))]) == before[0]
        assert catalogue.table(p=8)["N_t"] == [catalogue.count(p=8)] != [0]
    assert catalogue.a_values() == [1.6, 2.5]
    assert catalogue.count(p=8) == 0
    assert catalogue.find("13", a=2.5) is not None


def test_questions_without_a_snapshot_see_the_latest_rows(catalogue):
    assert catalogue.a_values() == [1.6]
    Catalogue(catalogue.path).fill(2, a=3.5)
    assert catalogue.a_values() == [1.6, 3.5]


def test_another_thread_has_snapshots_of_its_own(catalogue):
    found = []
    with catalogue.snapshot():
        assert catalogue.a_values() == [1.6]
        Catalogue(catalogue.path).fill(2, a=3.5)
        thread = threading.Thread(target=lambda: found.extend(catalogue.a_values()))
        thread.start()
        thread.join()
        assert (catalogue.a_values(), found) == ([1.6], [1.6, 3.5])


def test_what_is_stored_within_a_snapshot_is_returned_but_not_seen(catalogue):
    with catalogue.snapshot():
        assert catalogue.a_values() == [1.6]
        assert [fill.n_c for fill in catalogue.fill("2-3", a=2.5)] == [1, 8]
        assert [sweep.p for sweep in catalogue.sweep(4, a=2.5)] == [4]
        assert catalogue.a_values() == [1.6]
    assert catalogue.count(a=2.5) == 9


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
    catalogue.fill(9)  # more rows than are read at a time
    with catalogue.snapshot():
        rows = iter(catalogue.rows(columns=("code",)))
        next(rows)
    with pytest.raises(InputError, match="the snapshot of these rows has ended"):
        list(rows)
    assert catalogue.count(p=3) == 8


def test_a_statement_that_is_not_read_to_its_end_holds_no_snapshot(catalogue):
    statement = catalogue.sql("SELECT p FROM catalogue ORDER BY p")
    assert statement.columns == ("p",)
    assert [fill.p for fill in catalogue.fill(2, a=3.5)] == [2]
    assert catalogue.a_values() == [1.6, 3.5]
    with catalogue.snapshot():
        rows = iter(statement)
        assert next(rows) == (2,)
    Catalogue(catalogue.path).fill(2, a=4.5)
    assert catalogue.a_values() == [1.6, 3.5, 4.5]
    with pytest.raises(InputError, match="the snapshot of these rows has ended"):
        list(rows)


NUMBERS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT 100000) SELECT max(i) FROM n"


@pytest.mark.parametrize(
    "ask", [lambda catalogue: catalogue.rows(order="length desc"), lambda catalogue: catalogue.sql(NUMBERS)]
)
def test_a_cancelled_snapshot_ends_the_question(catalogue, ask):
    with pytest.raises(CancelledError), catalogue.snapshot(cancelled=lambda: True):
        [*ask(catalogue)]
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
            "period 3 is not filled at a = 1.6: 'orbitdb fill --p 3 --a 1.6' fills it",
        )
    assert not any(tmp_path.iterdir())
    Catalogue.create(path).fill(3)
    assert not catalogue.missing
    assert catalogue.count() == copy.count() == 8


def test_other_files_are_refused_whether_or_not_a_missing_one_is_allowed(tmp_path):
    (tmp_path / "text.db").write_text("hello\n" * 50)
    for path, said in ((tmp_path / "text.db", "not an orbitdb catalogue"), (tmp_path, "is a folder")):
        with pytest.raises(StoreError, match=said):
            Catalogue(path, missing_ok=True)


FORKED = """
import os, sys
from pathlib import Path
from orbitdb import Catalogue
from orbitdb.store.writer import Writer

catalogue = Catalogue(sys.argv[1])
assert catalogue.a_values() == [1.6]  # leaves a connection in the pool
wait, go = os.pipe()
if (child := os.fork()) == 0:
    os.read(wait, 1)
    os._exit(0 if catalogue.a_values() == [1.6, 3.5] else 1)
catalogue.close()
writer = Writer(Path(sys.argv[1]), {})
with writer.writing() as connection:
    writer.stadium_id(connection, 3.5)  # in a new journal, because the last connection closed the old one
os.write(go, b"!")
status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
writer.close()
sys.exit(status)
"""


FORKED_WITHIN = """
import os, sys
from pathlib import Path
from orbitdb import Catalogue
from orbitdb.store.writer import Writer

catalogue = Catalogue(sys.argv[1])
writer = Writer(Path(sys.argv[1]), {})
wait, go = os.pipe()
with catalogue.snapshot():
    assert catalogue.a_values() == [1.6]
    rows = iter(catalogue.rows(p=8, columns=("code",)))
    first = next(rows)
    if (child := os.fork()) == 0:
        os.read(wait, 1)
        with catalogue.snapshot():
            seen = catalogue.a_values(), catalogue.count(p=8)
    else:
        with writer.writing() as connection:
            writer.stadium_id(connection, 3.5)
        os.write(go, b"!")
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert catalogue.a_values() == [1.6]  # still the moment before
        assert len({first, *rows}) == 2096
if child == 0:
    os._exit(0 if seen == ([1.6, 3.5], 2096) and catalogue.a_values() == [1.6, 3.5] else 1)
assert catalogue.a_values() == [1.6, 3.5]
catalogue.close()
writer.close()
sys.exit(status)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
@pytest.mark.parametrize(
    "program",
    slow_but([FORKED_WITHIN], [FORKED, FORKED_WITHIN]),
    ids=["between questions", "within a snapshot"],
)
def test_a_forked_process_opens_the_file_itself(filled, program):
    assert subprocess.run([sys.executable, "-W", "error", "-c", program, filled]).returncode == 0
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]
