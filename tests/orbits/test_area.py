"""The enclosed area of an orbit, and its traversal of the quarter stadium."""

import numpy as np
import pytest
from there import there

from orbitdb import Catalogue, solve_word

WORDS = ["013", "01552", "1232131", "0103155", "011255", "1" * 9 + "3" * 8, "13020311"]


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("a", [0.7, 1.6])
def test_the_area_is_that_of_the_polygon_of_the_bounces(word, a):
    """A fan of triangles around the first bounce; each changes by at most the error times its sides."""
    orbit = solve_word(word, a)
    if orbit.points is None:
        return
    sides = orbit.points[1:] - orbit.points[0]
    fan = np.sum(sides[:-1, 0] * sides[1:, 1] - sides[:-1, 1] * sides[1:, 0]) / 2
    odd = {"x", "y", "T", "xyT"} & set(there(orbit.symmetry).split(","))
    assert abs(fan - there(orbit.area)) <= 4 * there(orbit.area_error) + 1e-10 * bool(odd)
    assert (orbit.area == 0) == bool(odd)


@pytest.mark.parametrize("word", ["013", "1232131", "01552"])
def test_images_have_the_same_area_up_to_its_sign(word):
    orbit = solve_word(word, 1.6)
    assert orbit.reverse().area == pytest.approx(-there(orbit.area), abs=2 * there(orbit.area_error))
    for image in orbit.images():
        assert abs(there(image.area)) == pytest.approx(
            abs(there(orbit.area)), abs=2 * there(orbit.area_error)
        )


def test_a_moved_vertex_stays_within_the_bound():
    """The area of the same word, with every coordinate moved by up to the error, is within the bound."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.orbits.orbit import enclosed_areas
    from orbitdb.symbols.words import from_strings

    orbit, rng = solve_word("1232131", 1.6), np.random.default_rng(3)
    words, error = np.repeat(from_strings([orbit.code]), 200, axis=0), np.full(200, 1e-6)
    places = there(orbit.coordinates) + rng.choice([-1e-6, 1e-6], words.shape)
    areas, bounds = enclosed_areas(Stadium(1.6), words, places, error, ["1"] * 200)
    off = np.abs(areas - there(orbit.area))
    assert (off <= bounds).all()
    assert off.max() > bounds[0] / 10  # and no larger than necessary


def test_a_word_without_an_orbit_encloses_nothing():
    for word in ("001", "02"):
        orbit = solve_word(word, 1.6)
        assert (orbit.area, orbit.area_error, orbit.half, orbit.quarter_length) == (None,) * 4


def test_subsets_have_the_areas_of_their_orbits(filled):
    subset = Catalogue(filled, a=1.6).select(p="2-6", coordinates=True)
    areas = [np.nan if orbit.area is None else orbit.area for orbit in subset]
    np.testing.assert_array_equal(subset.area, areas)
    by_code = dict(zip(subset.codes.tolist(), areas, strict=True))
    assert by_code["013"] == pytest.approx(-3.140421970879838)
    without = Catalogue(filled, a=1.6).select(p=3)
    with pytest.raises(ValueError, match="coordinates=True"):
        without.area  # noqa: B018


@pytest.mark.parametrize(
    ("word", "half", "length"),
    [
        # github.com/dionatandiego11/hipotese-riemann, catalogo_o1.csv: half lengths at a = 1
        ("0123", "xy", 4.472135955),
        ("0103", "x", 4.828427125),
        ("011255", "xy", 4.889431983),
        ("111555", "xy", 5.0),
        ("13", "x", 4.0),
    ],
)
def test_the_quarter_stadium_is_traversed_in_half_of_the_length(word, half, length):
    orbit = solve_word(word, 1.0)
    assert orbit.half == half
    assert orbit.quarter_length == there(orbit.length) / 2 == pytest.approx(length, abs=1e-9)
