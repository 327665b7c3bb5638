"""Methods in Python store exactly the same bits as the commands."""

import sqlite3
from contextlib import closing

import pandas
import pytest
from contents import ask, content

from orbitdb import Catalogue, Fill, InputError, Levels, StoreError, Sweep, Verification

A = 0.7


def made_both_ways(cli, tmp_path, commands, make):
    """Return two catalogues, one made with commands and the other in Python."""
    by_commands, by_python = tmp_path / "orbits.db", tmp_path / "python.db"
    for command in commands:
        assert cli(*command.split()).code == 0
    with Catalogue.create(by_python, A) as catalogue:
        make(catalogue)
    return by_commands, by_python


def test_a_fill_from_python_stores_the_rows_of_the_command(cli, tmp_path):
    def make(catalogue):
        found = catalogue.fill("2-6", geometric=True)
        catalogue.fill(code="1^8 3")
        assert [(each.p, each.done) for each in found] == [(p, True) for p in range(2, 7)]
        assert isinstance(found[0], Fill)

    commands = [f"fill --p 6 --a {A} --geometric", f"fill --code 111111113 --a {A}"]
    one, other = made_both_ways(cli, tmp_path, commands, make)
    assert content(one) == content(other)


def test_single_words_are_stored_at_the_a_and_by_the_method_that_were_asked_for(cli, tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", A)
    catalogue.fill(code=["013"], a=1.3, method="relaxation")
    assert cli("fill", "--code", "13", "--a", "1.3", "--method", "relaxation").code == 0
    assert catalogue.a_values() == [1.3]
    found = catalogue.rows(a=1.3, columns=("representative", "solver"))
    assert {*found} == {("013", "relaxation"), ("13", "relaxation")}


@pytest.mark.parametrize(
    ("command", "make", "query"),
    [
        ("births --p 5", lambda c: c.fill_births(range(2, 6)),
         "SELECT cycle, number, a, error, kind FROM change ORDER BY cycle, number"),
        (f"sweep --p 6 --a {A}", lambda c: c.sweep("2-6"),
         "SELECT p, words, n_c, sums FROM sweep ORDER BY p"),
        (f"bounds --a {A} --edges 6 --store", lambda c: c.prove_bounds(6),
         "SELECT a, proof, edges, lower, upper FROM entropy_bound ORDER BY edges"),
        (f"simulate --a {A} --bounces 20000 --seed 3", lambda c: c.simulate(20_000, seed=3),
         "SELECT lambda_d, lambda_d_error, seed FROM trajectory"),
        pytest.param(f"levels --k 0:3 --a {A} --parity ee", lambda c: c.fill_levels(3, parity=["ee"]),
         "SELECT a, parity, number, k, error FROM level ORDER BY number", marks=pytest.mark.slow),
    ],
    ids=["births", "sweep", "bounds", "simulate", "levels"],
)  # fmt: skip
def test_python_makes_what_the_command_makes(cli, tmp_path, command, make, query):
    one, other = made_both_ways(cli, tmp_path, [command], make)
    rows = ask(one, query)
    assert rows
    assert ask(other, query) == rows


def test_a_fill_reports_progress_and_resumes(tmp_path):
    catalogue, told = Catalogue.create(tmp_path / "orbits.db", A), []

    def stop(done, total, text):
        told.append((done, total, text))
        if done > 41:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        catalogue.fill("2-7", progress=stop)
    assert told[0][:2] == (0, told[-1][1])
    stored = catalogue.count()
    assert 41 < stored < told[-1][1]
    catalogue.fill("2-7", progress=lambda *state: told.append(state))
    assert told[-1][0] == told[-1][1] > stored
    assert all(fill.done for fill in catalogue.fills())
    catalogue.close()
    assert [path.name for path in tmp_path.iterdir()] == ["orbits.db"]


def test_verify_returns_an_object(filled_once, tmp_path):
    found = Catalogue(filled_once).verify(p="2-4", sample=5, seed=1)
    assert isinstance(found, Verification)
    assert found.sound
    assert repr(found).startswith("<sound: ")
    frame = found.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert set(frame["check"]) >= {"file", "counts", "statuses"}
    assert not frame["failures"].any()


@pytest.mark.slow
def test_stored_levels_are_read_back_by_range_and_parity(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", A)
    with pytest.raises(
        InputError, match=r"no levels are stored from k = 0 on at a = 0\.7: `catalogue.fill_levels"
    ):
        catalogue.levels()
    catalogue.fill_levels(6, parity=["oo", "ee"])
    found = catalogue.levels(parity="oo")
    assert isinstance(found, Levels)
    assert set(found.parity.tolist()) == {"oo"}
    assert found.to_pandas()["k"].tolist() == found.k.tolist() == sorted(found.k)
    assert catalogue.levels(2.5, parity="ee").k.max() < 2.5
    with pytest.raises(InputError, match="stored from k = 0 to 6 only"):
        catalogue.levels(7, parity="ee")
    with pytest.raises(InputError, match=r"only ee, oo levels are stored at a = 0\.7: choose one of these"):
        catalogue.levels()


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda c: c.fill(), "say what to fill"),
        (lambda c: c.fill("1-5"), "least period is 2"),
        (lambda c: c.fill("2-99"), "highest period is"),
        (lambda c: c.fill("2-3", method="magic"), "method 'magic'"),
        (lambda c: c.fill(code=["1313"]), "give .13."),
        (lambda c: c.fill(3, a=0), "half length"),
        (lambda c: c.fill(3, jobs=0), "jobs = 0: give a whole number, 1 or more"),
        (lambda c: c.sweep(3, workers="x"), "workers = 'x': give an open Cluster"),
        (lambda c: list(c.rows(limit=-1)), "limit = -1: give a whole number, 0 or more"),
        (lambda c: c.fill_births("x"), "periods 'x'"),
        (lambda c: c.prove_bounds(width=-1), "above 0"),
        (lambda c: c.fill_levels(3, parity=["xx"]), "use ee, eo, oe or oo"),
        (lambda c: c.fill_levels((5, 3)), "is not a range"),
        (lambda c: c.fill_levels(3, parity=[]), "no parity: use ee, eo, oe or oo"),
        (lambda c: c.levels(-1), "k = -1: give a number above 0"),
        (lambda c: c.simulate(0), "bounces = 0: give a whole number, 1 or more"),
        (lambda c: c.simulate(0, legwise=True), "bounces = 0"),
        (lambda c: c.verify(sample=0), "sample = 0: give a whole number, 1 or more"),
        (lambda c: c.verify(restarts=-1), "restarts = -1: give a whole number, 0 or more"),
    ],
)
def test_bad_input_is_refused_and_nothing_is_stored(tmp_path, make, told):
    path = tmp_path / "orbits.db"
    catalogue = Catalogue.create(path, 1.6)
    before = path.read_bytes()
    with pytest.raises(InputError, match=told):
        make(catalogue)
    assert path.read_bytes() == before


def test_the_seed_is_drawn_from_a_given_generator(tmp_path):
    import numpy as np

    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    found = catalogue.simulate(5_000, seed=np.random.default_rng(7))
    assert found.seed == int(np.random.default_rng(7).integers(2**63))
    assert catalogue.reference() == found
    swept = catalogue.sweep(3)[0]
    assert isinstance(swept, Sweep)
    assert "\n" not in repr(swept)


def test_a_file_that_cannot_be_written_is_refused(filled):
    catalogue = Catalogue(filled)
    filled.unlink()
    with pytest.raises(StoreError):
        catalogue.fill("2-9")
    assert not filled.exists()


@pytest.fixture
def empty(tmp_path):
    with Catalogue.create(tmp_path / "empty.db") as catalogue:
        yield catalogue


def test_a_bare_text_is_one_word(empty):
    empty.fill(code="1232131")
    assert {orbit.p for orbit in empty.select()} == {7}


def test_words_are_texts(empty):
    with pytest.raises(InputError, match="code = 1232131: give a text, or a list"):
        empty.fill(code=1232131)


def test_bounds_say_which_arithmetic_proved_them(empty):
    assert empty.prove_bounds(5, prove=True) == empty.entropy_bounds()
    assert empty.entropy_bounds().arithmetic == "balls"


def test_a_missing_catalogue_is_to_be_made_where_it_was_looked_for(tmp_path):
    path = tmp_path / "none.db"
    with pytest.raises(StoreError, match=rf"`Catalogue.create\('{path}'\).fill\(p=11\)`"):
        Catalogue(path)


@pytest.mark.parametrize("words", ["1", ["13", "0"]])
def test_a_word_of_one_symbol_is_refused_before_anything_is_stored(empty, words):
    with pytest.raises(InputError, match="has one symbol, but orbits have two or more"):
        empty.fill(code=words)
    with pytest.raises(InputError, match="has one symbol"):
        empty.fill(code="1")
    assert empty.verify().sound
    assert not empty.a_values()


@pytest.mark.parametrize("edges", [0, 1, -1, 41])
def test_windows_of_impossible_length_are_refused(empty, edges):
    with pytest.raises(InputError, match=f"windows of {edges} edges: give a whole number from 2 to 40"):
        empty.prove_bounds(edges)


def test_a_simulation_whose_result_cannot_be_stored_does_not_begin(empty, monkeypatch):
    monkeypatch.setattr("orbitdb.store.sqlite.BUSY_TIMEOUT", 0.01)

    def began(done, total, text):
        raise AssertionError("it began")

    with closing(sqlite3.connect(empty.path, timeout=60)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StoreError, match=r"busy|locked|another"):
            empty.simulate(10_000, progress=began)
