"""Lambda computed independently: bounce by bounce, from the Hessian, and in closed form."""

import mpmath as mp
import numpy as np
import pytest
import reference
from quick import slow_but
from solutions import real, representatives

from orbitdb.billiard.legs import Derivatives
from orbitdb.billiard.stability import Links, bounce_matrices, couplings_of, exponent, forces, hessian
from orbitdb.billiard.stadium import STRAIGHT, Stadium
from orbitdb.orbits.solve import solve
from orbitdb.symbols.words import from_strings, to_strings

VALUES = [0.1, 0.5, 1.6, 5.0]


def orbits_of(p: int, a: float):
    """Return words, coordinates, lambda and its error bound of the orbits among the representatives."""
    orbits = solve(representatives(p), Stadium(a))
    found = real(orbits)
    return (
        orbits.words[found],
        orbits.coordinates[found],
        orbits.lyapunov[found],
        orbits.lyapunov_error[found],
    )


def traces(stadium: Stadium, words: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the trace of the product of the paper's corrected matrices, with the last bounce on the left."""
    product = np.eye(2)[None]
    for n in range(words.shape[1]):
        product = bounce_matrices(stadium, words, coordinates)[:, n] @ product
    return np.trace(product, axis1=1, axis2=2)


@pytest.mark.parametrize("a", slow_but([0.1, 1.6], VALUES))
@pytest.mark.parametrize("p", slow_but(range(2, 8), range(2, 9)))
def test_lambda_agrees_with_the_product_of_bounce_matrices(p, a):
    words, x, exponents, _ = orbits_of(p, a)
    trace = traces(Stadium(a), words, x)
    straight = np.count_nonzero(STRAIGHT[words], axis=1)
    assert (np.sign(trace) == (-1.0) ** straight).all()  # each straight bounce flips its sign
    assert (np.abs(trace) > 2).all()
    assert np.arccosh(np.abs(trace) / 2) == pytest.approx(exponents, rel=1e-10)


@pytest.mark.parametrize("a", slow_but([0.1, 1.6], VALUES))
@pytest.mark.parametrize("p", slow_but(range(2, 8), range(2, 9)))
def test_the_determinant_of_the_hessian_follows_from_lambda(p, a):
    """det H = prod(-b_i) (tr M - 2) holds with its sign if tr M is computed from lambda alone."""
    stadium = Stadium(a)
    words, x, exponents, _ = orbits_of(p, a)
    straight = np.count_nonzero(STRAIGHT[words], axis=1)
    trace = (-1.0) ** straight * 2 * np.cosh(exponents)
    couplings = couplings_of(Links.of(stadium, words, x), stadium.tangents(words, x))
    expected = np.prod(-couplings, axis=1) * (trace - 2)
    assert np.linalg.det(hessian(stadium, words, x)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("p", [2, 3, 5, 7])
def test_hessian_and_forces_equal_the_reference(p):
    """They are compared at the orbit, where the library's Hessian is valid."""
    words, x, _, _ = orbits_of(p, 1.6)
    matrices = hessian(Stadium(1.6), words, x)
    for i in range(0, len(words), 3):
        _, gradient, exact = reference.length_derivatives(
            to_strings(words[i : i + 1])[0], mp.mpf(1.6), [mp.mpf(v) for v in x[i].tolist()]
        )
        assert np.abs(matrices[i] - np.array(exact.tolist(), dtype=float)).max() < 1e-12
        assert max(abs(g) for g in gradient) < 1e-13


def test_forces_are_derivatives_of_the_length_everywhere():
    rng = np.random.default_rng(3)
    words = from_strings(["1232131", "0113022", "3144552"])
    x = rng.uniform(-1.2, 1.2, words.shape)
    found = forces(Stadium(1.6), words, x)
    for word, place, force in zip(to_strings(words), x, found, strict=True):
        _, gradient, _ = reference.length_derivatives(word, mp.mpf(1.6), [mp.mpf(v) for v in place.tolist()])
        assert np.abs(force - np.array([float(g) for g in gradient])).max() < 1e-13


def test_a_batch_can_mix_words_in_and_out_of_range():
    """Drifts and kicks of any size agree with 50 digits; rescaling one word does not affect the others."""
    rng = np.random.default_rng(5)
    drift, kick = 10.0 ** rng.uniform(-3, 3, (2, 60, 4)) * [1e-6, 1.0, 1e3, 1e5]
    found = exponent(Derivatives(np.zeros_like(drift), np.zeros_like(drift), drift, 1 / kick))
    for word in range(4):
        with mp.workdps(50):
            product = mp.eye(2)
            for d, stiffness in zip(drift[:, word], 1 / kick[:, word], strict=True):
                product = (
                    mp.matrix([[1, d], [0, 1]]) * mp.matrix([[1, 0], [1 / mp.mpf(stiffness), 1]]) * product
                )
            exact = mp.acosh((product[0, 0] + product[1, 1]) / 2)
        assert reference.relative(float(found[word]), exact) < 1e-14
    assert found[0] < 276 < 709 < found[3]
