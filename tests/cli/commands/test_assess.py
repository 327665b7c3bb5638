"""``orbitdb assess`` and ``levels --method orbits`` on the command line."""

import csv
import io
import json
import math
import re
from collections import Counter

import numpy as np
import pytest
from quick import slow_but
from there import there

from orbitdb import Catalogue

GHZ = 299_792_458.0 / (2 * math.pi * 0.2) / 1e9
"""Frequency of k = 1 in a resonator of radius 0.2 m."""


@pytest.fixture
def own(filled_once):
    return str(filled_once)


@pytest.fixture
def exact(exact_once):
    return exact_once[exact_once < 12]


def written(path, values, head=""):
    path.write_text(head + "\n".join(map(repr, values)) + "\n")
    return str(path)


def numbers(text):
    return [list(map(float, row)) for row in list(csv.reader(io.StringIO(text)))[1:]]


def test_a_complete_list_passes_and_removed_levels_are_found(cli, own, exact, tmp_path):
    whole = cli("assess", written(tmp_path / "k.txt", exact.tolist()), "--parity", "oo", "--db", own)
    assert whole.code == 0
    of = f"{len(exact)} levels with k from 0 to {exact[-1]:.4g}"
    assert whole.err.startswith(f"none of {of} is missing (P 0.9")
    assert "; a = 1.6, oo; misfit 0." in whole.err
    few = np.delete(exact, 9).tolist()
    found = cli("assess", written(tmp_path / "few.txt", few), "--parity", "oo", "--db", own, "--json")
    assert found.code == 1
    (row,) = json.loads(found.out)
    assert list(row) == ["after", "before", "levels", "missing", "spurious", "probability", "gaps"]
    assert (row["missing"], row["spurious"]) == (1, 0)
    assert 0.8 < row["probability"] < 1
    assert [list(gap) for gap in row["gaps"]] == [["after", "before", "missing"]] * (row["levels"] + 1)
    assert row["gaps"][0]["missing"]["1"] > 0.5
    table = cli("assess", str(tmp_path / "few.txt"), "--parity", "oo", "--db", own).out
    assert table.split()[:6] == ["after", "before", "levels", "missing", "spurious", "probability"]
    assert row["after"] < exact[9] + 0.5
    assert row["before"] > exact[9] - 0.5
    assert f"1.0 +- 0.1 of {len(exact)} levels with k from 0 to" in found.err


def test_numbers_have_probabilities(cli, own, exact, tmp_path):
    few = written(tmp_path / "few.txt", np.delete(exact, 9).tolist())
    rows = json.loads(cli("assess", few, "--parity", "oo", "--numbers", "--db", own, "--json").out)
    assert [list(row) for row in rows] == [["k", "number", "probability", "excess"]] * len(rows)
    assert [row["number"] for row in rows] == [n for n in range(1, len(exact) + 1) if n != 10]
    assert all(0.9 < row["probability"] <= 0.999 for row in rows)


@pytest.mark.slow
def test_levels_can_be_given_as_energies_or_frequencies(cli, own, exact, tmp_path):
    few = np.delete(exact, 9)
    energies = written(tmp_path / "energy.csv", (few**2).tolist(), "energy\n")
    frequencies = written(tmp_path / "f.csv", (few * GHZ).tolist(), "frequency\n")
    asked = ("--parity", "oo", "--db", own, "--format", "csv")
    one = cli("assess", energies, "--energies", *asked)
    other = cli("assess", frequencies, "--frequency", "GHz", "--radius", "0.2", *asked)
    assert one.code == other.code == 1
    np.testing.assert_allclose(numbers(one.out), numbers(other.out), rtol=1e-12)
    fitted = cli("assess", frequencies, "--frequency", "GHz", "--radius", "0.2004", "--fit-radius", *asked)
    found = re.search(r"radius (\S+) \+- (\S+) m; the k above use it", fitted.err)
    radius, error = there(found).groups()
    assert abs(float(radius) - 0.2) < 3 * float(error) < 8e-4  # periods up to 8 suffice to length 10 only
    prior = cli("assess", frequencies, "--frequency", "GHz", "--radius", "0.2004+-0.0003", *asked)
    assert "m; the k above use it" in prior.err
    failed = cli("assess", frequencies, "--frequency", "GHz", "--radius", "0.204", "--fit-radius", *asked)
    assert failed.code == 1
    assert "radius 0." not in failed.err


@pytest.mark.slow
def test_another_radius_is_suggested_where_the_orbits_can_tell(cli, exact_once, tmp_path):
    """Periods up to 12 and levels up to k = 16 notice a radius that is off by 0.4 %."""
    path = str(tmp_path / "orbits.db")
    Catalogue.create(path, 1.6).fill("2-12")
    frequencies = written(tmp_path / "f.csv", (np.delete(exact_once, 9) * GHZ).tolist(), "frequency\n")
    asked = (
        "assess",
        frequencies,
        "--frequency",
        "GHz",
        "--radius",
        "0.2008",
        "--parity",
        "oo",
        "--db",
        path,
    )
    wrong = cli(*asked)
    assert wrong.code == 1
    assert "they fit with another radius: 'orbitdb assess FILE --fit-radius" in wrong.err
    fitted = cli(*asked, "--fit-radius")
    radius, error = there(re.search(r"radius (\S+) \+- (\S+) m; the k above use it", fitted.err)).groups()
    assert abs(float(radius) - 0.2) < 3 * float(error) < 3e-4


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--frequency", "GHz"), "need --frequency with their unit and --radius"),
        (("--radius", "0.2"), "need --frequency with their unit and --radius"),
        (("--frequency", "GHz", "--radius", "0"), "--radius 0: give the radius in metres"),
        (("--frequency", "GHz", "--radius", "1+-0"), "give an error above 0"),
        (("--frequency", "GHz", "--radius", "1+x"), "not a number"),
        (("--noise", "2"), "noise 2: give the scatter"),
        (("--frequency", "GHz", "--radius", "1", "--energies"), "only one of them"),
        (("--parity", "ee,oo"), "give one"),
        (("--energies",), "Weyl's law expects"),
        (("--statistics",), "name it with --parity"),
        (("--statistics", "--fit-radius"), "--fit-radius"),
    ],
)
def test_conflicting_options_are_refused(cli, own, exact, tmp_path, options, told):
    path = written(tmp_path / "k.txt", exact.tolist())
    assert cli("assess", path, *options, "--db", own).says(2, told)


def test_the_wrong_parity_is_named(cli, own, exact, tmp_path):
    twice = np.repeat(exact, 2).tolist()
    found = cli("assess", written(tmp_path / "k.txt", twice), "--parity", "eo", "--db", own)
    assert found.code == 1
    assert "the list has every level twice" in found.err
    assert "the list does not fit a = 1.6, eo: misfit" in found.err
    assert "lists that fit have less than 1" in found.err
    assert "they fit the parity oo\n" in found.err


@pytest.mark.slow
def test_another_stored_half_length_that_fits_is_named(cli, filled, exact, tmp_path):
    Catalogue(filled).fill("2-8", a=1.8)
    path = written(tmp_path / "k.txt", exact.tolist())
    found = cli("assess", path, "--parity", "oo", "--a", "1.8", "--db", str(filled))
    assert found.code == 1
    assert "they fit a = 1.6\n" in found.err


def test_levels_out_of_order_are_sorted_with_a_note(cli, own, exact, tmp_path):
    path = written(tmp_path / "k.txt", exact[::-1].tolist())
    found = cli("assess", path, "--parity", "oo", "--db", own)
    assert (found.code, "not in order and have been sorted" in found.err) == (0, True)


def test_levels_that_numpy_wrote_as_complex_numbers_are_read(cli, own, exact, tmp_path):
    plain, path = (written(tmp_path / "k.txt", exact.tolist()), str(tmp_path / "complex.txt"))
    np.savetxt(path, exact + 0j, fmt="%.17g")
    assert "(" in (tmp_path / "complex.txt").read_text()
    asked = ("--parity", "oo", "--numbers", "--db", own, "--json")
    assert cli("assess", path, *asked) == cli("assess", plain, *asked)
    np.savetxt(path, exact + 0.1j)
    assert cli("assess", path, *asked).says(2, "row 1 has no level")


def test_a_list_is_also_read_from_stdin(cli, own, exact, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(map(str, exact.tolist()))))
    assert cli("assess", "-", "--parity", "oo", "--db", own).code == 0


def test_statistics_are_shown_beside_those_of_random_matrices(cli, own, exact, tmp_path):
    path = written(tmp_path / "k.txt", exact.tolist())
    rows = json.loads(cli("assess", path, "--parity", "oo", "--statistics", "--db", own, "--json").out)
    assert [(row["parity"], row["balls"]) for row in rows] == [
        ("oo", "in"), ("oo", "out"), ("GOE", ""), ("Poisson", ""),
    ]  # fmt: skip
    assert list(rows[0])[:5] == ["parity", "balls", "levels", "gap_ratio", "gap_ratio_error"]
    assert rows[0]["levels"] == len(exact)
    assert abs(rows[0]["gap_ratio"] - rows[2]["gap_ratio"]) < 5 * rows[0]["gap_ratio_error"]
    assert cli("assess", "--statistics", "--db", own).says(
        1, "no levels of parity ee are stored", "orbitdb levels"
    )


def test_statistics_are_those_at_the_given_a(cli, awkward):
    expected = Catalogue(awkward).level_statistics(parity="ee", a=1)
    found = json.loads(cli("assess", "--statistics", "--parity", "ee", "--a", "1", "--json").out)
    assert [tuple(row.values()) for row in found] == [*expected.rows()]


def test_levels_from_orbits_name_the_periods_they_come_from(cli, own, exact):
    found = cli("levels", "--method", "orbits", "--k", "6:12", "--parity", "oo", "--db", own, "--json")
    rows = json.loads(found.out)
    assert [list(row) for row in rows] == [["k", "error", "parity", "exact"]] * len(rows)
    assert len(rows) == sum(exact >= 6)
    assert all(abs(row["k"] - k) < 3 * row["error"] for row, k in zip(rows, exact[exact >= 6], strict=True))
    assert f"{len(rows)} levels with k from 6 to 12: from " in found.err
    assert "orbits, all up to period 8, " in found.err
    assert "'orbitdb fill --p 12 --a 1.6 --db " in found.err
    assert cli("levels", "--method", "orbits", "--jobs", "2", "--db", own).says(2, "--jobs")
    some = cli("levels", "--method", "orbits", "--k", "3:6", "--parity", "oo", "--db", own)
    assert "with k from 3 to 6: from " in some.err
    assert cli("levels", "--method", "magic", "--db", own).says(2, "use elements or orbits")
    assert cli("levels", "--db", own).says(2, "--k 0:30")


def test_the_spectrum_of_a_list_says_which_levels_are_missing(cli, own, exact, tmp_path):
    path = written(tmp_path / "k.txt", np.delete(exact, [0, 1, 2, 9]).tolist())
    found = cli("spectrum", "--levels", path, "--parity", "oo", "--db", own, "--resolution", "3")
    assert found.code == 0
    assert f"4.0 +- 0.1 of {len(exact)} levels with k from 0 to" in found.err
    assert "the 3 lowest levels are missing" in found.err
    assert "'orbitdb assess FILE --db " in found.err


def test_a_list_is_not_judged_where_nobody_is_told(cli, own, exact, tmp_path, monkeypatch):
    def judged(*given):
        raise AssertionError

    monkeypatch.setattr("orbitdb.answers.level_lists.assess", judged)
    path = written(tmp_path / "k.txt", exact.tolist())
    asked = ("spectrum", "--levels", path, "--parity", "oo", "--db", own, "--resolution", "3")
    assert cli(*asked, "--quiet").code == 0
    assert Catalogue(own).spectrum(levels=exact, parity="oo", resolution=3).quantum is not None


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["spectrum", "assess", "spacings", "rigidity"])
def test_figures_accept_levels_from_a_file(cli, own, exact, tmp_path, figure):
    path = written(tmp_path / "k.txt", exact.tolist())
    target = tmp_path / f"{figure}.png"
    asked = ("plot", figure, "--levels", path, "-o", str(target), "--db", own)
    assert cli(*asked, "--parity", "oo").code == 0
    assert target.read_bytes().startswith(b"\x89PNG")
    assert cli("plot", "entropy", "--levels", path, "-o", str(target), "--force", "--db", own).says(
        2, "--levels"
    )


@pytest.mark.slow
def test_scars_are_listed_for_a_word_and_for_levels(cli, own):
    found = json.loads(cli("scars", "0123", "--k", "8:10", "--parity", "oo", "--db", own, "--json").out)
    assert list(found[0]) == ["k", "parity", "code", "strength", "above"]
    assert [row["strength"] for row in found] == sorted((row["strength"] for row in found), reverse=True)
    every = json.loads(cli("scars", "--k", "8:9", "--parity", "oo", "--db", own, "--json").out)
    assert {row["code"] for row in every} > {"0123"}
    assert all(each == 5 for each in Counter(row["k"] for row in every).values())
    of_word = {round(row["k"], 9): row["strength"] for row in found}
    for row in every:
        assert row["code"] != "0123" or row["strength"] == pytest.approx(
            of_word[round(row["k"], 9)], rel=1e-7
        )
    assert cli("scars", "1001", "--k", "8:9", "--db", own).says(2, "scars nothing")
    assert cli("scars", "13", "--k", "9:8", "--db", own).says(2, "--k '9:8'")
    assert cli("scars", "13", "--k", "0.1:0.2", "--db", own).says(1, "no level")


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["wave", "husimi"])
def test_waves_are_drawn_with_an_orbit_over_them(cli, own, tmp_path, figure):
    target = tmp_path / "wave.png"
    asked = ("plot", figure, "0123", "--k", "8.1", "--a", "1.6", "-o", str(target), "--force", "--db", own)
    outcome = cli(*asked, "--parity", "oo")
    assert outcome.code == 0
    assert "with the orbit 0123 (strength" in outcome.err
    assert target.read_bytes().startswith(b"\x89PNG")
    assert cli(*asked).says(2, "name one parity")
    assert cli("plot", figure, "--parity", "oo", "-o", str(target), "--force", "--db", own).says(2, "--k")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda k: [*k[:5], math.nan, *k[5:]], "row 6 is nan"),
        (lambda k: [*k, math.inf], "row 22 is inf"),
        (
            lambda k: [each**2 for each in k],
            "they look like energies: take their square roots (--energies for a file)",
        ),
        (lambda k: [each**0.5 for each in k], "they look like wavenumbers"),
        (lambda k: [each / 1000 for each in k], "k is in 1/radius"),
    ],
)
def test_lists_that_cannot_be_levels_are_refused_with_the_remedy(cli, own, exact, tmp_path, change, told):
    path = written(tmp_path / "k.txt", change(exact.tolist()))
    assert cli("assess", path, "--parity", "oo", "--db", own).says(2, told)


def test_a_list_of_one_parity_among_all_is_noticed(cli, own, exact, tmp_path):
    path = written(tmp_path / "k.txt", exact.tolist())
    assert cli("assess", path, "--db", own).says(2, "the levels of one parity: name it, such as --parity oo")


@pytest.mark.parametrize("mark", slow_but(1, ["; ", "\t", ", ", "   "]))
def test_tables_are_read_with_any_usual_separator(cli, own, exact, tmp_path, mark):
    path = tmp_path / "k.txt"
    rows = "".join(f"{k!r}{mark}oo\n" for k in exact.tolist())
    path.write_text(f"# made up\nk{mark}parity\n{rows}")
    found = cli("assess", str(path), "--parity", "oo", "--db", own)
    assert (found.code, found.err[:8]) == (0, "none of ")
    assert cli("assess", str(path), "--statistics", "--db", own).err.startswith(f"oo: {len(exact)} levels")
    path.write_text(rows.replace(".", ","))
    assert cli("assess", str(path), "--parity", "oo", "--db", own).code == 2


def test_levels_of_other_parities_in_a_table_are_counted(cli, own, exact, tmp_path):
    path = tmp_path / "k.txt"
    path.write_text("k,parity\n2.5,ee\n" + "".join(f"{k!r},oo\n" for k in exact.tolist()))
    for option in ((), ("--statistics",)):
        said = cli("assess", str(path), "--parity", "oo", *option, "--db", own).err
        assert said.startswith(f"left out for their parity: 1 of {len(exact) + 1} levels in {path}\n")
    assert "left out" not in cli("assess", str(path), "--db", own).err


@pytest.mark.slow
def test_all_commands_name_the_missing_levels_of_a_list_of_frequencies(cli, own, exact, tmp_path):
    path = written(tmp_path / "f.txt", (np.delete(exact, 9) * GHZ)[::-1].tolist())
    asked = ("--parity", "oo", "--frequency", "GHz", "--radius", "0.2", "--db", own)
    for command in (
        ("spectrum", "--levels", path, "--resolution", "3"),
        ("assess", path, "--statistics"),
        ("plot", "spectrum", "--levels", path, "-o", str(tmp_path / "spectrum.png")),
    ):
        found = cli(*command, *asked)
        assert found.code == 0
        assert "not in order and have been sorted" in found.err
        assert "1.0 +- 0.1 of 21 levels with k from 0 to 11.91 are missing (a = 1.6, oo" in found.err
        assert ": 8.127 to 9.109;" in found.err
