"""The levels of the stadium against shapes with known levels, finer grids, and another method."""

import math

import numpy as np
import pytest
from quick import fuzz_but
from scipy.linalg import qr, svd
from scipy.optimize import minimize_scalar
from scipy.special import jv

from orbitdb import InputError, Stadium
from orbitdb.quantum.amplitudes import Parity, weyl
from orbitdb.quantum.elements import eigenvalues, grid
from orbitdb.quantum.levels import LevelTask, levels, windows
from orbitdb.quantum.mesh import quarter_stadium


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "parity"),
    fuzz_but([(1.6, "ee"), (0.05, "eo")], [(1.6, "oo"), (1.6, "ee"), (0.05, "eo"), (4.0, "oe")]),
)
def test_levels_agree_with_a_finer_grid_within_their_errors(a, parity):
    task = LevelTask(a, Parity(parity), 0.0, 9.0)
    found = task.solved()
    cells = quarter_stadium(a, 0.25, 4)
    _, finer = eigenvalues(grid(cells, 18, task.fixed).root, 0.0, 81.0)
    assert len(finer) == len(found.k)
    assert (np.abs(found.k - np.sqrt(finer)) <= found.error).all()
    assert found.error.max() < 1e-9


_GRID = (8, 1)


def _number(low: float, high: float, order: int = 8) -> tuple[int, int]:
    """Return the number of levels below a window, and in it."""
    below, k = LevelTask(0.5, Parity.EE, low, high).on_grid(order, 1)
    assert ((low <= k) & (k < high)).all()
    return below, len(k)


@pytest.mark.parametrize("places", [-2, 0, 2])
def test_a_level_on_an_end_belongs_to_the_window_above_it(places):
    """So does a level a few floats away, which another grid or processor may give."""
    _, (k,) = LevelTask(0.5, Parity.EE, 0.0, 2.0).on_grid(*_GRID)
    end = k + places * np.spacing(k)
    assert _number(0.0, end) == (0, 0)
    assert _number(end, 2.0) == (0, 1)
    assert _number(end, 2.0, order=10) == (0, 1)


@pytest.mark.parametrize("off", [-1e-8, 1e-8])
def test_a_level_close_to_an_end_stays_on_its_side(off):
    _, (k,) = LevelTask(0.5, Parity.EE, 0.0, 2.0).on_grid(*_GRID)
    assert _number(k * (1 + off), 2.0) == ((0, 1) if off < 0 else (1, 0))


@pytest.mark.parametrize("coarse", [(4, 1), (8, 1)], ids=["differing grids", "rounding alone"])
def test_the_stated_error_is_twice_the_difference_of_two_grids_and_rounding(monkeypatch, coarse):
    """With coarser grids than usual, whose levels differ by more than rounding, or not at all."""
    fine = (8, 1)
    monkeypatch.setattr("orbitdb.quantum.levels._FINE", fine)
    monkeypatch.setattr("orbitdb.quantum.levels._COARSE", coarse)
    task = LevelTask(0.5, Parity.EE, 0.0, 2.0)
    found, (_, k), (_, other) = task.solved(), task.on_grid(*fine), task.on_grid(*coarse)
    assert len(k) == 1
    assert found.k == pytest.approx(k, rel=1e-13, abs=0)
    assert found.error == pytest.approx(2 * np.abs(k - other) + 2e-12 * k, rel=0.05, abs=0)


@pytest.mark.slow
def test_a_window_between_two_levels_is_solved():
    task = LevelTask(1.6, Parity.OE, 2.0265300566195372, 2.4751285339189684)
    assert task.solved().k == pytest.approx([2.0265300566], abs=1e-9)


@pytest.mark.slow
def test_windows_meet_without_a_gap_and_follow_weyls_law():
    found = [task.solved() for task in windows(Stadium(1.6), Parity.OO, 0.0, 27.0)]
    assert len(found) > 1
    assert [each.low for each in found[1:]] == [each.high for each in found[:-1]]
    assert [each.below for each in found] == [sum(len(one.k) for one in found[:n]) for n in range(len(found))]
    k, places = np.concatenate([each.k for each in found]), np.linspace(0, 27, 2000)
    assert levels(1.6, 27.0, parities=("oo",)).k.tolist() == k.tolist()
    off = np.searchsorted(k, places) - weyl(Stadium(1.6), Parity.OO)(places)
    assert abs(off.mean()) < 0.05
    assert np.abs(off).max() < 2.7


def _smallest(k: float, a: float) -> float:
    """Return the smallest singular value of the method of particular solutions, odd in x and y."""
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
    found = levels(0.3, 9.0, parities=("oo",))
    assert abs(len(found.k) - weyl(Stadium(0.3), Parity.OO)(9.0)) < 1
    assert found.error.max() < 1e-9
    for k in found.k:
        best = minimize_scalar(_smallest, bounds=(k - 0.02, k + 0.02), args=(0.3,), method="bounded",
                               options={"xatol": 1e-9})  # fmt: skip
        assert abs(best.x - k) < 1e-4


@pytest.mark.parametrize(("a", "low", "high"), [(0.01, 0, 5), (30, 0, 5), (1, 5, 5), (1, -1, 5), (1, 0, 1e4)])
def test_untested_ranges_are_refused(a, low, high):
    with pytest.raises(InputError, match="give"):
        list(windows(Stadium(a), Parity.EE, low, high))
