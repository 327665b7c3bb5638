"""Wave functions of levels, and the scars that orbits leave in them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from there import there

from orbitdb import Catalogue, InputError, solve_word, waves
from orbitdb.answers.scars import NEIGHBOURS, scars_of
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.condensation import Interiors, eigenfunctions
from orbitdb.quantum.elements import grid, quarter_disc, rectangle
from orbitdb.quantum.exact_levels import levels
from orbitdb.quantum.waves import Cells, Wave, boundary
from orbitdb.quantum.weyl import Parity

A = 1.6


@pytest.fixture(scope="module")
def few():
    """The waves of parity oo from k = 8 to 10 at a = 1.6."""
    return list(waves(A, (8, 10), "oo"))


def quarter(a=A, size=40):
    """Nodes and weights of a quadrature over a quarter of the stadium."""
    x, weight = np.polynomial.legendre.leggauss(size)
    s, w = (x + 1) / 2, weight / 2
    flat = np.stack(np.meshgrid(a * s, s, indexing="ij"), axis=-1)
    r, angle = np.meshgrid(s, math.pi / 2 * s, indexing="ij")
    round_ = np.stack([a + r * np.cos(angle), r * np.sin(angle)], axis=-1)
    both = [a * w[:, None] * w, math.pi / 2 * w[:, None] * w * r]
    return np.concatenate([flat.reshape(-1, 2), round_.reshape(-1, 2)]), np.concatenate(
        [each.ravel() for each in both]
    )


@pytest.mark.slow
def test_waves_belong_to_levels(few):
    assert [wave.k for wave in few] == pytest.approx(levels(A, (8, 10), ["oo"]).k.tolist(), rel=1e-11)


@pytest.mark.slow
def test_waves_are_orthonormal(few):
    points, weights = quarter()
    values = np.stack([wave.psi(*points.T) for wave in few])
    np.testing.assert_allclose(4 * (values * weights) @ values.T, np.eye(len(few)), atol=1e-9)


@pytest.mark.slow
def test_waves_have_their_parity_and_are_nan_outside(few):
    x, y = np.array([0.3, 1.2, 2.4]), np.array([0.2, 0.7, 0.3])
    for parity, wave in ((Parity.OO, few[0]), (Parity.EO, next(waves(A, (3, 4), "eo")))):
        assert np.abs(wave.psi(x, y)).max() > 0.05
        np.testing.assert_allclose(wave.psi(-x, y), parity.signs[0] * wave.psi(x, y), atol=1e-12)
        np.testing.assert_allclose(wave.psi(x, -y), parity.signs[1] * wave.psi(x, y), atol=1e-12)
    assert np.isnan(few[0].psi([2.61, 0.0, 2.4], [0.0, 1.01, 0.9])).all()
    assert few[0].psi(0.3, 0.2).shape == ()
    assert np.abs(few[0].psi(A + np.cos(1.0), np.sin(1.0))) < 1e-10


@pytest.mark.slow
def test_rellichs_identity_holds(few):
    """The integral of (r . n) (d psi / d n)^2 along the boundary is 2 k^2."""
    stadium = Stadium(A)
    ends = np.cumsum([0, 2 * A, math.pi, 2 * A, math.pi])
    x, weight = np.polynomial.legendre.leggauss(120)
    for wave in few[:2]:
        total = 0.0
        for low, high in pairwise(ends.tolist()):
            s = low + (x + 1) / 2 * (high - low)
            points, normal = boundary(stadium, s)
            slope = wave.normal_derivative(s)
            total += ((points * normal).sum(axis=-1) * slope**2 * weight).sum() * (high - low) / 2
        assert total == pytest.approx(2 * wave.k**2, rel=1e-8)


def test_the_functions_of_a_rectangle_are_products_of_sines():
    edge = lambda points: (np.abs(points * (points - [1.3, 1.0])) < 1e-9).any(axis=-1)  # noqa: E731
    made = grid(list(rectangle(1.3, 0.5, 0.5)), 18)
    k2 = (2 * math.pi / 1.3) ** 2 + math.pi**2
    _, values, functions = eigenfunctions(Interiors(made), edge, k2 - 1, k2 + 1)
    assert values == pytest.approx([k2], rel=4e-15)
    points = np.array([[0.2, 0.3], [0.9, 0.8], [0.65, 0.5]])
    found = Cells(made.points).at(points).values(functions[0])
    exact = 2 / math.sqrt(1.3) * np.sin(2 * math.pi * points[:, 0] / 1.3) * np.sin(math.pi * points[:, 1])
    np.testing.assert_allclose(found * np.sign(found[0] * exact[0]), exact, atol=1e-9)


def test_the_functions_of_a_quarter_disc_are_bessel_functions():
    from scipy.special import jn_zeros, jv

    edge = lambda points: (np.hypot(*points.T).T > 1 - 1e-9) | (points < 1e-9).any(axis=-1)  # noqa: E731
    made = grid(list(quarter_disc(0.0, 0.3)), 18)
    zero = jn_zeros(2, 1)[0]
    _, values, functions = eigenfunctions(Interiors(made), edge, zero**2 - 2, zero**2 + 2)
    assert math.sqrt(values[0]) == pytest.approx(zero, rel=4e-15)
    r, angle = np.array([0.2, 0.5, 0.9]), np.array([0.3, 0.8, 1.2])
    points = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=-1)
    found = Cells(made.points).at(points).values(functions[0])
    exact = jv(2, zero * r) * np.sin(2 * angle) / math.sqrt(math.pi / 8) / abs(jv(3, zero))
    np.testing.assert_allclose(found * np.sign(found[0]), exact, atol=1e-9)


def test_normal_derivatives_agree_with_differences(few):
    points, normal = boundary(Stadium(A), np.array([1.0, 4.0, 7.7, 11.0]))
    step = 1e-5
    one, other = points - step * normal, points - 2 * step * normal
    inward = (few[0].psi(*other.T) - 4 * few[0].psi(*one.T)) / (2 * step)
    np.testing.assert_allclose(few[0].normal_derivative([1.0, 4.0, 7.7, 11.0]), inward, rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_scar_strength_is_the_mean_of_psi_squared_along_the_orbit(few):
    orbit, wave = solve_word("0123", A), few[-1]
    points = there(orbit.points)
    s = (np.arange(20_000) + 0.5) / 20_000
    total = 0.0
    for one, other in zip(points, np.roll(points, -1, axis=0), strict=True):
        along = one + s[:, None] * (other - one)
        total += np.mean(wave.psi(*along.T) ** 2) * np.hypot(*(other - one))
    area = Stadium(A).area
    assert wave.strength(orbit) == pytest.approx(area * total / there(orbit.length), rel=1e-6)
    for image in ("1032", "0321"):
        assert wave.strength(solve_word(image, A)) == pytest.approx(wave.strength(orbit), rel=1e-8)
    with pytest.raises(InputError, match="is not an orbit at a"):
        wave.strength(solve_word("1001", A))
    with pytest.raises(InputError, match="not an orbit at a"):
        wave.strength(solve_word("0123", 1.5))


@pytest.mark.slow
def test_the_mean_scar_strength_is_one_or_two_or_zero_on_an_axis():
    every = {parity: list(waves(A, (2, 14), parity)) for parity in Parity}
    for word, wanted in (("13", {"ee": 2, "oe": 2, "eo": 0, "oo": 0}), ("013", dict.fromkeys(Parity, 1))):
        orbit = solve_word(word, A)
        for parity, found in every.items():
            strength = [wave.strength(orbit) for wave in found]
            error = np.std(strength) / math.sqrt(len(strength))
            assert abs(np.mean(strength) - wanted[parity]) < 4 * error + 1e-12, (word, parity)


def test_the_husimi_function_has_the_symmetries_of_the_wave(few):
    s, sine = np.linspace(0.1, 12, 40), np.linspace(-0.95, 0.95, 21)
    found = few[0].husimi(s, sine)
    assert found.shape == (40, 21)
    assert found.max() == 1
    np.testing.assert_allclose(found, found[:, ::-1], atol=1e-9)  # a real function has both directions
    whole = Stadium(A).perimeter
    np.testing.assert_allclose(few[0].husimi(s + whole / 2, sine), found, atol=1e-6)


@pytest.mark.slow
def test_scars_are_sorted_by_strength_and_compared_with_neighbouring_levels(few):
    orbit = solve_word("0123", A)
    found = scars_of([orbit], (8, 10), [Parity.OO], [("strength", True)])
    assert [scar.strength for scar in found] == sorted((scar.strength for scar in found), reverse=True)
    assert sorted(scar.k for scar in found) == pytest.approx([wave.k for wave in few])
    above = {scar.k: there(scar.above) for scar in found}
    (one,) = scars_of([orbit], few[2].k + 1e-6, [Parity.OO], [("k", False)])
    assert one.above == pytest.approx(
        next(z for k, z in above.items() if abs(k - one.k) < 1e-9), rel=1e-6
    )  # whatever the range
    every = list(waves(A, (0, 13), Parity.OO))
    here = next(n for n, wave in enumerate(every) if abs(wave.k - one.k) < 1e-9)
    others = [wave.strength(orbit) for wave in every[max(here - NEIGHBOURS, 0) : here + NEIGHBOURS + 1]]
    own = others.pop(min(here, NEIGHBOURS))
    assert one.above == pytest.approx((own - np.mean(others)) / np.std(others), rel=1e-6)
    assert isinstance(few[0], Wave)


def test_the_bouncing_balls_have_the_mean_over_their_rectangle(few):
    balls = solve_word("02", A)
    points, weights = (values[: 40 * 40] for values in quarter())  # those of the rectangle
    for wave in few[:3]:
        mean = weights @ wave.psi(*points.T) ** 2 / A * Stadium(A).area
        assert wave.strength(balls) == pytest.approx(mean, rel=1e-4)


@pytest.mark.slow
def test_scars_take_one_k_or_a_range_and_an_order(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", A)
    catalogue.fill("2-4")
    by = {
        order: catalogue.scars((8, 10), code="02", parity="oo", order=order) for order in ("k", "above desc")
    }
    assert [scar.k for scar in by["k"]] == sorted(scar.k for scar in by["above desc"])
    above = [there(scar.above) for scar in by["above desc"]]
    assert above == sorted(above, reverse=True)
    (nearest,) = catalogue.scars(9, code="02", parity="oo")
    expected = min(by["k"], key=lambda scar: abs(scar.k - 9))
    assert (nearest.parity, nearest.code) == (expected.parity, expected.code)
    assert nearest.k == pytest.approx(expected.k, rel=1e-13)  # from another window
    assert nearest.strength == pytest.approx(expected.strength, rel=1e-9)  # from other neighbours
    assert len(catalogue.scars(9, parity="oo")) == 5
    with pytest.raises(InputError, match="give the lower end first"):
        catalogue.scars((10, 8), code="02")
    with pytest.raises(InputError, match="'strenght': did you mean strength"):
        catalogue.scars((8, 10), order="strenght")
