"""How periods are cut into blocks: every word once, in order, smaller ones where several processes wait."""

from itertools import groupby, pairwise

import pytest
from quick import slow_but

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.filling.birth_blocks import BirthBlock, birth_blocks
from orbitdb.filling.blocks import Block, cut_into_blocks
from orbitdb.filling.enclosures import Enclosed, EnclosureTask
from orbitdb.filling.swept_blocks import SweptBlock
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.symmetry import SIZES


def words_of(block: BirthBlock) -> int:
    return sum(int(SIZES[each.stabiliser].sum()) for span in block.spans for each in least_words(span))


@pytest.mark.parametrize("jobs", slow_but([4], [1, 2, 4]))
def test_blocks_of_births_hold_every_class_once_and_small_periods_together(jobs):
    blocks = list(birth_blocks([(p, -1) for p in range(2, 12)], 8000, jobs))
    assert blocks[0].spans == tuple(map(Span.whole, range(2, 7)))  # with p = 7 more than an eighth
    assert blocks[1].spans[:2] == tuple(map(Span.whole, (7, 8)))
    spans = [span for block in blocks for span in block.spans]
    cut = {p: list(part) for p, part in groupby(spans, lambda span: span.p)}
    assert list(cut) == list(range(2, 12))
    for p, parts in cut.items():
        assert (parts[0].after, parts[-1].upto) == (-1, Span.whole(p).upto)
        assert all(one.upto == other.after for one, other in pairwise(parts))
    sizes = [words_of(block) for block in blocks]
    assert sum(sizes) == sum(map(count_admissible, range(2, 12)))
    assert max(sizes) <= 8000
    assert all(one + other > 8000 / min(jobs, 2) for one, other in pairwise(sizes[1:]))


def test_the_first_block_of_births_is_filled_to_the_last_word():
    """The words of p = 2..6 are 389."""
    assert len(list(birth_blocks([(p, -1) for p in range(2, 7)], 8 * 389, 1))) == 1
    assert len(list(birth_blocks([(p, -1) for p in range(2, 7)], 8 * 389 - 1, 1))) == 2


def test_what_was_begun_goes_on_where_it_was():
    (block,) = birth_blocks([(3, -1), (4, 200), (5, -1)], 8000, 1)
    assert block.spans == (Span.whole(3), Span.whole(4, 200), Span.whole(5))


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
    found = block.solved()
    for each in [found] if isinstance(found, Enclosed) else found:
        assert each.arithmetic == arithmetic()


@pytest.mark.parametrize("prove", [False, True])
def test_a_task_encloses_the_entropy_as_a_search_does(prove):
    found = EnclosureTask(1.6, 4, prove=prove).solved()
    assert found.levels == tuple(search(Stadium(1.6), 4))
    assert (found.proved > 0, found.seconds > 0, found.left_open) == (prove, prove, 0)
    assert len(EnclosureTask(1.6, width=0.5, prove=prove).solved().levels) < len(found.levels)
