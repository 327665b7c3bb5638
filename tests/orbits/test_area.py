"""The enclosed area of an orbit, and its traversal of the quarter stadium."""

import math

import numpy as np
import pytest
from contents import alter
from there import there

from orbitdb import Catalogue, solve_word, trajectory

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
    from orbitdb.orbits.error_bounds import enclosed_areas
    from orbitdb.symbols.words import from_strings

    orbit, rng = solve_word("1232131", 1.6), np.random.default_rng(3)
    words, error = np.repeat(from_strings([orbit.code]), 200, axis=0), np.full(200, 1e-6)
    places = there(orbit.coordinates) + rng.choice([-1e-6, 1e-6], words.shape)
    areas, bounds = enclosed_areas(Stadium(1.6), words, places, error)
    off = np.abs(areas - there(orbit.area))
    assert (off <= bounds).all()
    assert off.max() > bounds[0] / 10  # and no larger than necessary


def test_a_word_without_an_orbit_encloses_nothing():
    for word in ("001", "02"):
        orbit = solve_word(word, 1.6)
        assert (orbit.area, orbit.area_error, orbit.half, orbit.quarter_length) == (None,) * 4


@pytest.mark.slow
def test_rows_have_the_areas_of_their_words(filled):
    """The stored area of the representative gets the sign of each word; it is 0 where a symmetry says so."""
    catalogue = Catalogue(filled, a=1.6)
    subset = catalogue.select(p="2-5", status="orbit", coordinates=True)
    assert dict(zip(subset.code.tolist(), subset.area, strict=True))["013"] == pytest.approx(-3.14042197088)
    for orbit in subset:
        points, area = there(orbit.points), there(orbit.area)
        assert area == catalogue[orbit.code].area
        (x, y), (x_next, y_next) = points.T, np.roll(points, -1, axis=0).T
        polygon = (x * y_next - y * x_next).sum() / 2
        assert abs(polygon - area) <= there(orbit.area_error) + 1e-14
        solved = solve_word(orbit.code, 1.6)
        assert abs(area - there(solved.area)) <= there(orbit.area_error) + there(solved.area_error)
        assert (str(area) == "0.0") == (solved.area == 0)
        assert catalogue[orbit.reverse().code].area == orbit.reverse().area


def test_the_area_has_the_sign_of_the_way_in_which_a_stored_word_is_asked_for(filled):
    """As any rotation of any image, alone and among others; its own points run that way."""
    catalogue = Catalogue(filled)
    for stored in ("013", "01123", "0103155"):
        images = [image.code for image in catalogue[stored].images()]
        forms = [code[n:] + code[:n] for code in images for n in range(len(stored))]
        for found, form in zip(catalogue.find(forms), forms, strict=True):
            orbit = there(found)
            x, y = there(orbit.points).T
            polygon = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2
            assert abs(there(orbit.area)) > 0.1
            assert polygon == pytest.approx(there(orbit.area), abs=1e-12)
            assert catalogue[form].area == orbit.area


@pytest.mark.parametrize("where", [None, "code LIKE '%3'"])
def test_representatives_are_sorted_by_their_own_area(filled, where):
    catalogue = Catalogue(filled, a=1.6)
    subset = catalogue.select(p="2-5", status="orbit", where=where, order="-area", classes=True)
    assert subset.area.tolist() == sorted(subset.area, reverse=True)
    assert subset.area[0] > 0 > subset.area[-1]
    assert [catalogue[code].area for code in subset.code.tolist()] == subset.area.tolist()


@pytest.mark.parametrize("method", ["newton", "relaxation"])
def test_single_words_and_the_relaxation_store_areas(tmp_path, method):
    catalogue = Catalogue.create(tmp_path / "orbits.db")
    catalogue.fill(code=["1232131", "0103"], a=1.6, method=method)
    found = catalogue["1232131"]
    assert found.area == pytest.approx(there(solve_word("1232131", 1.6).area), abs=1e-6)
    assert (found.area_error is None) == (method == "relaxation")
    assert catalogue["0103"].area == 0.0
    assert catalogue.verify().sound


def test_verification_finds_a_wrong_area(tmp_path):
    path = tmp_path / "orbits.db"
    Catalogue.create(path).fill(4, a=1.6)
    alter(
        path, "UPDATE orbit SET area = area + 1e-9 WHERE cycle = (SELECT id FROM cycle WHERE word = '0113')"
    )
    failed = {check.name: check.first for check in Catalogue(path).verify().failed}
    assert failed == dict.fromkeys(("bounds", "lengths"), "0113 at a = 1.6")


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
    assert orbit.quarter_lyapunov == there(orbit.lyapunov) / 2
    assert there(orbit.quarter_maslov) * 2 == there(orbit.maslov)


def test_half_of_an_orbit_is_stretched_by_the_quarter_lyapunov():
    """Half of 0103, followed bounce by bounce, ends as the mirror image of its beginning."""
    orbit = solve_word("0103", 1.0)
    points = there(orbit.points)
    step = points[1] - points[0]
    x, y = points[0].tolist()
    path = trajectory(1.0, x, y, math.atan2(step[1], step[0]), bounces=24)
    np.testing.assert_allclose(path.x[1::4], -path.x[3::4], atol=1e-5)
    growth = path.lyapunov[2:12:2] - path.lyapunov[:10:2]
    assert growth[-1] == pytest.approx(there(orbit.quarter_lyapunov), rel=1e-6)
