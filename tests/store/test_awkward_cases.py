"""Questions about awkward cases: OR and capitals in filters, 0 as a value, negative values, sweeps alone."""

from contextlib import closing

import numpy as np
import pytest
from contents import alter, ask, counts_of, whole
from there import there

from orbitdb import Catalogue, InputError, Selection
from orbitdb.quantum.exact_levels import LevelWindow, ranges_not_stored
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file import reading
from orbitdb.store.stored_values import stored_levels
from orbitdb.store.storing import keep_levels, replace_certificates
from orbitdb.store.writer import Writer
from orbitdb.verification.check_orbits import certify
from orbitdb.verification.verify import report

NAMES = ("code", "p", "status", "walls", "area", "length", "symmetry", "time_reversal")


@pytest.fixture(scope="module")
def catalogue(awkward_once):
    with Catalogue(awkward_once, a=1.6) as catalogue:
        yield catalogue


@pytest.fixture(scope="module")
def words(awkward_once):
    """The words of periods 2-8 at a = 1.6, each as a dict, read by plain SQL."""
    asked = f"SELECT {', '.join(NAMES)} FROM catalogue WHERE a = 1.6 AND p < 9"
    return [dict(zip(NAMES, row, strict=True)) for row in ask(awkward_once, asked)]


FILTERS = {
    "p = 3 OR status = 'dynamical'": lambda w: w["p"] == 3 or w["status"] == "dynamical",
    "P = 3 Or STATUS = 'dynamical'": lambda w: w["p"] == 3 or w["status"] == "dynamical",
    "code = code('031') OR length < 11": lambda w: w["code"] == "031" or (w["length"] or 99) < 11,
    "NOT walls": lambda w: w["walls"] == 0,
    "area < 0": lambda w: (w["area"] or 0) < 0,
    "Area <= -3 or AREA = 0": lambda w: w["area"] is not None and (w["area"] <= -3 or w["area"] == 0),
}


@pytest.mark.parametrize("where", FILTERS)
@pytest.mark.parametrize(
    "criteria", [{"p": "2-8"}, {"p": 4}, {"p": "3,5-6", "walls": (0, 2)}, {"p": 8, "contains": "02"}]
)
def test_a_filter_narrows_the_other_criteria(catalogue, words, where, criteria):
    chosen, criteria = Selection.from_criteria(a=1.6, **criteria), {"status": (), **criteria}
    least, most = criteria.get("walls", (0, 99))
    expected = {
        word["code"]
        for word in words
        if chosen.includes(word["p"])
        and least <= word["walls"] <= most
        and criteria.get("contains", "") in 2 * word["code"]
        and FILTERS[where](word)
    }
    found = [code for (code,) in catalogue.rows(columns=("code",), where=where, **criteria)]
    assert len(found) == len(set(found))
    assert set(found) == expected
    assert catalogue.count(where=where, **criteria) == len(expected)


def test_zero_is_a_value(catalogue, words, cli, awkward):
    straight = {word["code"] for word in words if word["walls"] == 0}
    for asked in ({"walls": 0}, {"walls": (0, 0)}, {"where": "walls = :n", "parameters": {"n": 0}}):
        assert {
            code for (code,) in catalogue.rows(p="2-8", columns=("code",), status=(), **asked)
        } == straight
    least, more = (catalogue.count(p="2-8", walls=span, status=()) for span in ((None, 0), (0, None)))
    assert least == len(straight) < more
    assert [*catalogue.rows(p="2-8", limit=0)] == []
    assert catalogue.count(p="2-8", length=(None, 0)) == 0
    orbits = [word for word in words if word["length"] is not None]
    assert catalogue.count(p="2-8", length=(0, None)) == len(orbits) < len(words)
    found = cli(
        "query",
        "--a",
        "1.6",
        "--p",
        "2-8",
        "--status",
        "orbit,dynamical,boundary",
        "--where",
        "walls = :n",
        "--parameter",
        "n=0",
        "-c",
        "code",
        "--format",
        "csv",
    )
    assert set(found.out.split()[1:]) == straight
    assert cli("query", "--a", "1.6", "--p", "2-8", "--limit", "0", "--json").out == "[]\n"
    assert cli("query", "--a", "1.6", "--range", "length=:0", "--json").out == "[]\n"


@pytest.mark.parametrize("contains", ["", "02"])
@pytest.mark.parametrize("falls", [False, True])
@pytest.mark.parametrize("name", ["area", "length"])
def test_negative_values_are_sorted_and_missing_ones_come_last(catalogue, words, name, falls, contains):
    """Whether a class is chosen whole or, as by a pattern, word by word."""
    chosen = [word[name] for word in words if contains in 2 * word["code"]]
    values = sorted((value for value in chosen if value is not None), reverse=falls)
    expected = values + [None] * (len(chosen) - len(values))
    assert name != "area" or values[0] * values[-1] < 0
    asked = {
        "p": "2-8",
        "columns": (name,),
        "order": f"{name}{' desc' * falls}",
        "contains": contains or None,
        "status": (),
    }
    assert [value for (value,) in catalogue.rows(**asked)] == expected
    assert [value for (value,) in catalogue.rows(**asked, limit=30, offset=3)] == expected[3:33]


@pytest.mark.parametrize("order", ["element", "element desc"])
def test_pruned_words_have_no_element_and_come_last(catalogue, order):
    found = catalogue.rows(p="3-4", status="orbit,geometric", columns=("element", "status"), order=order)
    elements = [element for element, status in found if status == "orbit"]
    assert elements == sorted(elements, reverse=order != "element")
    assert [*found] == [(each, "orbit") for each in elements] + [(None, "geometric")] * (62 + 283)


@pytest.mark.parametrize(
    "asked",
    [{"where": "BORN > 2 OR p = 1"}, {"exists": 2.0}, {"not_at": 2.0}, {"born": (0, 2)}, {"order": "dies"}],
    ids=str,
)
def test_births_are_missed_wherever_they_are_asked_for(catalogue, asked):
    (note,) = (note for note in catalogue.rows(p="7-8", columns=("code",), **asked).notes if "births" in note)
    assert note.startswith("births of period 8 are not stored")
    assert catalogue.rows(p="7-8", columns=("code",), where="length > 2").notes == ()


def test_an_a_with_sweeps_or_levels_alone_is_listed_as_such(catalogue, awkward, cli):
    assert catalogue.a_values() == [0.3, 1.6, 2.0, 2.5, 3.0]
    assert catalogue.a_values(orbits=True) == [0.3, 1.6, 2.5, 3.0]
    assert 1.0 in catalogue.a_values(with_levels=True)
    swept = counts_of(catalogue, a=2.5)
    assert (swept.from_sweeps, swept.from_births) == ((6,), (2, 3, 4, 5, 7))
    assert [*catalogue.rows(a=2.5)] == []
    counted = {a: catalogue.table(a=a, p=6)["N_c"] for a in (2.5, 3.0)}
    assert counted == {
        a: [sweep.tally.n_c for sweep in catalogue.sweeps(a=a) if sweep.p == 6] for a in counted
    }
    assert counts_of(catalogue, p=8).chosen == (8,)
    assert counts_of(catalogue, a=3, p="7-8").from_births == (7,)


def test_periods_that_are_filled_and_swept_count_once(catalogue):
    """At a = 0.3, periods 6 and 7 are both, and the sweep of period 8 was stopped."""
    assert counts_of(catalogue, a=0.3).from_sweeps == ()
    assert catalogue.lyapunov(a=0.3, p="6-8")["p"] == [6, 7]
    rows = [(a, p, state) for a, p, state, *_ in catalogue.info(facts=False).rows]
    assert [row for row in rows if row[0] == 0.3] == [
        *((0.3, p, "done") for p in (2, 3, 4, 6, 7)),
        (0.3, 8, "sweeping"),
    ]
    assert rows == sorted(rows)


def test_counts_are_of_the_chosen_periods_wherever_they_come_from(catalogue):
    chosen = counts_of(catalogue, a=3, p="4-7")
    assert (chosen.chosen, chosen.from_sweeps, chosen.from_births) == ((4, 5, 6, 7), (4, 5, 6), (7,))
    assert counts_of(catalogue, a=2.5, p="4-6").from_births == (4, 5)
    assert catalogue.table(a=3, p="4-5")["p"] == [4, 5]


def test_averages_over_what_births_decide_leave_out_periods_without_births(catalogue):
    found = catalogue.lyapunov(p="7-8", exists=2.0)
    assert found["p"] == [7]
    assert any("births of period 8 are not stored" in note for note in found.notes)


def test_levels_keep_their_numbers_across_a_gap(catalogue, awkward_once):
    """At a = 1.6, levels ee are stored for k = 0-6 and 8-9, and oo for 0-6."""
    stored = dict(ask(awkward_once, "SELECT number, k FROM level WHERE a = 1.6 AND parity = 'ee'"))
    found = catalogue.levels(9, parity="ee", method="orbits")
    counterparts = catalogue._stored_counterparts(found)
    assert counterparts == [stored.get(number) for number in range(1, len(found) + 1)]
    assert None in counterparts[: max(stored)]
    with pytest.raises(InputError, match=r"only ee, oo levels are stored at a = 1\.6: choose one of these"):
        catalogue.levels()
    assert catalogue.levels(parity="ee").high == 6
    assert catalogue.levels(parity=["ee", "oo"]).parities == ("ee", "oo")
    for k, ends in (
        ((8, 9), (8, 9)),
        ((8, None), (8, 9)),
        ((2, 5), (2, 5)),
        ((5, None), (5, 6)),
        (4, (0, 4)),
    ):
        some = catalogue.levels(k, parity="ee")
        assert (some.low, some.high) == ends
        assert some.k.tolist() == [each for each in sorted(stored.values()) if ends[0] <= each < ends[1]]
    with pytest.raises(InputError, match=r"are stored from k = 5 to 6 only at .*k=\(5, 7\)"):
        catalogue.levels((5, 7), parity="ee")
    assert catalogue.levels((5, 9), parity="ee", method="orbits").k.tolist() == [k for k in found.k if k >= 5]


@pytest.mark.parametrize(
    ("low", "high", "missing"),
    [(1, 5, []), (5, 7, [(6, 7)]), (7, 9, [(7, 8)]), (8.5, 10, [(9, 10)]), (0, 10, [(6, 8), (9, 10)])],
)
def test_only_levels_that_are_not_stored_are_computed(awkward_once, low, high, missing):
    with reading(awkward_once) as connection:
        windows = stored_levels(connection, 1.6, Parity.EE)
    assert list(ranges_not_stored(windows, low, high)) == missing


def test_stored_levels_agree_with_weyls_law_in_any_part_of_their_range(awkward):
    found = Catalogue(awkward, 1.6).fill_levels((8.3, 9), parity=["ee"])
    off = float(found.notes[0].split("on average ")[1].split()[0])
    assert abs(off) < 1
    assert 0 < len(found) < 4


def test_a_death_ends_an_orbit(catalogue, awkward_once):
    ((word, died),) = ask(
        awkward_once, "SELECT word, a FROM change JOIN cycle ON id = cycle WHERE kind = 'died'"
    )
    born = died - 0.5
    alive = {
        a: word in {code for (code,) in catalogue.rows(p=len(word), columns=("representative",), exists=a)}
        for a in (born - 1e-3, born + 1e-3, died - 1e-3, died + 1e-3)
    }
    assert [*alive.values()] == [False, True, True, False]
    for a, lives in alive.items():
        gone = catalogue.rows(p=len(word), columns=("representative",), not_at=a)
        assert (word in {code for (code,) in gone}) != lives
    (life,) = (life for life in catalogue.births(len(word)) if life.word == word)
    assert (life.born, life.dies) == (pytest.approx(born), died)


def test_certificates_belong_to_one_a(catalogue, awkward_once):
    for a in (0.3, 1.6):
        stored = ask(
            awkward_once,
            "SELECT word, radius, bits FROM certificate JOIN cycle ON cycle.id = cycle"
            f" JOIN stadium ON stadium.id = stadium WHERE a = {a}",
        )
        for word, *proof in stored:
            assert catalogue.certificate(catalogue.orbit(word, a=a)) == tuple(proof)
        assert stored
        assert catalogue.certificate(catalogue.orbit(stored[0][0], a=3)) is None


def test_bounds_in_balls_and_in_doubles_stay_apart(awkward):
    """Those in the file are in doubles."""
    catalogue = Catalogue(awkward, 1.6)
    assert catalogue.entropy_bounds(arithmetic="balls") is None
    catalogue.prove_bounds(2, prove=True, a=0.3)
    assert [each.a for each in catalogue.entropy_curve(arithmetic="balls")] == [0.3]
    assert [each.a for each in catalogue.entropy_curve(arithmetic="doubles")] == [0.3, 1.6]
    kept = [catalogue.entropy_bounds(a=0.3, arithmetic=name) for name in ("balls", "doubles")]
    assert [there(each).arithmetic for each in kept] == ["balls", "doubles"]


def test_work_on_some_periods_returns_these_alone(awkward):
    catalogue = Catalogue(awkward, 0.3)
    for found in (catalogue.fill("3,7"), catalogue.sweep("8-9"), catalogue.fill_births("2,5")):
        assert len(found) == 2
    assert [each.p for each in catalogue.fill(3)] == [2, 3]
    assert [each.p for each in catalogue.fill([3])] == [each.p for each in catalogue.fill("3-3")] == [3]


def test_new_proofs_replace_those_at_their_a_alone(awkward):
    before = whole(awkward)["certificate"]
    alter(awkward, "DELETE FROM certificate WHERE stadium = 2")
    assert report(certify(awkward, Selection(0.3, periods=((2, 3),))))[0].failures == 0
    after = whole(awkward)["certificate"]
    assert [row for row in after if row[0] == 1] == [row for row in before if row[0] == 1] != []
    assert {row[1] for row in after if row[0] == 1} & {row[1] for row in after if row[0] == 2}


def test_proofs_of_orbits_that_are_gone_or_replaced_are_not_stored(awkward):
    before = whole(awkward)
    (kept, run), (other, old) = ask(awkward, "SELECT cycle, run FROM orbit WHERE stadium = 2 LIMIT 2")
    (gone,) = ask(
        awkward, "SELECT max(id) FROM cycle WHERE id NOT IN (SELECT cycle FROM orbit WHERE stadium = 2)"
    )
    alter(awkward, f"UPDATE orbit SET run = {old + 1} WHERE stadium = 2 AND cycle = {other}")
    proved = [(cycle, by, 1e-9, 128) for cycle, by in ((kept, run), (other, old), (*gone, run))]
    with closing(Writer(awkward, {"command": "verify"})) as writer, writer.transaction() as connection:
        replace_certificates(writer, connection, 2, [kept, other, *gone], proved, "1")
    after = whole(awkward)["certificate"]
    assert [row[:4] for row in after if row not in before["certificate"]] == [(2, kept, 1e-9, 128)]


def test_classes_have_one_row_each_in_the_order_that_was_asked_for(awkward, cli):
    asked = (
        "query",
        "--a",
        "1.6",
        "--p",
        "3-5",
        "--status",
        "orbit,dynamical,boundary",
        "--classes",
        "--format",
        "csv",
        "-c",
        "code",
    )
    for order, falls in (("code", False), ("code desc", True)):
        listed = cli(*asked, "--order", order).out.split()[1:]
        assert listed == sorted(listed, reverse=falls)
    assert len(listed) == len({*listed}) == 2 + 8 + 17


@pytest.mark.parametrize(
    ("low", "high", "kept"),
    [
        (6.0, 8.0, [(6.0, 8.0, 20)]),
        (5.9, 8.0, [(6.0, 8.0, 20)]),
        (4.0, 8.1, [(6.0, 8.0, 20)]),
        (2.0, 3.0, []),
        (7.0, 10.0, [(7.0, 8.0, 20), (9.0, 10.0, 21)]),
        (9.0, 9.5, [(9.0, 9.5, 20)]),
    ],
)
def test_only_the_new_part_of_a_window_of_levels_is_stored(awkward, low, high, kept):
    """Windows 0-6 and 8-9 of parity ee are stored; the levels of 6-8 lie between theirs."""
    before = whole(awkward)
    k = np.array([(7.1 if low < 7 else low), high - 0.1])
    below = 20 - int((k < 6).sum())
    levels = LevelWindow(1.6, Parity.EE, low, high, below, k, k * 1e-12)
    with closing(Writer(awkward, {"command": "levels"})) as writer:
        assert keep_levels(writer, levels) == bool(kept)
    after = whole(awkward)
    new = [row[:5] for row in after["level"] if row not in before["level"]]
    numbered = [(1.6, "ee", 21 + n, each, each * 1e-12) for n, each in enumerate(k)]
    assert new == [row for row in numbered if any(one <= row[3] < other for one, other, _ in kept)]
    found = [row[2:5] for row in after["level_fill"] if row not in before["level_fill"]]
    assert found == kept
    assert {**after, "level": [], "level_fill": []} == {**before, "level": [], "level_fill": []}
