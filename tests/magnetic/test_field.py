"""`Catalogue.field` and ``orbitdb field``: words, counts, splittings, and what is said about them."""

import json
import math

import numpy as np
import pytest
from solutions import solved, words_of

from orbitdb import Catalogue, InputError, solve_word
from orbitdb.symbols.symmetry import REVERSE, images_of
from orbitdb.symbols.words import least_rotation, to_strings


@pytest.fixture
def catalogue(filled):
    return Catalogue(filled, a=1.6)


def by_code(orbits, name):
    return dict(zip(map(least_rotation, orbits.code.tolist()), getattr(orbits, name).tolist(), strict=True))


def test_without_a_field_it_is_the_catalogue(catalogue):
    orbits, stored = catalogue.field(0, p="2-7"), catalogue.select(p="2-7", status=())
    assert orbits.code.tolist() == stored.code.tolist()
    real = stored.status == "orbit"
    assert ((orbits.status == "orbit") == real).all()
    assert set(orbits.status[~real].tolist()) == {"joint"}
    for name in ("length", "lyapunov"):
        assert getattr(orbits, name)[real] == pytest.approx(getattr(stored, name)[real], rel=1e-12)
    assert orbits.action[real] == pytest.approx(stored.length[real], rel=1e-14)
    assert orbits.area[real] == pytest.approx(stored.area[real], abs=1e-12)
    assert orbits.trace[real] == pytest.approx([each.trace for each in stored[real]], rel=1e-10)
    assert (orbits.splitting[real] == 0).all()


COUNTS = [
    (0.05, 8, 1375),
    (0.1, 8, 1362),
    *(
        pytest.param(kappa, 10, count, marks=pytest.mark.slow)
        for kappa, count in ((0.0, 11064), (0.04, 10953), (0.1, 10196), (0.2, 5515))
    ),
]


@pytest.mark.parametrize(("kappa", "p", "count"), COUNTS)
def test_the_number_of_orbits_in_a_field(catalogue, kappa, p, count):
    table = catalogue.field(kappa, p=p).counts()
    assert (table["p"], table["N_c"]) == ([p], [count])


def test_counts_are_those_of_the_rows_and_of_lower_periods(catalogue):
    orbits = catalogue.field([0.05, 0.1], p="6,8")
    table = orbits.counts()
    assert list(table.columns) == ["kappa", "p", "N_c", "elliptic", "N", "K_0"]
    for kappa, p, n_c, elliptic, points, entropy in table.rows():
        own = (orbits.kappa == kappa) & (orbits.p == p)
        assert n_c == np.isin(orbits.status[own], ["orbit", "elliptic"]).sum()
        assert elliptic == (orbits.status[own] == "elliptic").sum()
        lower = [catalogue.field(kappa, p=d).exists.sum() * d for d in range(2, p + 1) if p % d == 0]
        assert (points, entropy) == (sum(lower), pytest.approx(math.log(points) / p))
    assert table["elliptic"] == [0, 0, 0, 1]  # 01112555 at kappa = 0.1
    with pytest.raises(InputError, match="whole periods"):
        catalogue.field(0.1, code="0123").counts()


def test_words_pruned_without_a_field_come_back(catalogue):
    orbits = catalogue.field(0.1, p=7)
    dynamical = np.isin(orbits.code, catalogue.select(p=7, status="dynamical").code)
    assert (orbits.exists.sum(), orbits.exists[dynamical].sum()) == (414, 56)


def test_given_words_have_the_numbers_of_the_list_of_their_period(catalogue):
    """In any rotation, in the order in which they are given, and together with words of other periods."""
    orbits = catalogue.field([-0.2, 0.07], p=5)
    codes = orbits.code[::2].tolist()[::-1]
    given = catalogue.field([-0.2, 0.07], code=["13", *(code[2:] + code[:2] for code in codes)])
    assert given.code.tolist()[2::2] == [code[2:] + code[:2] for code in codes]
    backwards = np.arange(len(orbits)).reshape(-1, 2)[::-1].ravel()
    assert given.status.tolist()[2:] == orbits.status[backwards].tolist()
    for name in ("action", "area", "trace", "splitting"):
        listed = getattr(orbits, name)[backwards]
        assert getattr(given, name)[2:] == pytest.approx(listed, rel=1e-9, abs=1e-11, nan_ok=True)


@pytest.mark.slow
def test_the_action_is_the_length_minus_kappa_times_the_area(catalogue):
    """This holds for every word of a class and for both signs of kappa; mirror images are checked, too."""
    orbits = catalogue.field([-0.15, 0, 0.15], p="2-6")
    assert orbits.action == pytest.approx(orbits.length - orbits.kappa * orbits.area, abs=1e-12, nan_ok=True)
    area = {(code, kappa): area for code, kappa, area in orbits.rows(("code", "kappa", "area"))}
    for (code, kappa), own in area.items():
        image = area[least_rotation(images_of(code)[1]), -kappa]  # left and right exchanged
        assert image is None if own is None else image == pytest.approx(-own, abs=1e-11)


def test_the_splitting_is_that_of_the_reverse(catalogue):
    orbits = catalogue.field(0.1, p="4-6")
    action = by_code(orbits, "action")
    for code, splitting in by_code(orbits, "splitting").items():
        reverse = least_rotation(images_of(code)[REVERSE])
        assert splitting == pytest.approx(action[reverse] - action[code], abs=1e-12, nan_ok=True)


def test_the_splitting_is_twice_kappa_times_the_area_to_first_order(catalogue):
    """The ratio tends to 1 as kappa^2: half the field, a quarter of the difference."""
    stored = catalogue.select(p=6, status="orbit", time_reversal="pair")
    wide = np.abs(stored.area) > 0.5
    codes, area = stored.code[wide].tolist(), stored.area[wide]
    strong, weak = (
        catalogue.field(kappa, code=codes).splitting / (2 * kappa * area) - 1 for kappa in (0.04, 0.02)
    )
    assert len(codes) > 20
    assert np.abs(weak).max() < 1e-2
    seen = np.abs(strong) > 1e-6
    assert seen.any()
    assert (strong / weak)[seen] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("k", [7])
def test_the_elliptic_window_of_a_whispering_orbit(catalogue, k):
    """The word 0 1^7 2 5^7 is stable for kappa k^2 from 0.939 to 0.9785."""
    scaled = np.array([0.9, 0.938, 0.939, 0.95, 0.96, 0.97, 0.978, 0.979, 1.0])
    orbits = catalogue.field(scaled / k**2, code=f"0 1^{k} 2 5^{k}")
    assert orbits.status.tolist() == ["orbit"] * 2 + ["elliptic"] * 5 + ["orbit"] * 2
    assert (orbits.lyapunov[2:7] == 0).all()
    assert (np.abs(orbits.trace[2:7]) < 2).all()


@pytest.mark.parametrize("a", [1.0, 1.6, 3.0])
def test_the_shortest_whispering_orbit_becomes_stable_where_theory_says(catalogue, a):
    onset = 2 / ((1 + a) ** 2 + 1)
    before, after = catalogue.field([onset * (1 - 1e-9), onset * (1 + 1e-9)], code="0123", a=a).status
    assert (before, after) == ("orbit", "elliptic")


def test_a_bounce_along_the_boundary_is_said(catalogue):
    """The residual of 01023 is small there, but says nothing about the angle."""
    assert not any("along" in note for note in catalogue.field(0.0995, code="01023", a=5).notes)
    orbits = catalogue.field(0.1, code="01023", a=5)
    assert orbits.least_sine[0] < 1e-4
    assert any("1 row has a bounce along the boundary" in note for note in orbits.notes)


def test_a_word_that_cannot_be_followed_is_unresolved_not_absent(catalogue):
    orbits = catalogue.field(0.05, p=8, a=0.5)
    assert len(orbits) == len(words_of(8))
    lost = orbits.status == "unresolved"
    assert "01033113" in orbits.code[lost]
    assert np.isnan(orbits.action[lost]).all()
    assert any(f"{lost.sum()} rows are unresolved" in note for note in orbits.notes)
    assert set(catalogue.field(0, p=8, a=0.5).status.tolist()) == {"orbit", "joint"}


def test_orbits_through_a_joint_are_no_orbits_without_a_field(catalogue):
    boundary = solved(6, 1.0)
    codes = to_strings(words_of(6)[boundary.status == "boundary"])
    assert codes
    assert set(catalogue.field(0, code=codes, a=1.0).status.tolist()) == {"joint"}


def test_notes_say_where_the_list_ends(catalogue):
    missing, doubles, stable = "some words may be missing", "without proof", "elliptic"

    def said(**given):
        text = " ".join(catalogue.field(**given).notes)
        return [note for note in (missing, doubles, stable) if note in text]

    assert said(kappa=0.05, p=8) == [doubles]
    assert said(kappa=0.1, p=8) == [doubles, stable]
    assert said(kappa=0.11, p=4) == [doubles]
    assert said(kappa=0.11, p=7) == [missing, doubles]
    assert said(kappa=0.05, p=4, a=1.5) == [missing, doubles]
    assert said(kappa=0.2, code="0103") == [doubles]


def test_criteria_choose_stored_rows(catalogue):
    orbits = catalogue.field(0.1, p="2-8", length=(None, 14), time_reversal="pair")
    stored = catalogue.select(p="2-8", status=(), length=(None, 14), time_reversal="pair")
    assert orbits.code.tolist() == stored.code.tolist()
    assert catalogue.field(0.1).code.tolist() == catalogue.select(status=()).code.tolist()


def test_a_data_frame_has_the_json_columns(catalogue, cli, filled):
    frame = catalogue.field([0.05, 0.3], code=["0123", "13"]).to_pandas()
    printed = cli("field", "0123", "13", "--kappa", "0.05", "--kappa", "0.3", "--json")
    rows = json.loads(printed.out)
    assert list(frame.columns) == list(rows[0])
    assert [row["splitting"] for row in rows] == [pytest.approx(-0.52), None, 0.0, None]
    assert [row["status"] for row in rows] == ["orbit", "elliptic", "orbit", "grazing"]
    assert frame["splitting"].isna().tolist() == [False, True, False, True]


BAD = {
    "say how strong the field is": ["field", "0123"],
    "2/kappa must be above the longest chord, 5.2 at a = 1.6: give a kappa below 0.38462": [
        "field", "0123", "--kappa", "0.4",
    ],
    "kappa = -0.4: the circles' diameter": ["field", "0123", "--kappa=-0.4"],
    "kappa = nan": ["field", "0123", "--kappa", "nan"],
    "'weak' is not a number": ["field", "0123", "--kappa", "weak"],
    "a grid has 2 to 1000 values": ["field", "0123", "--kappa", "0.2:0.1:5"],
    "the ends are too close for 5 values": ["field", "0123", "--kappa", "0.1:0.1000001:5"],
    "FROM:TO:COUNT such as 0:0.3:31": ["field", "0123", "--kappa", "0.1:0.2"],
    "02 cannot be followed into a field: the bouncing-ball family": ["field", "02", "--kappa", "0.1"],
    "0011 cannot be followed into a field: geometrically pruned": ["field", "0011", "--kappa", "0.1"],
    "a word of 1001 bounces is too long": ["field", "1^600 3^401", "--kappa", "0.1"],
    "--p does nothing with words: leave it out": ["field", "0123", "--p", "8", "--kappa", "0.1"],
    "--counts does nothing with words: leave it out": ["field", "0123", "--counts", "--kappa", "0.1"],
    "counts are of whole periods": ["field", "--counts", "--time-reversal", "self", "--kappa", "0.1"],
    "these periods have 8497721 words, more than 2000000": ["field", "--p", "2-15", "--kappa", "0.1"],
    "status geometric": ["field", "--p", "4", "--status", "all", "--kappa", "0.1"],
}  # fmt: skip


@pytest.mark.parametrize("says", BAD)
def test_bad_input_gets_one_line(cli, filled, says):
    assert cli(*BAD[says]).says(2, says)


def test_a_table_and_counts(cli, filled):
    table = cli("field", "--p", "8", "--kappa", "0.05")
    assert table.code == 0
    assert len(table.out.splitlines()) == 41
    assert "2096 rows; 40 shown, --limit 2096 shows all" in table.err
    counts = cli("field", "--p", "2-8", "--kappa", "0.05", "--counts")
    assert counts.out.splitlines()[-1].split() == ["8", "1375", "0", "11130", "1.164"]
    every = cli("field", "--p", "2-3", "--kappa", "0:0.1:21", "--counts")
    assert len(every.out.splitlines()) == 1 + 2 * 21
    assert len(cli("field", "0123", "--kappa", "0:0.3:31", "--format", "csv").out.splitlines()) == 32


@pytest.mark.slow
def test_figures_of_orbits_in_a_field(cli, filled, tmp_path):
    for name, arguments in {
        "arcs": ["orbit", "1232131", "--kappa", "0.1"],
        "actions": ["field", "1232131"],
        "range": ["field", "01112555", "--kappa", "0:0.3:31"],
    }.items():
        path = tmp_path / f"{name}.svg"
        assert cli("plot", *arguments, "-o", str(path)).code == 0
        assert "<svg" in path.read_text(encoding="utf-8")
    gone = ["plot", "orbit", "13", "--kappa", "0.3", "-o", str(tmp_path / "x.svg")]
    assert cli(*gone).says(2, "13 at a = 1.6, kappa = 0.3 cannot be drawn: no orbit: an arc meets")
    once = ["plot", "field", "13", "--kappa", "0.1", "-o", str(tmp_path / "x.svg")]
    assert cli(*once).says(2, "13: give a range of kappa in which it is an orbit")
    many = ["plot", "orbit", "13", "--kappa", "0:0.1:3", "-o", str(tmp_path / "x.svg")]
    assert cli(*many).says(2, "3 values of kappa: plot orbit draws one")


def test_a_figure_has_a_curve_for_each_word(catalogue):
    orbits = catalogue.field(np.linspace(0, 0.3, 5), code=["0123", "0321"])
    axes = orbits.plot()
    drawn = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    assert drawn["0123"].tolist() == orbits.action[orbits.code == "0123"].tolist()
    assert {"0321", "to second order"} <= drawn.keys()
    lines = [line for line in axes.get_lines() if line.get_label() == "stable"]  # they have gaps elsewhere
    marks = [line.get_xdata()[~np.isnan(line.get_ydata())] for line in lines]
    stable = orbits.kappa[orbits.status == "elliptic"].tolist()
    assert np.sort(np.concatenate(marks)).tolist() == sorted(stable) != []
    with pytest.raises(InputError, match="follow orbits to several kappa"):
        catalogue.field(0.1, code="0123").plot()


def test_nothing_chosen_is_said_and_is_no_row(catalogue, cli, filled):
    none = cli("field", "--kappa", "0.1", "--range", "length=:1")
    assert (none.code, none.out) == (1, "")
    assert "no words at a = 1.6 with length <= 1" in none.err
    lacking = cli("field", "--kappa", "0.1", "--p", "9", "--contains", "555")
    assert (lacking.code, "period 9 is not filled" in lacking.err) == (1, True)
    assert len(catalogue.field(0.1, p="2-8", length=(None, 1))) == 0
    assert cli("field", "--p", "3", "--a", "1.3", "--kappa", "0.1").code == 0  # needs no fill


@pytest.mark.slow
def test_the_slope_of_the_area_is_a_column_everywhere(catalogue, cli, filled):
    subset = catalogue.select(p="2-6", coordinates=True)
    rows = [slope for (slope,) in catalogue.rows(p="2-6", columns=("area_slope",))]
    orbits = [orbit.area_slope for orbit in subset]
    assert [slope is None for slope in rows] == [status != "orbit" for status in subset.status.tolist()]
    assert [slope is None for slope in orbits] == [slope is None for slope in rows]
    numbers = np.array(rows, float)
    assert np.array(orbits, float) == pytest.approx(numbers, rel=1e-12, nan_ok=True)
    assert subset.area_slope == pytest.approx(numbers, rel=1e-12, nan_ok=True)
    assert subset.to_pandas()["area_slope"].to_numpy() == pytest.approx(numbers, rel=1e-12, nan_ok=True)
    printed = json.loads(cli("query", "--p", "2-6", "--json").out)
    assert [row["area_slope"] for row in printed] == rows
    (word,) = json.loads(cli("query", "1232131", "--json").out)
    assert word["area_slope"] == pytest.approx(catalogue["1232131"].area_slope)
    assert cli("query", "--p", "3", "--order", "area_slope").says(2, "area_slope is computed afterwards")


def test_bounces_without_a_field_are_those_of_the_orbit(catalogue):
    orbits = catalogue.field(0, code=["0123", "1232131", "1133"])
    for code, points, sine in zip(orbits.code.tolist(), orbits.points, orbits.sine, strict=True):
        orbit = solve_word(code, 1.6)
        if orbit.points is None:
            assert points is sine is None
        else:
            assert points == pytest.approx(orbit.points, abs=1e-10)
            assert sine == pytest.approx(orbit.sine, abs=1e-10)


def test_bounces_in_a_field_are_joined_by_arcs_that_obey_the_law_of_reflection(catalogue):
    """Arcs of circles through the points have the length of the orbit, and meet the boundary at its sines."""
    orbits = catalogue.field([-0.1, 0.07], p="2-6")
    assert [points is None for points in orbits.points] == (~orbits.exists).tolist()
    for row in np.flatnonzero(orbits.exists).tolist():
        points, sine, kappa = orbits.points[row], orbits.sine[row], orbits.kappa[row]
        assert points.shape == (orbits.p[row], 2)
        step = (np.roll(points, -1, 0) - points) @ [1, 1j]
        turn = np.arcsin(kappa * np.abs(step) / 2)  # half the angle by which each arc turns left
        assert (2 * turn / kappa).sum() == pytest.approx(orbits.length[row], abs=1e-9)
        x, y = points.T
        outward = np.where(np.abs(x) > 1.6, x - np.copysign(1.6, x), 0) + 1j * y
        anticlockwise = 1j * outward / np.abs(outward)
        ahead = step / np.abs(step)
        leaving, arriving = ahead * np.exp(-1j * turn), np.roll(ahead * np.exp(1j * turn), 1)
        for direction in (leaving, arriving):
            assert (direction * anticlockwise.conj()).real == pytest.approx(sine, abs=1e-8)


def test_field_by_bounce_writes_the_bounces_of_the_list(cli, filled, catalogue):
    asked = (
        "field",
        "1232131",
        "0123",
        "--kappa",
        "0:0.1:2",
        "--by-bounce",
        "--db",
        str(filled),
        "--json",
    )
    rows = json.loads(cli(*asked).out)
    orbits = catalogue.field([0, 0.1], code=["1232131", "0123"])
    points = np.concatenate([each for each in orbits.points if each is not None])
    assert [[row["x"], row["y"]] for row in rows] == points.tolist()
    assert [row["sine"] for row in rows] == np.concatenate([s for s in orbits.sine if s is not None]).tolist()
    free = json.loads(cli("query", "1232131", "--by-bounce", "--db", str(filled), "--json").out)
    for row, bounce in zip(rows, free, strict=False):
        assert row == pytest.approx({"kappa": 0.0} | bounce, abs=1e-9)
