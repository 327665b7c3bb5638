"""Levels compared with exact levels of other shapes, with finer grids, and with another method."""

import math
import os
import subprocess
import sys

import numpy as np
import pytest
from quick import fuzz_but, slow_but
from scipy.linalg import qr, svd
from scipy.optimize import minimize_scalar
from scipy.special import jv

from orbitdb import InputError, Stadium
from orbitdb.quantum.condensation import Interiors, eigenfunctions
from orbitdb.quantum.elements import grid, quarter_disc, quarter_stadium
from orbitdb.quantum.exact_levels import LevelTask, level_tasks, levels
from orbitdb.quantum.weyl import Parity, weyl


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "parity"),
    fuzz_but([(1.6, "ee"), (0.05, "eo")], [(1.6, "oo"), (1.6, "ee"), (0.05, "eo"), (20.0, "ee")]),
)
@pytest.mark.parametrize("high", [9.0, 17.9])
def test_levels_agree_with_a_finer_grid_within_their_errors(a, parity, high):
    task = LevelTask(a, Parity(parity), max(high - 6 / (a + 0.5), 0.0), high)
    found = task.solved()
    finer = Interiors(grid(quarter_stadium(a, 0.25, 3), 20))
    _, k2, _ = eigenfunctions(finer, task.fixed, task.low**2, task.high**2)
    off = np.abs(found.k - np.sqrt(k2))
    assert (off <= found.error).all()
    assert (found.error <= 50 * np.maximum(off, 2e-16 * found.k)).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "parity", "high"),
    fuzz_but([(0.5, "ee", 35.9)], [(0.5, "ee", 35.9), (1.6, "eo", 35.9), (0.5, "oo", 53.9)]),
)
def test_errors_hold_where_the_degree_is_too_low(a, parity, high):
    task = LevelTask(a, Parity(parity), high - 3, high)
    for order in (14, 16):
        found, finer = task.solved(order, 1), task.solved(20, 2)
        assert (found.below, len(found.k)) == (finer.below, len(finer.k))
        off = np.abs(found.k - finer.k)
        assert (off <= found.error).all()
        assert np.median(found.error / np.maximum(off, 2e-16 * found.k)) < 50


@pytest.mark.slow
@pytest.mark.parametrize(("a", "low", "high"), [(0.3, 37.8, 37.99), (0.05, 37.0, 37.99), (0.05, 33.0, 35.99)])
def test_errors_stay_near_rounding_up_to_the_largest_k_of_a_grid(a, low, high):
    found = LevelTask(a, Parity.EE, low, high).solved()
    assert len(found.k)
    assert (found.error < 5e-14 * found.k).all()


@pytest.mark.parametrize("parity", Parity)
def test_level_counts_agree_with_the_full_matrix_even_at_poles(parity):
    """The full stiffness matrix comes from functions that are 1 at one node and 0 at all others."""
    task, made = LevelTask(0.5, parity, 0.0, 9.0), grid(quarter_disc(0.5, 0.5), 6)
    fixed = np.bincount(made.node.ravel(), task.fixed(made.points).ravel()) > 0
    mass = np.bincount(made.node.ravel(), made.weight.ravel())
    free = np.flatnonzero(~fixed)
    hats = (made.node == free[:, None, None, None]) / np.sqrt(mass[made.node])
    slopes = made.gradient(hats).swapaxes(0, 1).reshape(len(free), -1)
    whole, elements = np.linalg.eigvalsh(slopes @ slopes.T), Interiors(made)
    for pole in elements.levels.ravel()[::9]:
        for end in (pole, 1.3 * pole, *(pole * (1 + np.array([-1e-9, 1e-9, 1e-5])))):
            below, values, _ = eigenfunctions(elements, task.fixed, end, 1.01 * end)
            assert below in {(whole < end * (1 - 1e-6)).sum(), (whole < end).sum()}
            inside = whole[below : below + len(values)]
            np.testing.assert_allclose(values, inside, rtol=1e-9)


def _number(low: float, high: float, order: int = 8) -> tuple[int, int]:
    """Return the number of levels below a window, and the number in the window."""
    found = LevelTask(0.5, Parity.EE, low, high).solved(order, 1)
    assert ((low <= found.k) & (found.k < high)).all()
    return found.below, len(found.k)


@pytest.fixture(scope="module")
def lowest() -> float:
    """The lowest level of parity ee at a = 0.5."""
    (k,) = LevelTask(0.5, Parity.EE, 0.0, 2.0).solved(8, 1).k
    return float(k)


@pytest.mark.parametrize("places", [-2, 0, 2])
def test_a_level_at_the_end_of_a_window_belongs_to_the_window_above(places, lowest):
    """This includes levels off by a few units in the last place, as from another grid or processor."""
    end = lowest + places * np.spacing(lowest)
    assert _number(0.0, end) == (0, 0)
    assert _number(end, 2.0) == (0, 1)
    assert _number(end, 2.0, order=10) == (0, 1)


@pytest.mark.parametrize("value", slow_but(1, range(3)))
def test_eigenvalues_at_an_end_are_found_as_counted(value):
    """Rounding decides between the two sides of an end; the values found must be on the same side."""
    task = LevelTask(0.5, Parity.EE, 0.0, 5.0)
    elements = task.elements(8, 1)
    _, known, _ = eigenfunctions(elements, task.fixed, 0.0, 25.0)
    for places in range(-4, 5):
        end = known[value] + places * np.spacing(known[value])
        below, above, _ = eigenfunctions(elements, task.fixed, end, 25.0)
        zero, under, _ = eigenfunctions(elements, task.fixed, 0.0, end)
        assert (zero, len(under), below + len(above)) == (0, below, len(known))
        assert below in {value, value + 1}
        np.testing.assert_allclose([*under, *above], known, rtol=1e-12)


@pytest.mark.parametrize("off", [-1e-8, 1e-8])
def test_a_level_close_to_an_end_stays_on_its_side(off, lowest):
    assert _number(lowest * (1 + off), 2.0) == ((0, 1) if off < 0 else (1, 0))


def test_the_error_of_a_level_includes_its_shift_to_an_end(lowest):
    end = lowest * (1 + 5e-11)
    found = LevelTask(0.5, Parity.EE, end, 2.0).solved(8, 1)
    assert found.k.tolist() == [end]
    assert found.error[0] >= end - lowest


@pytest.mark.slow
def test_levels_do_not_depend_on_the_threads_of_linear_algebra():
    program = (
        "from orbitdb import levels; found = levels(1.6, 4); print(found.k.tolist(), found.error.tolist())"
    )
    told = [
        subprocess.check_output(
            [sys.executable, "-c", program], env=os.environ | {"OPENBLAS_NUM_THREADS": number}
        )
        for number in ("1", "2")
    ]
    assert told[0] == told[1]


@pytest.mark.slow
def test_a_window_between_two_levels_is_solved():
    task = LevelTask(1.6, Parity.OE, 2.0265300566195372, 2.4751285339189684)
    assert task.solved().k == pytest.approx([2.0265300566], abs=1e-9)


@pytest.mark.slow
def test_windows_leave_no_gap_and_follow_weyls_law():
    found = [task.solved() for task in level_tasks(Stadium(1.6), Parity.OO, 0.0, 27.0)]
    assert len(found) > 1
    assert [each.low for each in found[1:]] == [each.high for each in found[:-1]]
    assert [each.below for each in found] == [sum(len(one.k) for one in found[:n]) for n in range(len(found))]
    k, places = np.concatenate([each.k for each in found]), np.linspace(0, 27, 2000)
    assert levels(1.6, 27.0, parity=("oo",)).k.tolist() == k.tolist()
    off = np.searchsorted(k, places) - weyl(Stadium(1.6), Parity.OO)(places)
    assert abs(off.mean()) < 0.05
    assert np.abs(off).max() < 2.7


def _smallest(k: float, a: float) -> float:
    """Return the smallest singular value in the method of particular solutions, for parity oo."""
    s = np.linspace(0.01, 0.99, 60)
    edge = np.concatenate([a * s + 1j, a + np.exp(0.5j * math.pi * s)])
    inside = 0.9 * edge * np.linspace(0.2, 0.9, 120)
    order = np.arange(2, 50, 2)

    def values(at):
        return jv(order, k * np.abs(at)[:, None]) * np.sin(order * np.angle(at)[:, None])

    orthogonal, _ = qr(np.concatenate([values(edge), values(inside)]), mode="economic")
    return float(svd(orthogonal[: len(edge)], compute_uv=False)[-1])


@pytest.mark.slow
def test_particular_solutions_find_the_same_levels():
    """Source: T. Betcke and L. N. Trefethen, SIAM Review 47 (2005) 469."""
    found = levels(0.3, 9.0, parity=("oo",))
    assert abs(len(found.k) - weyl(Stadium(0.3), Parity.OO)(9.0)) < 1
    assert found.error.max() < 1e-9
    for k in found.k:
        best = minimize_scalar(_smallest, bounds=(k - 0.02, k + 0.02), args=(0.3,), method="bounded",
                               options={"xatol": 1e-9})  # fmt: skip
        assert abs(best.x - k) < 1e-4


@pytest.mark.parametrize(("a", "low", "high"), [(0.01, 0, 5), (30, 0, 5), (1, 5, 5), (1, -1, 5), (1, 0, 1e4)])
def test_untested_ranges_are_refused(a, low, high):
    with pytest.raises(InputError, match="give"):
        list(level_tasks(Stadium(a), Parity.EE, low, high))
