"""The action of paths of arcs, its derivatives, and the stability of orbits, by independent computations."""

import numpy as np
import pytest
from field_map import arclength_of, next_bounce, sine_of, start_at
from in_field import A, followed, orbits_at, paths_at, states
from solutions import representatives, solved, words_of
from there import there

from orbitdb import solve_word
from orbitdb.billiard.stadium import Stadium
from orbitdb.magnetic.action import area_slopes, derivatives_of_action
from orbitdb.magnetic.along_kappa import follow_in_field
from orbitdb.magnetic.flow import stability
from orbitdb.orbits.solve import solve


def near_orbits(kappa, off=0.02):
    """Return words and bounces that are near those of orbits, but do not obey the law of reflection."""
    words = words_of(6)
    rng = np.random.default_rng(7)
    return words, solved(6, A).coordinates + rng.uniform(-off, off, words.shape)


def length_and_area(points, kappa):
    """Return length and area of a closed path of arcs, from the centres of their circles."""
    ahead = np.roll(points, -1, axis=0)
    chord = ahead - points
    reach = np.sqrt(1 / kappa**2 - (chord**2).sum(axis=1) / 4)
    left = np.stack([-chord[:, 1], chord[:, 0]], axis=1) / np.linalg.norm(chord, axis=1)[:, None]
    centre = (points + ahead) / 2 + np.sign(kappa) * reach[:, None] * left
    begin, end = points - centre, ahead - centre
    turn = np.arctan2(begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0], (begin * end).sum(axis=1))
    sectors = (turn - np.sin(turn)) / 2 / kappa**2
    polygon = (points[:, 0] * ahead[:, 1] - points[:, 1] * ahead[:, 0]).sum() / 2
    return np.abs(turn).sum() / abs(kappa), polygon + sectors.sum()


@pytest.mark.parametrize("kappa", [0.02, 0.1, 0.3, -0.2])
def test_length_area_and_action_are_those_of_circles(kappa):
    words, places = near_orbits(kappa)
    paths = paths_at(words, places, kappa)
    points = Stadium(A).points(words, places)
    length, area = np.array([length_and_area(path, kappa) for path in points]).T
    assert paths.lengths == pytest.approx(length, rel=1e-11)
    assert paths.areas == pytest.approx(area, abs=1e-9)
    assert paths.actions == pytest.approx(length - kappa * area, rel=1e-10)


@pytest.mark.parametrize("kappa", [1e-12, 1e-7, 1e-3, 0.01, 0.0385, 0.039])
def test_nothing_cancels_in_a_weak_field(kappa):
    """L - S = kappa A to the last digits; the area is summed as a series for some of these chords."""
    words, places = near_orbits(kappa)
    paths = paths_at(words, places, kappa)
    assert paths.lengths - paths.actions == pytest.approx(kappa * paths.areas, abs=4e-15 * 30)
    straight = paths_at(words, places, 0.0)
    assert paths.areas == pytest.approx(straight.areas, abs=60 * kappa + 1e-13)
    chords = (straight.chord**3).sum(axis=0)
    if kappa < 1e-5:
        assert (paths.areas - straight.areas) / kappa == pytest.approx(chords / 12, abs=1e-14 / kappa + 1e-3)


@pytest.mark.parametrize("kappa", [0.0, 0.05, 0.3, -0.2])
def test_the_derivatives_are_differences_of_the_action(kappa):
    words, places = near_orbits(kappa)
    slopes = derivatives_of_action(paths_at(words, places, kappa))
    p, h = words.shape[1], 1e-5
    for n in range(p):
        step = h * (np.arange(p) == n)
        up, down = (paths_at(words, places + way * step, kappa) for way in (1, -1))
        assert (up.actions - down.actions) / 2 / h == pytest.approx(slopes.gradient[n], abs=1e-8)
        rise = (derivatives_of_action(up).gradient - derivatives_of_action(down).gradient) / 2 / h
        assert rise[n] == pytest.approx(slopes.diagonal[n], abs=1e-7)
        assert rise[(n + 1) % p] == pytest.approx(slopes.couplings[n], abs=1e-7)
        assert rise[(n + 2) % p] == pytest.approx(0, abs=1e-7)
    more, less = (derivatives_of_action(paths_at(words, places, kappa + way * h)).gradient for way in (1, -1))
    assert (more - less) / 2 / h == pytest.approx(slopes.in_kappa, abs=1e-7)


@pytest.mark.parametrize("kappa", [0.05, 0.2, -0.3])
def test_the_monodromy_is_a_difference_of_the_map(kappa):
    """The map of arc length and tangential momentum preserves areas, and so has the same trace."""
    words, places = followed(5, kappa)
    begin = states(words, places, kappa)
    first = begin.mapped(lambda column: column[:, 0])
    s, sine = arclength_of(A, first), sine_of(A, first)

    def turned(s, sine):
        state = start_at(A, s, sine)
        for _ in range(words.shape[1]):
            state = next_bounce(A, kappa, state)
        return arclength_of(A, state), sine_of(A, state)

    with np.errstate(invalid="ignore"):
        back = turned(s, sine)
        closed = np.abs(back[0] - s) + np.abs(back[1] - sine) < 1e-7
        h = 1e-7
        ds = [turned(s + way * h, sine)[0] for way in (1, -1)]
        du = [turned(s, sine + way * h)[1] for way in (1, -1)]
    assert closed.sum() > 20
    differences = (ds[0] - ds[1] + du[0] - du[1]) / 2 / h
    trace, lyapunov = stability(words.T, paths_at(words, places, kappa))
    assert trace[closed] == pytest.approx(differences[closed], rel=1e-4, abs=1e-4)
    assert np.cosh(lyapunov[closed]) == pytest.approx(np.maximum(np.abs(trace[closed]) / 2, 1))


@pytest.mark.parametrize(("a", "kappa"), [(1.6, 0.0), (1.6, 0.1), (1.6, 0.3), (5.0, 0.05)])
def test_the_determinant_of_the_hessian_gives_the_trace(a, kappa):
    """det H = prod(-b) (tr M - 2)."""
    words, places = orbits_at(6, kappa, a)
    paths = paths_at(words, places, kappa, a)
    slopes, p = derivatives_of_action(paths), words.shape[1]
    hessian = np.zeros((len(words), p, p))
    own, ahead = np.arange(p), (np.arange(p) + 1) % p
    hessian[:, own, own] = slopes.diagonal.T
    hessian[:, own, ahead] += slopes.couplings.T
    hessian[:, ahead, own] += slopes.couplings.T
    expected = np.prod(-slopes.couplings, axis=0) * (stability(words.T, paths)[0] - 2)
    assert len(words) > 30
    assert np.linalg.det(hessian) == pytest.approx(expected, rel=1e-10, abs=1e-13)


def test_traces_of_long_words_do_not_overflow():
    """Lambda and trace of words of 242 and 282 bounces are those of the library."""
    for word in ("0123" * 60 + "13", "1232131" * 40 + "13"):
        orbit = solve_word(word, A)
        words = np.array([list(map(int, word))], np.uint8)
        trace, lyapunov = stability(words.T, paths_at(words, there(orbit.coordinates)[None, :], 0.0))
        assert lyapunov[0] == pytest.approx(orbit.lyapunov, rel=1e-12)
        assert trace[0] == pytest.approx(orbit.trace, rel=1e-9)


@pytest.mark.parametrize("a", [0.6, 1.6, 4.0])
def test_the_slope_of_the_area_is_the_curvature_of_the_action(a):
    """By differences of followed orbits: A(kappa) - A(-kappa) and S(kappa) + S(-kappa) - 2 L."""
    words, orbits = words_of(6), solved(6, a)
    real = orbits.status == "orbit"
    words, places, h = words[real], orbits.coordinates[real], 1e-3
    zero = np.zeros(len(words))
    up, down = (
        paths_at(words, follow_in_field(Stadium(a), words, places, zero, zero + kappa).coordinates, kappa, a)
        for kappa in (h, -h)
    )
    slopes = area_slopes(Stadium(a), words, places)
    scale = np.abs(slopes).max()
    assert (up.areas - down.areas) / 2 / h == pytest.approx(slopes, abs=1e-4 * scale)
    bend = (up.actions + down.actions - 2 * orbits.length[real]) / h**2
    assert -bend == pytest.approx(slopes, abs=1e-4 * scale + 1e-13 / h**2)


def test_the_slope_of_the_area_of_the_word_13_is_known():
    """Both arcs of 13 are diameters c = 2 (a + 1); the two bounces do not move, so that S'' = -c^3 / 6."""
    assert solve_word("13", A).area_slope == pytest.approx(5.2**3 / 6, rel=1e-14)


@pytest.mark.parametrize(
    ("p", "first", "second"),
    [(8, 3.1e-3, 9.1e-6), pytest.param(11, 5.6e-3, 1.5e-5, marks=pytest.mark.slow)],
)
def test_how_far_the_first_and_the_second_order_hold(p, first, second):
    """The largest errors of S at kappa = 0.01: of L - kappa A, and with the slope of the area."""
    words, kappa = representatives(p), 0.01
    orbits = solve(words, A)
    real = orbits.status == "orbit"
    words, places = words[real], orbits.coordinates[real]
    zero = np.zeros(len(words))
    exact = paths_at(
        words, follow_in_field(Stadium(A), words, places, zero, zero + kappa).coordinates, kappa
    ).actions
    linear = orbits.length[real] - kappa * orbits.area[real]
    square = linear - kappa**2 / 2 * area_slopes(Stadium(A), words, places)
    assert np.abs(exact - linear).max() == pytest.approx(first, rel=0.05)
    assert np.abs(exact - square).max() == pytest.approx(second, rel=0.05)
