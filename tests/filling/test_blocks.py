"""How periods are cut into blocks: every word once, in order, smaller ones where several processes wait."""

import pytest

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.filling.blocks import BirthBlock, Block, cut_into_blocks
from orbitdb.filling.enclosures import EnclosureTask
from orbitdb.filling.swept_blocks import SweptBlock
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span


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
        BirthBlock(Span.whole(3)),
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
