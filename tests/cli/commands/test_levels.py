"""``orbitdb levels`` and ``orbitdb spectrum`` on the command line."""

import json
from itertools import chain

import numpy as np
import pytest
from contents import alter, ask
from made_levels import keep_made_levels
from terminal import spawn
from there import there

from orbitdb import Catalogue, InputError, Stadium
from orbitdb.cli.given_levels import GivenLevels
from orbitdb.quantum.weyl import Parity, weyl

KNOWN = {
    "ee": [1.6968700531, 2.4751285339, 3.5221245323, 4.6281147069, 4.7689782892, 5.1744043795, 5.7253817965,
           5.9243991828, 6.6838927375, 6.97746271, 7.629073278, 7.891809769],
    "eo": [3.2154008292, 3.7449119298, 4.5888546908, 5.5604514283, 6.3255968183, 6.5491270572, 6.6905549587,
           7.2570185124, 7.6237116943],
    "oe": [2.0265300566, 2.9840193136, 4.0737835658, 4.9204322215, 5.1902694751, 5.5097729062, 6.2160614538,
           6.4259598715, 7.1540051445, 7.5432350916, 7.9908315249],
    "oo": [3.4256302952, 4.1417352305, 5.0662018867, 6.0618744376, 6.4574420169, 6.9111301528, 7.1205344228,
           7.6440296075],
}  # fmt: skip
"""All levels below k = 8 at a = 1.6, by parity."""


@pytest.mark.slow
def test_levels_are_stored_and_only_missing_ones_are_computed(cli, tmp_path):
    path = str(tmp_path / "levels.db")
    one = ("levels", "--parity", "oo", "--json", "--db", path)
    first = json.loads(cli(*one, "--k", "2:4").out)
    assert list(first[0]) == ["k", "error", "parity"]
    assert [row["k"] for row in first] == sorted(row["k"] for row in first)
    again = json.loads(cli(*one, "--k", "0:5").out)
    assert [row for row in again if 2 <= row["k"] < 4] == first != []
    windows = ask(tmp_path / "levels.db", "SELECT low, high FROM level_fill WHERE parity = 'oo' ORDER BY low")
    assert windows == [(0, 2), (2, 4), (4, 5)]
    assert ask(tmp_path / "levels.db", "SELECT count(*) FROM level") == [(len(again),)]
    fresh = json.loads(cli(*one, "--k", "0:5", "--no-store").out)
    assert [row["k"] for row in fresh] == pytest.approx([row["k"] for row in again], abs=1e-9)


@pytest.mark.parametrize(
    ("parity", "span"),
    [
        (None, (2.5, 6)),
        ("ee", (4.9, 5.1)),
        ("ee,oo", (6, 8.5)),
        ("oo,eo", (0, 1)),
        ("eo,oe", "from a level to a level"),
    ],
)
def test_stored_levels_are_shown_and_counted(cli, filled, parity, span):
    stored, names = keep_made_levels(filled), (parity or "ee,eo,oe,oo").split(",")
    low, high = (stored[names[0]][n] for n in (2, 6)) if isinstance(span, str) else span
    expected = sorted((k, name) for name in names for k in stored[name] if low <= k < high)
    options = ["--parity", parity] if parity else []
    found = cli("levels", "--k", f"{low}:{high}", *options, "--json", "--db", str(filled))
    assert found.code == (0 if expected else 1)
    rows = json.loads(found.out)
    assert [(row["k"], row["parity"]) for row in rows] == expected
    assert [row["error"] for row in rows] == [k * 1e-12 for k, _ in expected]
    for line, name in zip(found.err.splitlines(), names, strict=True):
        own = [k for k, of in expected if of == name]
        places = np.linspace(low, high, 2000)
        below = np.searchsorted(stored[name], places)
        off = (below - weyl(Stadium(1.6), Parity(name))(places)).mean()
        worst = f", errors up to {max(own) * 1e-12:.0e}" if own else ""
        count = "1 level" if len(own) == 1 else f"{len(own)} levels"
        assert line == f"{name}: {count}, none missing; on average {off:+.2f} from Weyl's law{worst}"


@pytest.fixture
def levels_file(tmp_path):
    path = tmp_path / "k.txt"
    path.write_text("".join(f"{level!r}\n" for level in sorted(chain(*KNOWN.values()))))
    return path


@pytest.mark.slow
def test_spectrum_reads_levels_and_says_up_to_where_it_is_complete(cli, filled, levels_file):
    asked = ("--lengths", "3:5", "--resolution", "9", "--json", "--db", str(filled))
    found = cli("spectrum", "--levels", str(levels_file), *asked)
    rows = json.loads(found.out)
    assert list(rows[0]) == ["length", "quantum_re", "quantum_im", "orbits_re", "orbits_im"]
    assert len(rows) == 9
    assert "complete" in found.err
    k = [float(each) for each in levels_file.read_text().split()]
    energies = levels_file.with_name("energies.csv")
    energies.write_text("energy,width\n" + "".join(f"{each**2!r},1\n" for each in k))
    other = cli("spectrum", "--levels", str(energies), "--energies", *asked)
    for one, two in zip(rows, json.loads(other.out), strict=True):
        assert one["quantum_re"] == pytest.approx(two["quantum_re"], abs=1e-6)
    partial = cli("spectrum", "--levels", str(levels_file), "--lengths", "9:16", "--db", str(filled))
    assert "may be missing" in partial.err
    assert cli("spectrum", "--levels", str(levels_file), "--k", "0:9", "--db", str(filled)).says(
        2, "the levels have k from 0 to 7.9"
    )
    assert cli("spectrum", "--levels", str(levels_file), "--k", "5:7", "--db", str(filled)).says(
        2, "only a list that is a window can begin above 0 (--window)"
    )
    peaks = cli("spectrum", "--levels", str(levels_file), "--peaks", *asked[:2], *asked[4:])
    assert json.loads(peaks.out)[0]["code"] == "02"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda k: ["-1", *k], "above 0"),
        (lambda k: [str(float(each) ** 2) for each in k], "they look like energies"),
        (lambda k: ["level", *k], "header"),
        (lambda k: [f'[{{"k": {k[0]}}}]'], "is JSON: give csv"),
        (lambda k: [*k[:9], "six", *k[9:]], "six"),
        (lambda k: [], "only 0 levels"),
    ],
)
def test_files_without_levels_are_refused_in_one_line(cli, filled, levels_file, tmp_path, change, told):
    path = tmp_path / "changed.txt"
    path.write_text("\n".join(change(levels_file.read_text().split())))
    assert cli("spectrum", "--levels", str(path), "--db", str(filled)).says(2, told)


@pytest.mark.slow
def test_levels_are_the_known_ones_and_can_be_plotted(cli, filled, tmp_path):
    found = json.loads(cli("levels", "--k", "0:8", "--db", str(filled), "--json").out)
    for parity, known in KNOWN.items():
        assert [row["k"] for row in found if row["parity"] == parity] == pytest.approx(known, abs=1e-9)
    for kind in ("spectrum", "staircase"):
        target = tmp_path / f"{kind}.png"
        found = cli("plot", kind, "-o", str(target), "--db", str(filled))
        assert found.code == 0
        assert target.stat().st_size > 10_000
        assert ("missing from the sum" in found.err) == (kind == "spectrum")


@pytest.mark.parametrize("parity", [None, *Parity])
def test_only_levels_of_the_named_parity_are_read_from_a_table(tmp_path, parity):
    k = [1.0, 2.5, 2.25, 4.0, 5.0, 6.5]
    of = ["ee", "oo", "oe", "ee", "eo", "oo"]
    path = tmp_path / "levels.csv"
    path.write_text("\n".join([" ", "parity, k", *map("{}, {}".format, of, k)]), encoding="utf-8")
    wanted = [each for each, one in zip(k, of, strict=True) if parity in (None, one)]
    assert there(GivenLevels(levels=path).read(parity)).tolist() == sorted(wanted)


@pytest.mark.slow
def test_levels_of_all_parities_end_with_the_shortest_list(filled):
    """The levels of `ee` end at 5, the others at 9. Above 5 nobody knows how many are missing."""
    stored = keep_made_levels(filled)
    for table in ("level", "level_fill"):
        start = "k" if table == "level" else "low"
        alter(filled, f"DELETE FROM {table} WHERE parity = 'ee' AND {start} >= 5")
    catalogue = Catalogue(filled, a=1.6)
    assert catalogue.spectrum((3, 5), resolution=5).k_max == 5
    assert catalogue.spectrum((3, 5), resolution=5, parity="oo").k_max == 9
    given = sorted(k for of in stored.values() for k in of if k < 5)
    expected = catalogue.spectrum((3, 5), resolution=5, levels=given, k=given[-1]).quantum
    found = catalogue.spectrum((3, 5), resolution=5, k=given[-1]).quantum
    np.testing.assert_allclose(there(found), there(expected), atol=1e-12)
    with pytest.raises(InputError, match="the levels have k from 0 to 5"):
        catalogue.spectrum((3, 5), resolution=5, k=6)
    with pytest.raises(InputError, match="levels are stored from k = 0 to 5 only"):
        catalogue.levels(6)
    assert catalogue.levels(9, parity="oo").k.tolist() == stored["oo"]


@pytest.mark.slow
def test_levels_from_orbits_and_lengths_of_a_spectrum_lie_in_the_range_that_was_asked_for(awkward, cli):
    asked = ("levels", "--method", "orbits", "--a", "1.6", "--parity", "oo", "--json", "--k")
    whole, part = (json.loads(cli(*asked, k).out) for k in ("0:9", "7:9"))
    assert part == [row for row in whole if row["k"] >= 7] != whole
    spectrum = ("spectrum", "--a", "1.6", "--parity", "oo", "--lengths", "2:6", "--resolution", "5", "--json")
    assert [row["length"] for row in json.loads(cli(*spectrum).out)] == [2, 3, 4, 5, 6]


@pytest.mark.slow
def test_levels_at_large_k_begin_with_the_time_that_they_take():
    """The estimate precedes the search, which is killed then."""
    child = spawn("levels", "--a", "0.1", "--parity", "oo", "--k", "204:205", "--no-store")
    child.expect("levels up to k = 205 take about [0-9]+ s of processor time")
    child.close(force=True)


def test_levels_at_small_k_do_not_tell_the_time_that_they_take(cli):
    assert "take about" not in cli("levels", "--k", "2:4", "--parity", "oo", "--no-store").err
