"""Sweeps give the counts and sums of fills, with the same bits however they are run or resumed."""

from contextlib import closing
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from time import monotonic, thread_time
from typing import Any

import numpy as np
import pytest
from contents import alter, answer, ask, counts_of, whole
from quick import slow_but
from sqlalchemy import Connection, Engine, event
from there import there

from orbitdb.answers.complete_periods import read_complete_periods
from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling import sweeps
from orbitdb.filling.fill import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.filling.workers import HERE, Processes, Workers
from orbitdb.selection import Selection
from orbitdb.store import tables
from orbitdb.store.cursors import Cursor, sums_of_blocks
from orbitdb.store.file import migrate, reading
from orbitdb.store.periods import Sweep
from orbitdb.symbols.enumeration import class_spans

PERIODS = range(2, 7)


def swept(path: Path, a: float = 1.6, periods=PERIODS, workers: Workers = HERE) -> dict[int, Sweep]:
    migrate(path)
    list(sweep_periods(path, a, periods, workers))
    with closing(Catalogue(path)) as catalogue:
        return {each.p: each for each in catalogue.sweeps(a=a)}


def found(path: Path, **options) -> list[tuple[Any, ...]]:
    return [(each.p, each.tally, there(each.sums).numbers()) for each in swept(path, **options).values()]


@pytest.mark.parametrize("a", slow_but([1.0], [0.3, 1.0, 1.6]))
def test_sweeps_have_the_counts_and_sums_of_fills(tmp_path, a):
    path = tmp_path / "orbits.db"
    found = swept(path, a)
    with closing(Catalogue(path)) as catalogue:
        swept_counts = counts_of(catalogue, a=a)
    list(fill_periods(path, a, PERIODS))
    with closing(Catalogue(path)) as catalogue:
        fills = {fill.p: fill for fill in catalogue.fills(a=a)}
        rows = catalogue.classes(a=a, status="orbit").by_period()
        assert swept_counts.tallies == counts_of(catalogue, a=a).tallies
    for p in PERIODS:
        fill, tally, sums = fills[p], found[p].tally, PeriodSums.of(rows[p], p)
        swept_sums = there(found[p].sums)
        counts = (fill.n_t, fill.n_c, fill.classes, fill.boundary, fill.unresolved)
        assert (tally.words, tally.n_c, tally.classes, tally.boundary, tally.unresolved) == counts
        np.testing.assert_allclose(swept_sums.sums, sums.sums, rtol=1e-13)
        np.testing.assert_allclose(swept_sums.ranges, sums.ranges, rtol=1e-13)
    assert all(each.seconds > 0 and each.processor > 0 for each in found.values())
    assert (a != 1.0) or fills[4].boundary == 0 < there(fills[6].boundary)


class Tired(Workers):
    """Solves blocks here and claims an hour of processor time for each."""

    def solved(self, blocks):
        return (replace(block(), processor=3600.0) for block in blocks)


@pytest.mark.usefixtures("small_sweeps")
def test_elapsed_and_processor_seconds_are_stored_separately(tmp_path):
    sweep = swept(tmp_path / "orbits.db", periods=[6], workers=Tired())[6]
    assert sweep.processor == 3600.0 * sweep.blocks > 0
    assert 0.0 < sweep.seconds < 3600.0
    begun, of_processor = monotonic(), thread_time()
    alone = swept(tmp_path / "alone.db", periods=[8])[8]
    assert 0.0 < alone.processor < thread_time() - of_processor
    assert 0.0 < alone.seconds < monotonic() - begun


@pytest.mark.usefixtures("small_sweeps")
def test_an_unfinished_sweep_has_no_sums_and_is_not_counted(tmp_path):
    path = tmp_path / "orbits.db"
    migrate(path)
    going = sweep_periods(path, 1.6, [7])
    assert next(going).words < 712
    going.close()
    with closing(Catalogue(path)) as catalogue:
        (begun,) = catalogue.sweeps(a=1.6)
        assert (begun.done, begun.blocks, begun.sums) == (False, 1, None)
        assert counts_of(catalogue, a=1.6).chosen == ()
        known = answer(path, read_complete_periods, Selection(1.6), swept=True)
        assert (known.highest, known.swept, known.cycles().tolist()) == (0, {}, [0])


def test_a_sweep_adds_up_the_blocks_of_its_own_stadium(awkward, tmp_path):
    """Sweeps of period 8 were stopped at two values of a, in small blocks."""
    before = whole(awkward)["sweep_block"]
    with reading(awkward) as connection:
        blocks, _ = sums_of_blocks(connection, Cursor(tables.sweep, {"stadium": 2, "p": 8}))
    assert blocks == [row[3] for row in sorted(before) if row[0] == 2]
    Catalogue(awkward).sweep([8], a=0.3)
    (*_, resumed), alone = Catalogue(awkward).sweeps(a=0.3), swept(tmp_path / "alone.db", 0.3, [8])[8]
    assert (resumed.p, resumed.done, resumed.tally) == (8, True, alone.tally)
    np.testing.assert_allclose(there(resumed.sums).sums, there(alone.sums).sums, rtol=1e-13)
    others = [row for row in before if row[0] != 2]
    assert len(before) > len(others) > 0
    assert whole(awkward)["sweep_block"] == others


def test_a_period_closed_first_by_another_process_keeps_its_sums(tmp_path):
    path = tmp_path / "orbits.db"
    migrate(path)
    others = iter([HERE])

    def close_first(_connection: Connection) -> None:
        if ask(path, "SELECT 1 FROM sweep_block") and (other := next(others, None)):
            swept(path, periods=[5], workers=other)

    event.listen(Engine, "begin", close_first, insert=True)
    try:
        own = found(path, periods=[5])
    finally:
        event.remove(Engine, "begin", close_first)
    assert own == found(tmp_path / "alone.db", periods=[5])


@pytest.mark.usefixtures("small_sweeps")
def test_a_sweep_names_every_arithmetic_it_used(tmp_path):
    path = tmp_path / "orbits.db"
    migrate(path)
    going = sweep_periods(path, 1.6, [7])
    next(going)
    going.close()
    alter(path, "UPDATE run SET parameters = json_set(parameters, '$.arithmetic', 'another')")
    swept(path, periods=[7])
    query = "SELECT json_extract(parameters, '$.arithmetic') FROM run WHERE id = (SELECT run FROM sweep)"
    assert ask(path, query) == [(" | ".join(sorted([arithmetic(), "another"])),)]


def test_sum_rules_are_blank_from_the_first_swept_period_on(tmp_path):
    """A note says so. A sweep leaves out what is filled."""
    path = tmp_path / "orbits.db"
    catalogue = Catalogue.create(path, a=0.5)
    catalogue.fill("2-6")
    assert [sweep.p for sweep in catalogue.sweep("5-8")] == [7, 8]
    found, filled = catalogue.lyapunov(), catalogue.lyapunov(p="2-6")
    for name in ("lambda_d_sum_rule", "lambda_c_sum_rule_error"):
        assert found[name] == [*filled[name], None, None]
        assert filled[name][-1] is not None
    assert found["lambda_d_zeta"][-1] is not None
    assert any("blank from p = 7 on, which is swept" in note for note in found.notes)
    assert catalogue.sweep("2-6") == []


@pytest.mark.usefixtures("small_sweeps")
@pytest.mark.slow
def test_sums_do_not_depend_on_the_number_of_processes(tmp_path):
    alone = found(tmp_path / "alone.db")
    with Processes(2) as workers:
        assert found(tmp_path / "shared.db", workers=workers) == alone


@pytest.mark.parametrize(("p", "size"), [(9, 8), (9, 57), (11, 300), (14, sweeps.CLASSES)])
def test_blocks_are_cut_in_the_same_way_from_any_start(p, size):
    blocks = list(class_spans(p, size))
    assert len(blocks) > 5
    assert all(one.upto == other.after for one, other in pairwise(blocks))
    for number, block in enumerate(blocks):
        assert list(class_spans(p, size, block.after)) == blocks[number:]
        within = (block.after + block.upto) // 2  # where blocks of another size may have ended
        assert list(class_spans(p, size, within)) == [block._replace(after=within), *blocks[number + 1 :]]
    assert list(class_spans(p, size, block.upto)) == [block._replace(after=block.upto)]


def test_an_interrupted_sweep_has_the_bits_of_an_undisturbed_one(tmp_path, monkeypatch):
    """The sweep is stopped after each of its blocks in turn, and after every block."""
    monkeypatch.setattr(sweeps, "CLASSES", 40)
    whole = found(tmp_path / "whole.db", periods=[8])
    blocks = len(list(class_spans(8, 40)))
    for cuts in [[1] * blocks, *([block] for block in range(1, blocks))]:
        path = tmp_path / f"{cuts}.db"
        migrate(path)
        for block in cuts:
            going = sweep_periods(path, 1.6, [8])
            list(islice(going, block))
            going.close()
        assert found(path, periods=[8]) == whole


def test_a_sweep_that_lost_words_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("orbitdb.symbols.enumeration.least_words", lambda span: iter(()))
    migrate(tmp_path / "orbits.db")
    with pytest.raises(StoreError, match="period 3 has 0 words instead of 8"):
        list(sweep_periods(tmp_path / "orbits.db", 1.6, [3]))
