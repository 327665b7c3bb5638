"""Filling periods and births: resuming, reuse, two processes, and what births say about other a."""

import json
import shutil
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest
from contents import alter, ask, before_statements, content, counts_of, made

from orbitdb.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.fill import fill_births, fill_geometric, fill_periods, fill_words
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.file import migrate
from orbitdb.symbols import pruning
from orbitdb.symbols.pruning import count_admissible, count_primitive


def fill(path: Path, a: float = 1.6, periods=range(2, 9), **options) -> None:
    made(path, fill_periods(path, a, periods, **options))


@pytest.mark.slow
def test_a_period_can_be_filled_after_single_words(filled, tmp_path):
    path = tmp_path / "words.db"
    migrate(path)
    for word in ("1232131", "13", "01320155", "1001"):
        assert fill_words(path, [word], 1.6)[0].stored
    assert not fill_words(path, ["02"], 1.6)[0].stored
    fill(path)
    stored, expected = content(path), content(filled)
    assert stored["pruned"] == [(4, "0011", "1,3,6")]
    assert [row[:5] for row in stored["catalogue"]] == [row[:5] for row in expected["catalogue"]]


@pytest.mark.usefixtures("small_blocks")
def test_a_fill_continues_after_another_overtakes_it(tmp_path):
    path = tmp_path / "shared.db"
    migrate(path)
    first, second = fill_periods(path, 1.6, [8]), fill_periods(path, 1.6, [8])
    behind, ahead = next(first).words, [next(second).words for _ in range(3)][-1]
    second.close()
    done = [step.words for step in first]
    assert behind < ahead < done[0] < done[-1] == 2096
    assert Catalogue(path).fills(a=1.6)[0].done


@pytest.mark.usefixtures("small_blocks")
def test_a_period_that_lost_words_is_not_marked_complete(tmp_path):
    path = tmp_path / "orbits.db"
    migrate(path)
    going = fill_periods(path, 1.6, [6])
    assert next(going).words < 252
    alter(path, "DELETE FROM orbit WHERE cycle = (SELECT min(id) FROM cycle WHERE class_size = 8)")
    with pytest.raises(StoreError, match=r"period 6 has 244 words instead of 252: .* is damaged"):
        list(going)
    assert not Catalogue(path).fills(a=1.6)[0].done


def test_others_may_write_while_a_period_is_counted(tmp_path):
    """At p = 15, counting takes seconds."""
    path, tried = tmp_path / "orbits.db", []

    def look(statement: str) -> None:
        if "GROUP BY" in statement:
            with closing(sqlite3.connect(path, timeout=0)) as other:
                other.execute("BEGIN IMMEDIATE")
            tried.append(statement)

    with before_statements(look):
        fill(path, periods=[3, 4])
    assert len(tried) == 2


@pytest.mark.usefixtures("small_blocks")
def test_progress_counts_stored_words_at_every_a(tmp_path):
    path = tmp_path / "new.db"
    migrate(path)
    for a in (1.6, 1.0):  # at the second a the classes exist already
        catalogue, steps = Catalogue(path, a), []
        for step in fill_periods(path, a, [6, 7]):
            there = catalogue.count(Selection(a, periods=((step.p, step.p),), statuses=tuple(Status)))
            assert step.words == there
            steps.append(step)
        assert len(steps) > 4
        assert {(step.p, step.total) for step in steps} == {(6, 252), (7, 712)}
        assert [step.p for step in steps if step.words == step.total][-1] == 7


@pytest.mark.slow
def test_times_of_a_fill_are_stored(tmp_path):
    path = tmp_path / "new.db"
    start = time.monotonic()
    fill(path, periods=[5], method="relaxation")
    (kept,) = Catalogue(path).fills(a=1.6)
    assert 0 < kept.seconds < time.monotonic() - start
    stages = kept.enumerating, kept.solving, kept.storing
    assert 0 < 9 * kept.enumerating < kept.solving  # solving takes 200 times as long
    assert 0 < 9 * kept.storing < kept.solving
    assert sum(stages) < kept.seconds + 0.05  # processor time of one core; the two clocks differ slightly


@pytest.mark.slow
def test_the_papers_method_gives_the_same_statuses(tmp_path):
    newton, relaxed = tmp_path / "newton.db", tmp_path / "relaxed.db"
    for path, method in ((newton, "newton"), (relaxed, "relaxation")):
        fill(path, periods=range(2, 7), method=method)
    one, other = content(newton)["catalogue"], content(relaxed)["catalogue"]
    assert [row[:6] for row in one] == [row[:6] for row in other]
    lengths = [(row[6], again[6]) for row, again in zip(one, other, strict=True) if row[6] is not None]
    assert all(again == pytest.approx(exact, rel=1e-11) for exact, again in lengths)


@pytest.fixture
def born(born_once: Path, tmp_path: Path) -> Path:
    """A copy of a catalogue with the births of p = 2..6 and no fill."""
    return Path(shutil.copy(born_once, tmp_path / "born.db"))


def test_births_have_one_row_per_period(born):
    found = {each.p: each for each in Catalogue(born).birth_fills()}
    assert [each.p for each in found.values()] == list(range(2, 7))
    assert all(each.done for each in found.values())
    assert [each.words for each in found.values()] == [count_admissible(p) for p in range(2, 7)]
    assert [(each.classes, each.births, each.deaths, each.always) for each in found.values()] == [
        (1, 0, 0, 1), (2, 0, 0, 2), (8, 0, 0, 8), (17, 13, 0, 4), (47, 33, 0, 14)
    ]  # fmt: skip
    assert all(each.seconds > 0 for each in found.values())
    assert found[4].least is None
    assert found[6].largest == pytest.approx(3.043599, abs=1e-6)


@pytest.mark.slow
def test_deaths_are_counted_separately(born):
    """At p = 9, two classes die and are reborn."""
    made(born, fill_births(born, [9]))
    found = Catalogue(born).birth_fills()[-1]
    asked = "SELECT count(*), count(DISTINCT cycle), min(a), max(a) FROM change JOIN cycle ON id = cycle"
    (births,) = ask(born, f"{asked} WHERE p = 9 AND kind = 'born' AND a > 0")
    (deaths,) = ask(born, f"{asked} WHERE p = 9 AND kind = 'died'")
    assert (found.births, found.least, found.largest) == (births[0], *births[2:])
    assert found.deaths == deaths[1] > 0


@pytest.mark.slow
def test_a_geometric_fill_goes_through_all_words_of_a_period(tmp_path):
    Catalogue.create(tmp_path / "orbits.db")
    steps = list(fill_geometric(tmp_path / "orbits.db", [8]))
    done = [step.words for step in steps]
    assert done == sorted(set(done))
    assert done[-1] == steps[-1].total == count_primitive(8) - count_admissible(8)


def test_a_slip_in_the_rules_is_noticed_by_the_fill_itself(tmp_path, monkeypatch):
    """Here legs with one wall are forbidden, in the enumeration and in the counts by rules alike."""
    follow, cached = pruning._follow, (pruning.automaton, pruning._closed_walks)

    def slip(state, symbol):
        new, broken = follow(state, symbol)
        return new, broken | ({4} if state.walls == 1 and new.walls == 0 else set())

    path = tmp_path / "orbits.db"
    migrate(path)
    try:
        monkeypatch.setattr(pruning, "_follow", slip)
        for each in cached:
            each.cache_clear()
        assert [count_admissible(p) for p in range(2, 6)] == [1, 4, 12, 36]
        with pytest.raises(StoreError, match="period 3 has 4 words instead of 8"):
            fill(path, periods=range(2, 6))
    finally:
        monkeypatch.undo()
        for each in cached:
            each.cache_clear()


@pytest.mark.slow
def test_a_geometric_fill_that_was_stopped_does_not_count_as_complete(tmp_path, monkeypatch):
    """Nor do single words. It goes on where it stopped, `verify` knows its rows, and so does `delete`."""
    monkeypatch.setattr("orbitdb.filling.fill.PRUNED_BLOCK", 1)
    path = tmp_path / "orbits.db"
    catalogue = Catalogue.create(path)
    catalogue.fill("2-6")
    catalogue.fill(code="1001")
    assert "of period 4 are not stored (there are 283)" in catalogue.rows(p=4, status="geometric").notes[0]
    steps = fill_geometric(path, [4, 6])
    stored = [next(steps).words for _ in range(3)]
    steps.close()
    assert "of period 6 are not all stored" in catalogue.rows(p="4,6", status="geometric").notes[0]
    assert catalogue.verify().sound
    assert catalogue.estimate("4,6", geometric=True).words == 7735 - 252 - stored[-1]
    alter(path, "DELETE FROM pruned WHERE word = '000001'")
    assert "counts" in {check.name for check in catalogue.verify().failed}
    with pytest.raises(StoreError, match="period 6 has 7482 words instead of 7483"):
        made(path, fill_geometric(path, [4, 6]))
    assert catalogue.delete(1.6, 6).pruned == 7735 - 252 - 1
    catalogue.fill("4-6", geometric=True)
    assert catalogue.rows(p="4-6", status="geometric").notes == ()
    assert catalogue.verify().sound
    assert ask(path, "SELECT p, state, words FROM pruned_fill WHERE p < 6") == [
        (4, "done", 283),
        (5, "done", 1458),
    ]


def test_pruned_words_go_with_the_last_fill_of_their_period(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db")
    for a in (1, 1.6):
        catalogue.fill("2-4", a=a, geometric=True)
    assert catalogue.delete(1, "3-4").pruned == 0
    assert "345 geometrically pruned words" in str(catalogue.delete(1.6, "3-4"))
    assert ask(tmp_path / "orbits.db", "SELECT p, count(*) FROM pruned GROUP BY p") == [(2, 13)]


def test_a_run_records_its_command_and_parameters(born):
    ((parameters,),) = ask(born, "SELECT DISTINCT parameters FROM run")
    asked = json.loads(parameters)
    assert (asked["command"], asked["periods"]) == ("births", list(range(2, 7)))


@pytest.mark.parametrize(("a", "p", "boundary"), [(1.0, 6, 32), (1.6, 5, 0)])
def test_fills_and_births_give_the_same_counts(born, a, p, boundary):
    """The counts include orbits through a joint."""
    before = counts_of(Catalogue(born), a=a)
    assert before.from_births == tuple(range(2, 7))
    assert counts_of(Catalogue(born), a=a, p="3-4").from_births == (3, 4)
    made(born, fill_periods(born, a, [p]))
    after = counts_of(Catalogue(born), a=a)
    assert p not in after.from_births
    assert after.tallies == before.tallies
    assert after.tallies[p].boundary == boundary


def test_words_born_together_share_an_event(born):
    events = ask(
        born,
        "SELECT count(DISTINCT cycle), max(a + error) - min(a - error), max(error) FROM change"
        " JOIN cycle ON id = cycle WHERE p = 6 AND event IS NOT NULL GROUP BY event",
    )
    assert len(events) == 11
    assert {count for count, *_ in events} == {2, 3, 7}
    assert all(width <= 4 * error for _, width, error in events)
