"""How periods are cut into blocks: every word once, in order, smaller ones where several processes wait."""

from itertools import groupby, pairwise

import pytest

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.filling.birth_blocks import BirthBlock, birth_blocks
from orbitdb.filling.blocks import Block, cut_into_blocks
from orbitdb.filling.enclosures import EnclosureTask
from orbitdb.filling.swept_blocks import SweptBlock
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words


@pytest.mark.parametrize(
    ("jobs", "blocks"),
    [
        pytest.param(1, range(12, 17), marks=pytest.mark.slow),
        pytest.param(2, range(17, 21), marks=pytest.mark.slow),
        (4, range(21, 30)),
    ],
)
def test_blocks_of_births_hold_every_class_once_and_small_periods_together(jobs, blocks):
    periods = range(2, 12)
    soon, small, *rest = birth_blocks([(p, -1) for p in periods], 8000, jobs)
    assert soon.spans == tuple(map(Span.whole, range(2, 7)))  # 389 words: with p = 7 more than an eighth
    assert small.spans == tuple(map(Span.whole, (7, 8)))
    assert all(len(block.spans) == 1 for block in rest)
    spans = [block.spans[0] for block in rest]
    assert len(spans) in blocks
    cut = {p: list(part) for p, part in groupby(spans, lambda span: span.p)}
    assert list(cut) == [9, 10, 11]
    for p, parts in cut.items():
        assert (parts[0].after, parts[-1].upto) == (-1, Span.whole(p).upto)
        assert all(one.upto == other.after for one, other in pairwise(parts))
        counts = [sum(len(each.codes) for each in least_words(span)) for span in parts]
        assert max(counts) <= 8000 / 8
        assert all(one + other > 8000 / 8 / min(jobs, 2) for one, other in pairwise(counts))


def test_the_first_block_of_births_is_filled_to_the_last_word():
    """The words of p = 2..6 are 389."""
    assert len(list(birth_blocks([(p, -1) for p in range(2, 7)], 8 * 389, 1))) == 1
    assert len(list(birth_blocks([(p, -1) for p in range(2, 7)], 8 * 389 - 1, 1))) == 2


def test_what_was_begun_is_a_block_of_its_own():
    begun, *rest = birth_blocks([(4, 200), (5, -1), (6, -1)], 390, 1)
    assert begun.spans == (Span.whole(4, 200),)
    assert [block.spans for block in rest] == [(Span.whole(5), Span.whole(6))]
    small, begun, *rest = birth_blocks([(3, -1), (4, 200), (5, -1), (6, -1)], 390, 1)
    assert (small.spans, begun.spans) == ((Span.whole(3),), (Span.whole(4, 200),))
    assert [block.spans for block in rest] == [(Span.whole(5), Span.whole(6))]


def test_for_several_jobs_a_period_is_cut_smaller_down_to_a_quarter():
    counts = {jobs: len(list(cut_into_blocks(1.6, "newton", 12, -1, jobs))) for jobs in (1, 2, 3, 8, 99)}
    assert counts[1] < counts[2] < counts[3] < counts[8] == counts[99] < 5 * counts[1]
    assert count_admissible(12) / counts[1] < 1 << 16
    behind = next(cut_into_blocks(1.6, "newton", 12, 10**9, 8)).span
    assert behind.after == 10**9


@pytest.mark.parametrize(
    "block",
    [
        Block(1.6, "newton", Span.whole(3)),
        BirthBlock((Span.whole(3),)),
        SweptBlock(1.6, Span.whole(3)),
        EnclosureTask(1.6, 3),
    ],
    ids=lambda block: type(block).__name__,
)
def test_what_is_solved_apart_says_what_has_computed_it(block):
    assert block.solved().arithmetic == arithmetic()


@pytest.mark.parametrize("prove", [False, True])
def test_a_task_encloses_the_entropy_as_a_search_does(prove):
    found = EnclosureTask(1.6, 4, prove=prove).solved()
    assert found.levels == tuple(search(Stadium(1.6), 4))
    assert (found.proved > 0, found.seconds > 0, found.left_open) == (prove, prove, 0)
    assert len(EnclosureTask(1.6, width=0.5, prove=prove).solved().levels) < len(found.levels)
