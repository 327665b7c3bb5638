"""Snapshots beside one another: threads, tasks, generators, processes; and files that are replaced."""

import asyncio
import multiprocessing
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from orbitdb import Catalogue, InputError, StoreError


@pytest.fixture
def catalogue(filled):
    return Catalogue(filled, a=1.6)


@pytest.fixture
def other(made_once, tmp_path):
    """A catalogue that has nothing to do with the first one."""

    def make(path):
        made = Catalogue.create(path)
        made.fill("2-8", a=1)
        made.fill("2-8", a=1.6)

    return Path(shutil.copy(made_once("other", make), tmp_path / "other.db"))


def codes(catalogue):
    with catalogue.snapshot() as then:
        for (code,) in then.rows(p="7-8", columns=("code",)):
            yield code, then.a_values()


def test_two_generators_each_see_their_own_moment(catalogue):
    first = codes(catalogue)
    seen = [next(first)]
    catalogue.fill(2, a=3.5)
    second = codes(catalogue)
    seen.append(next(second))
    assert [values for _, values in seen] == [[1.6], [1.6, 3.5]]
    assert {tuple(values) for _, values in first} == {(1.6,)}
    assert {tuple(values) for _, values in second} == {(1.6, 3.5)}
    assert catalogue.a_values() == [1.6, 3.5]


def test_a_generator_that_is_left_alone_ends_its_snapshot(catalogue):
    begun = codes(catalogue)
    next(begun)
    del begun
    catalogue.fill(2, a=3.5)
    assert catalogue.a_values() == [1.6, 3.5]
    assert [each.name for each in catalogue.path.parent.iterdir()] == [catalogue.path.name]


async def test_two_tasks_each_see_their_own_moment(catalogue):
    inside, written = asyncio.Event(), asyncio.Event()

    async def early():
        with catalogue.snapshot() as then:
            before = then.a_values()
            inside.set()
            await written.wait()
            return before, then.a_values()

    async def late():
        await inside.wait()
        catalogue.fill(2, a=3.5)
        with catalogue.snapshot() as then:
            written.set()
            await asyncio.sleep(0)
            return then.a_values(), then.a_values()

    first, second = await asyncio.gather(early(), late())
    assert (first, second) == (([1.6], [1.6]), ([1.6, 3.5], [1.6, 3.5]))
    assert catalogue.a_values() == [1.6, 3.5]


def test_each_thread_opens_a_snapshot_of_its_own(catalogue):
    answers, refusals = [], []

    def work(then):
        try:
            then.a_values()
        except InputError as error:
            refusals.append(str(error))
        with catalogue.snapshot() as own:
            answers.append((own.a_values(), len([*own.rows(p=7, columns=("code",))])))

    with catalogue.snapshot() as then:
        before = then.a_values()
        Catalogue(catalogue.path).fill(2, a=3.5)
        threads = [threading.Thread(target=work, args=(then,)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert (before, then.a_values()) == ([1.6], [1.6])
    assert answers == 4 * [([1.6, 3.5], 376)]
    assert refusals == 4 * ["a snapshot belongs to the thread that opened it: open another one here"]


FORKED_WITHIN = """
import os, sys
from pathlib import Path
from orbitdb import Catalogue, InputError
from orbitdb.store.writer import Writer

catalogue = Catalogue(sys.argv[1], a=1.6)
writer = Writer(Path(sys.argv[1]), {})
wait, go = os.pipe()
with catalogue.snapshot() as then:
    assert then.a_values() == [1.6]
    rows = iter(then.rows(p=8, columns=("code",)))
    first = next(rows)
    if (child := os.fork()) == 0:
        os.read(wait, 1)
        try:
            then.count()
        except InputError as error:
            refused = str(error)
        with catalogue.snapshot() as own:
            seen = own.a_values(), own.count(p=8)
    else:
        with writer.transaction() as connection:
            writer.stadium_id(connection, 3.5)
        os.write(go, b"!")
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert then.a_values() == [1.6]  # still the moment before
        assert len({first, *rows}) == 1424
if child == 0:
    assert refused == "a snapshot belongs to the thread that opened it: open another one here"
    assert seen == ([1.6, 3.5], 1424)
    assert catalogue.a_values() == [1.6, 3.5]
    del rows, then
    sys.exit(0)  # ends the interpreter as usual
assert catalogue.a_values() == [1.6, 3.5]
writer.close()
sys.exit(status)
"""

forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")


@forks
def test_a_snapshot_does_not_end_in_a_forked_process(filled):
    done = subprocess.run([sys.executable, "-W", "error", "-c", FORKED_WITHIN, filled], capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]


@pytest.mark.slow
def test_a_spawned_process_opens_the_file_itself(catalogue):
    with multiprocessing.get_context("spawn").Pool(1) as pool, catalogue.snapshot() as then:
        assert then.a_values() == [1.6]
        catalogue.fill(2, a=3.5)
        assert pool.apply(Catalogue.a_values, (catalogue,)) == [1.6, 3.5]
        assert then.a_values() == [1.6]


# another file in its place


def copied_over(other, path):
    subprocess.run(["cp", other, path], check=True)  # the same inode with another content


def moved_over(other, path):
    other.replace(path)


REPLACED = "was replaced by another file while it was being read: ask again"


@pytest.mark.parametrize("put", [copied_over, moved_over])
def test_a_question_in_a_snapshot_of_a_replaced_file_fails(catalogue, other, put):
    moment = catalogue.snapshot()
    then = moment.__enter__()
    assert then.count(p=5) > 0
    put(other, catalogue.path)
    with pytest.raises(StoreError, match=REPLACED) as raised:
        then.table(p=8)
    assert not moment.__exit__(StoreError, raised.value, None)
    assert catalogue.a_values() == [1, 1.6]


@pytest.mark.parametrize("put", [copied_over, moved_over])
def test_the_end_of_a_snapshot_notices_a_file_that_replaced_its_own(catalogue, other, put):
    def replace():
        with catalogue.snapshot() as then:
            then.count(p=5)
            put(other, catalogue.path)

    with pytest.raises(StoreError, match=REPLACED):
        replace()


def test_another_error_in_a_snapshot_of_a_replaced_file_stays(catalogue, other):
    def fail():
        with catalogue.snapshot():
            copied_over(other, catalogue.path)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()


@pytest.mark.parametrize("put", [copied_over, moved_over])
def test_rows_of_a_file_that_is_replaced_end_with_an_error(catalogue, other, put):
    rows = iter(catalogue.rows())
    next(rows)
    put(other, catalogue.path)
    with pytest.raises(StoreError, match=REPLACED):
        list(rows)


WRITTEN = {
    "csv": lambda then, target: then.rows().write(target),
    "jsonl": lambda then, target: then.rows().write(target),
    "db": lambda then, target: then.copy(target),
    "dataset": lambda then, target: then.write_dataset(target),
}


@pytest.mark.parametrize("form", WRITTEN)
def test_what_is_written_from_a_replaced_file_never_gets_its_name(catalogue, other, tmp_path, form):
    def write():
        with catalogue.snapshot() as then:
            then.count(p=5)
            copied_over(other, catalogue.path)
            WRITTEN[form](then, tmp_path / f"target.{form}")

    with pytest.raises(StoreError, match=REPLACED):
        write()
    assert {each.name for each in tmp_path.iterdir()} == {catalogue.path.name, other.name}


def test_an_atlas_of_a_replaced_file_is_not_written(catalogue, other, tmp_path, monkeypatch):
    def replaced_meanwhile(connection):
        moved_over(other, catalogue.path)
        return []

    monkeypatch.setattr("orbitdb.answers.dataset.made_by", replaced_meanwhile)
    with pytest.raises(StoreError, match=REPLACED):
        catalogue.atlas(tmp_path / "atlas.html", p="2-4")
    assert not (tmp_path / "atlas.html").exists()


@pytest.mark.parametrize("cut", [True, False])
def test_a_sound_file_that_replaced_another_is_not_called_damaged(catalogue, other, cut):
    def read():
        with catalogue.snapshot() as then:
            rows = iter(then.rows(order="length", columns=("code", "length")))
            next(rows)
            content = other.read_bytes()
            catalogue.path.write_bytes(content[: len(content) // 3] if cut else content)
            list(rows)
            list(then.rows(order="lyapunov"))

    with pytest.raises(StoreError, match=REPLACED):
        read()


def test_a_fill_meanwhile_replaces_nothing(catalogue):
    with catalogue.snapshot() as then:
        before = then.count()
        for a in (2.5, 3.5):
            Catalogue(catalogue.path).fill("2-4", a=a)  # moves its journal into the file
            assert then.count() == before
        Catalogue(catalogue.path).delete(2.5)
        assert then.a_values() == [1.6]
    assert catalogue.a_values() == [1.6, 3.5]
