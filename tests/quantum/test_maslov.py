"""The Maslov index and amplitudes of single orbits, counted another way."""

import math

import numpy as np
import pytest
from there import there

from orbitdb import Stadium, solve_word
from orbitdb.billiard.stability import bounce_matrices
from orbitdb.symbols.words import from_strings

WORDS = ["13", "1232131", "0103155", "1155", "013", "0201232", "11335"]


def _foci(word: str, a: float) -> int:
    """Follow a wavefront bounce by bounce: return how often it comes to a focus in one period."""
    points = there(solve_word(word, a).points)
    path = np.roll(points, -1, axis=0) - points
    distance = np.hypot(*path.T)
    curvature, foci = 0.5, 0
    for bounce in range(40 * len(word)):
        n = bounce % len(word)
        if word[n] in "1345":
            centre = np.array([math.copysign(a, points[n, 0]), 0.0])
            cosine = abs((points[n] - centre) @ path[n]) / distance[n]
            curvature -= 2 / cosine
        behind = 1 + curvature * distance[n]
        foci += behind < 0 and bounce >= 39 * len(word)
        curvature /= behind
    return foci


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("a", [0.8, 1.6])
def test_maslov_index_counts_the_foci_of_a_wavefront_and_two_a_bounce(word, a):
    orbit = solve_word(word, a)
    if orbit.coordinates is None:
        assert orbit.amplitude(10.0) is None
    else:
        assert orbit.maslov == 2 * len(word) + _foci(word, a)


@pytest.mark.parametrize("word", ["13", "013", "0103155"])
@pytest.mark.parametrize("repetitions", [1, 2, 3])
def test_amplitude_is_that_of_the_monodromy_matrix(word, repetitions):
    orbit, k = solve_word(word, 1.6), 7.3
    length = there(orbit.length)
    matrices = bounce_matrices(Stadium(1.6), from_strings([word]), there(orbit.coordinates)[None])[0]
    whole = np.eye(2)
    for matrix in matrices:
        whole = matrix @ whole
    root = math.sqrt(abs(2 - np.trace(np.linalg.matrix_power(whole, repetitions))))
    phase = repetitions * (k * length - there(orbit.maslov) * math.pi / 2)
    assert orbit.amplitude(k, repetitions) == pytest.approx(length * math.cos(phase) / math.pi / root)


def test_orbits_are_gone_round_at_least_once():
    with pytest.raises(ValueError, match="1 or more"):
        solve_word("13", 1.6).amplitude(3.0, 0)
