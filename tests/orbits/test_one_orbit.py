"""A single orbit in Python: its matrix, its images, its repr, and numbers that are recognised."""

import math
import warnings

import numpy as np
import pytest
from there import there

from orbitdb import InputError, Status, closed_form, solve, solve_word
from orbitdb.orbits import admissible
from orbitdb.orbits.newton import newton
from orbitdb.symbols.words import WordError, least_rotation, parse

WORDS = ("13", "0123", "1133", "1232131", "01020202023", "031", "11113")


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("a", [0.7, 1.6, 4.0])
def test_the_monodromy_matrix_preserves_area_and_has_the_trace_of_lambda(word, a):
    orbit = solve_word(word, a)
    if orbit.monodromy is None:
        assert orbit.coordinates is None
        assert orbit.trace is None
        return
    rounding = 1e-14 * (orbit.monodromy**2).sum()  # of products of large entries
    assert abs(np.linalg.det(orbit.monodromy) - 1) < rounding + 1e-12
    assert np.trace(orbit.monodromy) == pytest.approx(orbit.trace, rel=1e-9)


@pytest.mark.parametrize("word", WORDS)
def test_images_are_the_orbits_of_the_class(word):
    orbit = solve_word(word, 1.6)
    images = orbit.images()
    assert images[0] == orbit
    assert len({least_rotation(each.code) for each in images}) == len(images) == orbit.class_size
    for each in images:
        solved = solve_word(each.code, 1.6)
        assert (solved.representative, solved.status) == (each.representative, each.status)
        if orbit.coordinates is not None:
            np.testing.assert_allclose(there(each.coordinates), there(solved.coordinates), atol=1e-12)


def test_the_reverse_visits_the_same_points_in_reverse_order():
    orbit = solve_word("1232131", 1.6)
    back = orbit.reverse()
    np.testing.assert_allclose(there(back.points), there(orbit.points)[::-1], atol=1e-12)
    np.testing.assert_allclose(there(back.arclength), there(orbit.arclength)[::-1], atol=1e-12)
    np.testing.assert_allclose(there(back.sine), -there(orbit.sine)[::-1], atol=1e-12)
    assert back != orbit
    assert back.reverse() == orbit
    assert solve_word("0103", 1.6).reverse() == solve_word("0103", 1.6)  # it retraces its path


def test_an_orbit_has_a_one_line_repr():
    assert repr(solve_word("1232131", 1.6)).startswith("<Orbit 1232131 at a = 1.6: length 22.454")
    assert "pruned" in repr(solve_word("1001", 1.6))
    assert len(repr(solve_word("(0102)^50 3 1", 1.6))) < 120
    assert solve_word("1001", 1.6).images() == (solve_word("1001", 1.6),)


@pytest.mark.parametrize(
    ("a", "form"),
    [
        (2.0, "2"),
        (2.499999999999999, "5/2"),
        (math.sqrt(0.5), "sqrt(2)/2"),
        (math.sqrt(432) / 18, "2 sqrt(3)/3"),
        ((math.sqrt(3) - 1) / 2, "(sqrt(3) - 1)/2"),
        ((3 * math.sqrt(2) + 2) / 2, "(3 sqrt(2) + 2)/2"),
        ((5 - math.sqrt(5)) / 2, "(5 - sqrt(5))/2"),
        (math.sqrt(960) - 30, "8 sqrt(15) - 30"),
    ],
)
def test_simple_numbers_are_recognised(a, form):
    assert [closed_form(a * (1 + off)) for off in (-9e-13, 0.0, 9e-13)] == [form] * 3


def test_other_numbers_are_not_recognised():
    assert not any(map(closed_form, np.random.default_rng(3).uniform(0.05, 12, 40).tolist()))


def test_many_words_are_solved_from_texts_of_any_period():
    found = solve(["13", "1^3 3", "0011"], 1.6)
    assert found == [solve_word(word, 1.6) for word in ("13", "1113", "0011")]
    assert solve("13", 1.6) == found[:1]
    with pytest.raises(InputError, match="tolerance is for words given as an array"):
        solve(["13"], 1.6, tolerance=1e-3)  # type: ignore[call-overload]


MIXED = ["0123", "13", "02", "1232131", "31", "010203", "1^9 3", "0123", "1^40(02)^9 3", "111333", "120"]
"""Words of many periods and statuses, some with equal numbers of runs, one twice; 111333 goes to balls."""


@pytest.mark.parametrize("a", [1.0, 1.6])
def test_words_of_mixed_periods_are_solved_as_each_alone_to_the_last_bit(a):
    together, alone = solve(MIXED, a), [solve_word(word, a) for word in MIXED]
    for one, other in zip(together, alone, strict=True):
        np.testing.assert_array_equal(one.coordinates, other.coordinates)
        assert vars(one) | {"_coordinates": None} == vars(other) | {"_coordinates": None}
    assert [orbit.code for orbit in together] == [parse(word) for word in MIXED]
    assert {orbit.status for orbit in together} >= {Status.ORBIT, Status.FAMILY, Status.GEOMETRIC}


def test_newton_runs_once_for_each_number_of_runs_whatever_the_periods(monkeypatch):
    words = ["013" + "0202" * n for n in range(9)] + ["1" * n + "3" for n in range(1, 9)]
    assert len({len(word) for word in words}) > 9
    calls = []

    def counted(legs, *more):
        calls.append(len(legs))
        return newton(legs, *more)

    monkeypatch.setattr(admissible, "newton", counted)
    solve(words, 1.6)
    assert calls == [len(words)]


@pytest.mark.parametrize("errors", ["raise", "skip"])
def test_all_words_that_cannot_be_read_are_named_at_once_or_left_out(errors):
    words = ["13", "17", "1313", "0123", "", *["6"] * 4, "013"]
    if errors == "skip":
        assert [orbit.code for orbit in solve(iter(words), 1.6, errors="skip")] == ["13", "0123", "013"]
        return
    with pytest.raises(WordError) as refused:
        solve(words, 1.6)
    said = str(refused.value)
    assert said.startswith("7 of 10 words cannot be read: word 2: symbol '7' at position 2 of '17' is not")
    assert "word 3: '1313' is '13' repeated 2 times: give '13'; word 5: the code is empty" in said
    assert said.endswith("; and words 8, 9")
    with pytest.raises(InputError, match="errors = 'ignore': use raise or skip"):
        solve(words, 1.6, errors="ignore")


def test_beyond_the_range_of_doubles_numbers_are_infinite_and_amplitudes_still_right():
    """Lambda is linear in the number of repetitions of a part, which gives the amplitude by logarithms."""
    long = solve_word("(0123)^300 0103", 1.6)
    lyapunov, length, maslov = there(long.lyapunov), there(long.length), there(long.maslov)
    assert lyapunov > 745
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert abs(there(long.trace)) == math.inf
        assert np.isinf(there(long.monodromy)).all()
        amplitude = there(long.amplitude(10.0))
    phase = math.cos(10 * length - maslov * math.pi / 2)
    logarithm = math.log(length / math.pi) - lyapunov / 2 + math.log(abs(phase))
    assert amplitude != 0
    assert math.log(abs(amplitude)) == pytest.approx(logarithm, abs=1e-9)


@pytest.mark.parametrize("word", ["013", "011255", "1232131"])
def test_the_sine_is_that_of_the_outgoing_path_positive_anticlockwise(word):
    """Anticlockwise is to the right on the bottom wall, and up on the right semicircle."""
    for orbit in there(solve_word(word, 1.6)).images():
        points = there(orbit.points)
        ahead = np.roll(points, -1, axis=0) - points
        ahead /= np.hypot(*ahead.T)[:, None]
        x, y = points.T
        wall = np.abs(x) < 1.6
        along = np.where(wall, [-y, 0 * y], [-y, x - np.copysign(1.6, x)]).T
        assert there(orbit.sine) == pytest.approx((along * ahead).sum(axis=1), abs=1e-12)


@pytest.mark.parametrize("a", [0, -1.0, float("nan"), float("inf"), "1"])
def test_a_closed_form_is_of_a_positive_number(a):
    with pytest.raises(InputError, match=r"^a = "):
        closed_form(a)
