"""All likely ways of numbering a list of levels: which are true, and how many are missing before each.

A *path* numbers the levels one after another. Its state after a level is the number of levels missing so far,
the last true level, and the residuals at the last grid points, from which the next ones are predicted. States
in which all three agree are merged. Only the most probable states are kept (a beam). Going back from the last
level then gives the probability of every step, and paths drawn at random.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.staircase_errors import BEFORE, Whitening

BACK = 3
"""How far back the last true level can be: at most two spurious levels are in a row."""
_SETTLED, _REACH, _AHEAD = 2.5, 3.5, 1.0
"""Distances in units of 1/X. Missing levels do not change points farther below them than the first, and
change those farther above them than the second by 1. Points below a level by at least the third count in the
choice of states, although later missing levels may change them."""
CROWDED = 5.0
"""Number of levels within 1/X from which on a list is crowded: single gaps cannot be named."""
_SAME, _SAME_MOST, _SHORT = 0.05, 0.2, 3
"""Residuals that differ by less are the same: usually, and at most in crowded lists; their memory there."""
_CHUNK = 256


class Detail(NamedTuple):
    """How different two states must be to be kept apart.

    Attributes
    ----------
    same : float
        Residuals that differ by less are the same; their standard deviations are 0.03 and more.
    memory : int
        Number of points, up to BEFORE, from which the next one is predicted.
    """

    same: float = _SAME
    memory: int = BEFORE


def detail(crowded: float) -> Detail:
    """Return how different two states must be to be kept apart, given the number of levels within 1/X.

    In a crowded list, a missing level can have many places, so states are merged more coarsely, and sooner.
    The rounding of the residuals counts as noise.
    """
    if crowded <= CROWDED:
        return Detail()
    return Detail(min(_SAME * crowded / CROWDED, _SAME_MOST), _SHORT)


class Beam(NamedTuple):
    """Which states to keep: the largest distance of ln P from the best state, and the maximum number."""

    depth: float
    states: int


class Steps(NamedTuple):
    """The steps from one true level to the next, or over a spurious level, that are tried.

    Attributes
    ----------
    start : ndarray of int, shape (BACK n + 1,)
        The steps to level i, if the last true level is i - b, are those from ``start[BACK i + b - 1]`` to the
        next start.
    level, back, missing : ndarray of int, shape (N,)
        The level, b, and the number of levels missing between the two; -1 if the level is spurious.
    low : ndarray, shape (N,)
        k of the last true level.
    log_weight : ndarray, shape (N,)
        ln P of the step without the orbits.
    """

    start: Integers
    level: Integers
    back: Integers
    missing: Integers
    low: Floats
    log_weight: Floats


class Data(NamedTuple):
    """What paths are compared with.

    Attributes
    ----------
    k : ndarray, shape (n,)
        The levels of the list.
    grid, difference : ndarray, shape (G,)
        Evenly spaced points, and the number of levels below them according to the orbits, minus that of the
        list smoothed with the same X.
    cutoff : float
        X.
    white : Whitening
    tau2 : float
        Variance of the deviations.
    detail : Detail
    """

    k: Floats
    grid: Floats
    difference: Floats
    cutoff: float
    white: Whitening
    tau2: float
    detail: Detail = Detail()

    def places(self, distance: float) -> Integers:
        """Return the first grid point above each level plus a distance in units of 1/X."""
        return np.searchsorted(self.grid, self.k + distance / self.cutoff)


class Edges(NamedTuple):
    """The steps between states that were kept, in the order of the later states, with ln P at their ends.

    `alpha` has ln P of each later state, `score` that of each step.
    """

    child: NDArray[np.int32]
    parent: NDArray[np.int32]
    step: NDArray[np.int32]
    score: Floats
    alpha: Floats


class _States(NamedTuple):
    """States after a level: missing levels so far, how far back the last true level is, and ln P.

    `added` is what the missing and spurious levels add to the staircase at the grid points from `low` on;
    beyond, they add `net`. `rank` is `alpha`, less the misfit at the points ahead.
    """

    net: Integers
    back: Integers
    alpha: Floats
    rank: Floats
    added: Floats
    low: int


@dataclass(frozen=True)
class Forward:
    """The edges of each level, ln P of the list, and the number missing below it for each starting state."""

    edges: list[Edges]
    log_evidence: float
    firsts: Integers


def forward(data: Data, steps: Steps, firsts: Integers, beam: Beam) -> Forward:
    """Follow the likely paths from the first to the last level.

    `firsts` are the numbers of levels that may be missing below the list, shape (F,).
    """
    n, points = len(data.k), len(data.grid)
    # changed[i]: first point that the steps to level i change; ends[i]: first point that they change by 1
    changed = np.append(np.concatenate([np.zeros(BACK, np.int64), data.places(-_SETTLED)])[:n], points)
    ends, ahead = data.places(_REACH), data.places(-_AHEAD)
    mixing = np.random.default_rng(0).integers(-(2**30), 2**30, points).astype(np.float64)
    zeros = np.zeros(len(firsts))
    states = _States(firsts, np.ones(len(firsts), np.int64), zeros, zeros, np.empty((len(firsts), 0)), 0)
    edges = []
    for first in range(0, n, _CHUNK):
        added = _added(data, steps, range(first, min(first + _CHUNK, n)), changed, ends)
        begins = int(steps.start[BACK * first])
        for i in range(first, min(first + _CHUNK, n)):
            parent, row, score = _continued(states, steps, i, beam.depth)
            span = slice(int(changed[i]), int(ends[i]))
            settled = int(changed[i + 1])
            new = _after(
                states, steps, parent, row, added[row - begins, : span.stop - span.start], span, settled
            )
            new = _weighed(data, new, score, span.start, settled, max(settled, int(ahead[i])))
            states, kept = _kept(new, parent, row, settled, mixing, beam, data.detail)
            edges.append(kept)
    constant = float(data.white.log_scale.sum()) + points * math.log(data.tau2) / 2
    return Forward(edges, float(np.logaddexp.reduce(states.alpha)) - constant, firsts)


def _added(data: Data, steps: Steps, levels: range, changed: Integers, ends: Integers) -> Floats:
    """Return what the steps to some levels add to the staircase, from the first point that each changes on.

    Missing levels lie evenly in their gap.
    """
    inside = slice(levels[0], levels[-1] + 1)
    rows = slice(int(steps.start[BACK * inside.start]), int(steps.start[BACK * inside.stop]))
    level, missing, low = steps.level[rows], steps.missing[rows], steps.low[rows]
    width = max(1, int((ends[inside] - changed[inside]).max()))
    point = data.grid[0] + (data.grid[1] - data.grid[0]) * (changed[level][:, None] + np.arange(width))
    added = np.zeros((len(level), width))
    spurious = missing < 0
    added[spurious] = -ndtr(data.cutoff * (point[spurious] - data.k[level[spurious], None]))
    for m in np.unique(missing[missing > 0]).tolist():
        (some,) = np.nonzero(missing == m)
        spacing = (data.k[level[some]] - low[some]) / (m + 1)
        for j in range(1, m + 1):
            added[some] += ndtr(data.cutoff * (point[some] - (low[some] + j * spacing)[:, None]))
    return added


def _continued(states: _States, steps: Steps, i: int, depth: float) -> tuple[Integers, Integers, Floats]:
    """Return the state before, the row of the step, and ln P, for each likely step from states to level i."""
    place = BACK * i + states.back - 1
    first = steps.start[place]
    count = steps.start[place + 1] - first
    parent = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(parent)) + np.repeat(first + count - np.cumsum(count), count)
    weight = steps.log_weight[row]
    rank = states.rank[parent] + weight
    (likely,) = (rank > rank.max() - depth).nonzero()
    parent, row = parent[likely], row[likely]
    return parent, row, states.alpha[parent] + weight[likely]


def _after(
    states: _States, steps: Steps, parent: Integers, row: Integers, added: Floats, span: slice, settled: int
) -> _States:
    """Return the states after steps, which change the points in `span`."""
    missing = steps.missing[row]
    net = states.net[parent] + missing
    back = np.where(missing < 0, states.back[parent] + 1, 1)
    known = states.low + states.added.shape[1]
    total = np.empty((len(row), max(span.stop, settled, known) - states.low))
    total[:, : known - states.low] = states.added.take(parent, axis=0)
    total[:, known - states.low :] = states.net[parent, None]
    total[:, span.start - states.low : span.stop - states.low] += added
    total[:, span.stop - states.low :] = net[:, None]
    return _States(net, back, states.alpha, states.rank, total, states.low)


def _weighed(data: Data, states: _States, score: Floats, first: int, settled: int, ahead: int) -> _States:
    """Return the states with ln P of the points from `first` to `settled`, and the rank up to `ahead`."""
    residual = data.difference[states.low : ahead] - states.added[:, : ahead - states.low]
    off, alpha = np.zeros(len(score)), None
    for t in range(first, ahead):
        if t == settled:
            alpha = score - off / (2 * data.tau2)
        begins = max(t - BEFORE, states.low)
        inside = residual[:, begins - states.low : t + 1 - states.low]
        off += (inside @ data.white.weights[t, begins - t - 1 :]) ** 2
    rank = score - off / (2 * data.tau2)
    return states._replace(alpha=rank if alpha is None else alpha, rank=rank)


def _kept(
    states: _States, parent: Integers, row: Integers, settled: int, mixing: Floats, beam: Beam, fine: Detail
) -> tuple[_States, Edges]:
    """Merge equal states, keep the best, and return them and the steps to them."""
    (good,) = (states.rank > states.rank.max() - beam.depth).nonzero()
    low = max(settled - BEFORE, 0)
    added = states.added[:, low - states.low :].take(good, axis=0)
    key = _key(
        added[:, max(settled - fine.memory, 0) - low :], states.net[good], states.back[good], mixing, fine
    )
    order = key.argsort()
    new = np.append(True, np.diff(key[order]) != 0)
    (starts,) = new.nonzero()
    step, child = good[order], new.cumsum() - 1
    alpha = np.logaddexp.reduceat(states.alpha[step], starts)
    one = step[starts]  # one of the equal states stands for all
    rank = alpha + states.rank[one] - states.alpha[one]
    if len(rank) > beam.states:
        kept = np.sort(np.argpartition(-rank, beam.states)[: beam.states])
        place = np.full(len(rank), -1)
        place[kept] = np.arange(len(kept))
        (mine,) = (place[child] >= 0).nonzero()
        step, child = step[mine], place[child[mine]]
        starts, one, alpha, rank = starts[kept], one[kept], alpha[kept], rank[kept]
    after = _States(states.net[one], states.back[one], alpha, rank, added[order[starts]], low)
    small = np.int32  # there are many edges
    kept_step, kept_parent = row[step].astype(small), parent[step].astype(small)
    return after, Edges(child.astype(small), kept_parent, kept_step, states.alpha[step], alpha)


def _key(added: Floats, net: Integers, back: Integers, mixing: Floats, fine: Detail) -> Floats:
    """Return a number for each state that is the same if the states are, shape (N,)."""
    rounded = np.rint((added - net[:, None]) / fine.same)
    return np.asarray(rounded @ mixing[: rounded.shape[1]] + (net * BACK + back) * 15_485_863.0)  # integers


class Posterior(NamedTuple):
    """Probabilities of the steps, and paths drawn at random.

    Attributes
    ----------
    probability : ndarray, shape (N,)
        Probability of each of the `Steps`.
    drawn : ndarray of int32, shape (n, paths)
        For each path, the row of `Steps` with which it comes to each level.
    first : ndarray of int, shape (paths,)
        Number of levels missing below the list.
    entropy : float
        Of the paths: how much ln P of a path is below 0 on average.
    """

    probability: Floats
    drawn: NDArray[np.int32]
    first: Integers
    entropy: float = 0.0


def backward(passed: Forward, steps: Steps, paths: int, rng: np.random.Generator) -> Posterior:
    """Return the probability of each step given the whole list, and some paths drawn from these."""
    n = len(passed.edges)
    probability = np.zeros(len(steps.level))
    drawn: NDArray[np.int32] = np.empty((n, paths), np.int32)
    last = passed.edges[-1].alpha
    later = np.exp(last - np.logaddexp.reduce(last))
    entropy = -float(np.log(later[later > 0]) @ later[later > 0])
    states = rng.choice(len(later), paths, p=later / later.sum())
    for i in range(n - 1, -1, -1):
        edges = passed.edges[i]
        share = np.exp(edges.score - edges.alpha[edges.child])
        each = share * later[edges.child]
        rows = slice(int(steps.start[BACK * i]), int(steps.start[BACK * (i + 1)]))
        probability[rows] = np.bincount(edges.step - rows.start, each, rows.stop - rows.start)
        later = np.bincount(edges.parent, each, len(passed.edges[i - 1].alpha) if i else len(passed.firsts))
        below = np.append(0.0, np.cumsum(share))
        starts = np.searchsorted(edges.child, np.arange(len(edges.alpha) + 1))
        low, high = below[starts[states]], below[starts[states + 1]]
        chosen = np.searchsorted(below, low + rng.random(paths) * (high - low), "right") - 1
        chosen = np.clip(chosen, starts[states], starts[states + 1] - 1)
        drawn[i] = edges.step[chosen]
        entropy -= float(np.log(np.maximum(share[chosen], 1e-300)).mean())
        states = edges.parent[chosen]
    return Posterior(probability, drawn, passed.firsts[states], entropy)
