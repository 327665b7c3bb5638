"""No stored number depends on a setting that other threads of the process change, or that the user chose."""

import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from flint import ctx
from threadpoolctl import threadpool_info

from orbitdb import solve_word
from orbitdb.billiard import arithmetic
from orbitdb.quantum.condensation import one_thread

JOINTS = ("011032", "011033", "011332", "011333", "012032", "111333")
"""Orbits through a joint at a = 1, which only ball arithmetic decides."""


@pytest.fixture
def many_switches():
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.slow
@pytest.mark.usefixtures("many_switches")
def test_ball_arithmetic_does_not_depend_on_the_users_precision_and_restores_it():
    def solved(word: str) -> list[float | None]:
        orbit = solve_word(word, 1.0)
        return [orbit.length, orbit.length_error, orbit.lyapunov, orbit.lyapunov_error, orbit.error]

    alone = [solved(word) for word in JOINTS]
    with ctx.workprec(300), ThreadPoolExecutor(4) as threads:
        assert list(threads.map(solved, JOINTS * 10)) == alone * 10
        assert ctx.prec == 300


def blas_threads() -> set[int]:
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


def test_linear_algebra_has_one_thread_while_levels_are_computed_and_then_the_users_number():
    """The second computation begins before the first ends, and ends after it."""
    begun = threading.Event()

    def second() -> set[int]:
        begun.set()
        with one_thread():
            time.sleep(0.05)
            return blas_threads()

    before = blas_threads()
    with ThreadPoolExecutor(1) as threads:
        with one_thread():
            later = threads.submit(second)
            assert begun.wait(60)
            time.sleep(0.05)
        assert later.result() == {1}
    assert blas_threads() == before


def test_a_processor_without_vector_instructions_has_a_name(monkeypatch):
    """NumPy then leaves out the list of those it found."""
    monkeypatch.setattr(np, "show_config", lambda mode: {"SIMD Extensions": {"baseline": ["SSE"]}})
    assert arithmetic.arithmetic.__wrapped__().startswith("bounds ")
