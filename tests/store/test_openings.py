"""The words without a bounce in an opening: their own bounces, not those of their representative."""

import pytest

from orbitdb import Catalogue, InputError


@pytest.fixture(scope="module")
def catalogue(filled_once):
    return Catalogue(filled_once)


OPENINGS = ["top:-0.3:0.3", ["top:0.1:"], ["left:0.2:0.9", "bottom::-1"], "right:-0.2:0.1"]


@pytest.mark.parametrize("opening", OPENINGS, ids=str)
def test_words_are_those_whose_own_bounces_avoid_the_opening(catalogue, opening):
    walls = {"top": "2", "bottom": "0", "left": "14", "right": "35"}
    spans = [one.split(":") for one in ([opening] if isinstance(opening, str) else opening)]
    every = [*catalogue.rows(p="2-7", status="orbit", columns=("code", "coordinates"))]
    left = {
        code
        for code, places in every
        if not any(
            symbol in walls[wall] and float(low or "-inf") <= place <= float(high or "inf")
            for symbol, place in zip(code, places, strict=True)
            for wall, low, high in spans
        )
    }
    found = catalogue.rows(p="2-7", status="orbit", opening=opening, columns=("code",))
    assert {code for (code,) in found} == left
    assert 0 < len(left) < len(every)
    assert catalogue.count(p="2-7", status="orbit", opening=opening) == len(left)
    assert catalogue.classes(p="2-7", opening=opening).words.sum() == len(left)
    by_period = catalogue.entropy(p="2-7", opening=opening)
    assert sum(catalogue.count(p=p, status="orbit", opening=opening) for p in by_period["p"]) == len(left)


def test_words_that_are_no_orbits_are_left_out_with_a_note(catalogue):
    listed = catalogue.rows(p="2-8", status="all", opening="top:-0.3:0.3")
    assert not {row[0] for row in catalogue.rows(p="2-8", status="dynamical", opening="top:5e-1:")}
    assert any("so the opening leaves them out" in note for note in listed.notes)


def test_an_opening_beyond_a_wall_is_refused_at_each_a_of_a_grid(catalogue, cli):
    with pytest.raises(InputError, match=r"goes beyond its wall, where x is from -0\.5 to 0\.5 at a = 0\.5"):
        catalogue.rows(a=[1.6, 0.5], opening="top:0.2:1")
    asked = ("query", "--db", str(catalogue.path), "--opening", "top:1:2")
    assert cli(*asked).code == 2
    assert cli(*asked[:4], "top:0:1", "--p", "2-4").code == 0


@pytest.mark.parametrize(
    ("opening", "why"),
    [("right:-0.1:0.1", "bouncing balls"), ("top::", "almost only runs along a semicircle")],
)
def test_lambda_is_refused_where_it_means_nothing(catalogue, opening, why):
    """The growth rate of the orbits that are left always means something."""
    found = catalogue.lyapunov(p="2-8", opening=opening)
    assert len(found) == 0
    assert why in found.notes[0]
    assert why in " ".join(catalogue.statistics(p="2-8", opening=opening).notes)
    assert catalogue.entropy(p="2-8", opening=opening)["h_zeta"][-1] < 1.22


def test_lambda_of_what_never_escapes(catalogue):
    """Random trajectories that survive 60 bounces give 1.0184(4)."""
    found = catalogue.lyapunov(p="2-8", opening="top:-0.3:0.3")
    assert found["lambda_d_zeta"][-1] == pytest.approx(1.0184, rel=0.08)
    assert any("ln z0 is no escape rate" in note for note in found.notes)
