"""How periods are cut into blocks: every word once, in order, smaller ones where several processes wait."""

from functools import partial

import pytest

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.filling.births import solve_births
from orbitdb.filling.blocks import METHODS, cut_into_blocks, solve_block
from orbitdb.filling.enclosures import enclose
from orbitdb.filling.sweeps import solve_swept
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span


def test_for_several_jobs_a_period_is_cut_smaller_down_to_a_quarter():
    counts = {jobs: len(list(cut_into_blocks(1.6, "newton", 12, -1, jobs))) for jobs in (1, 2, 3, 8, 99)}
    assert counts[1] < counts[2] < counts[3] < counts[8] == counts[99] < 5 * counts[1]
    assert count_admissible(12) / counts[1] < 1.5 * METHODS["newton"].words
    behind = next(cut_into_blocks(1.6, "newton", 9, 10**8, 8))().span
    assert behind.after == 10**8


@pytest.mark.parametrize(
    "block",
    [
        partial(solve_block, 1.6, "newton", False, Span.whole(3)),
        partial(solve_births, Span.whole(3)),
        partial(solve_swept, 1.6, "", {}, Span.whole(3)),
        partial(enclose, 1.6, 3),
    ],
    ids=lambda block: block.func.__name__,
)
def test_what_is_solved_apart_says_what_has_computed_it(block):
    assert block().arithmetic == arithmetic()


@pytest.mark.parametrize("prove", [False, True])
def test_a_task_encloses_the_entropy_as_a_search_does(prove):
    found = enclose(1.6, 4, prove=prove)
    assert found.levels == tuple(search(Stadium(1.6), 4))
    assert (found.proved > 0, found.seconds > 0, found.left_open) == (prove, prove, 0)
    assert len(enclose(1.6, width=0.5, prove=prove).levels) < len(found.levels)
