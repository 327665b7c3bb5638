"""The eight symmetries: group laws, classes, and their action on solved orbits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import slow_but
from solutions import words_of

from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import STRAIGHT, Stadium
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.pruning import rules_broken, rules_of
from orbitdb.symbols.symmetry import (
    ELEMENTS,
    GROUPS,
    MIRROR_X,
    MIRROR_Y,
    NAMES,
    REVERSE,
    act_on_coordinates,
    act_on_words,
    class_of,
    class_size,
    classify,
    images_of,
    label,
    members,
    smallest_group,
)
from orbitdb.symbols.words import least_rotation, pack, to_strings, unpack

STADIUM = Stadium(1.6)
ALL = {p: words_of(p) for p in range(2, 9)}

admissible = st.sampled_from([word for p in range(2, 8) for word in to_strings(ALL[p])])


@pytest.mark.parametrize("p", range(2, 8))
def test_the_group_acts_on_words_and_coordinates(p):
    words = ALL[p]
    x = np.random.default_rng(p).uniform(-1, 1, words.shape)
    for g in ELEMENTS:
        image, moved = act_on_words(g, words), act_on_coordinates(g, words, x)
        assert not rules_broken(image).any(), NAMES[g]
        for h in ELEMENTS:
            assert (act_on_words(h, image) == act_on_words(g ^ h, words)).all()
            assert (act_on_coordinates(h, image, moved) == act_on_coordinates(g ^ h, words, x)).all()


def test_generators_mirror_or_reverse_the_points():
    words = ALL[6]
    x = np.random.default_rng(6).uniform(-1, 1, words.shape)
    points = STADIUM.points(words, x)
    for g, mirror in ((MIRROR_X, [-1, 1]), (MIRROR_Y, [1, -1]), (REVERSE, [1, 1])):
        image = STADIUM.points(act_on_words(g, words), act_on_coordinates(g, words, x))
        expected = points[:, ::-1] if g == REVERSE else points
        assert np.abs(image - expected * mirror).max() < 1e-15


def test_images_of_two_words_are_known():
    # the run 11 crosses the end of the word
    assert images_of("1232131") == [
        "1232131", "3212313", "4030134", "5010315", "4312324", "5132125", "1310301", "3130103",
    ]  # fmt: skip
    assert images_of("0113") == ["0113", "0331", "2443", "2551", "3440", "1550", "3112", "1332"]


@pytest.mark.parametrize("p", slow_but(range(2, 6), range(2, 9)))
def test_a_batch_is_classified_like_single_words(p):
    words = ALL[p]
    classes = classify(pack(words), p)
    representatives = to_strings(unpack(classes.representative, p))
    for i, word in enumerate(to_strings(words)):
        single = class_of(word)
        batch = (representatives[i], int(classes.element[i]), int(classes.stabiliser[i]))
        assert batch == (single.representative, single.element, single.stabiliser)


@settings(max_examples=settings().max_examples // 2)
@given(admissible)
def test_members_share_a_class(word):
    family = class_of(word)
    found = members(word)
    assert min(found) == family.representative
    assert len(found) == class_size(family.stabiliser)
    assert {class_of(other).representative for other in found} == {family.representative}
    assert {class_of(other).stabiliser for other in found} == {family.stabiliser}
    for other, g in found.items():
        assert least_rotation(images_of(word)[g]) == other
        assert rules_of(other) == []


@pytest.mark.parametrize(
    ("elements", "group"),
    [((), "1"), ((0, 4), "T"), ((4, 5), "x,T,xT"), ((3, 4), "xy,T,xyT"), ((1, 2, 4), "x,y,xy,T,xT,yT,xyT")],
)
def test_the_smallest_group_of_elements_is_found(elements, group):
    assert label(smallest_group(elements)) == group
    assert len(GROUPS) == 16  # subgroups of Z2 x Z2 x Z2
    assert all(smallest_group(g for g in range(8) if mask >> g & 1) == mask for mask in GROUPS)


@pytest.mark.parametrize("a", slow_but([0.5], [0.5, 1.6]))
@pytest.mark.parametrize("p", slow_but(range(2, 7), range(2, 9)))
def test_every_image_of_an_orbit_is_an_orbit(p, a):
    stadium = Stadium(a)
    words = ALL[p]
    words = words[classify(pack(words), p).representative == pack(words)]
    orbits = solve(words, stadium)
    real = orbits.status == Status.ORBIT
    for g in ELEMENTS:
        image = act_on_words(g, words)
        x = act_on_coordinates(g, words, orbits.coordinates)
        solved = solve(image, stadium)
        assert (solved.status == orbits.status).all(), NAMES[g]
        ends = np.where(STRAIGHT[image], a, np.pi / 2)
        assert (np.abs(x) < ends)[real].all()
        assert np.abs(forces(stadium, image, x))[real].max(initial=0) < 1e-13
        apart = np.abs(solved.coordinates - x).max(axis=1)
        assert (apart <= solved.error + orbits.error)[real].all()
        assert (np.abs(solved.length - orbits.length) <= solved.length_error + orbits.length_error)[
            real
        ].all()
        apart = np.abs(solved.lyapunov - orbits.lyapunov)
        assert (apart <= solved.lyapunov_error + orbits.lyapunov_error)[real].all()
