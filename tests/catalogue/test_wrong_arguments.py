"""A wrong type or value gives one clear line, before anything is done."""

import inspect
from typing import Any

import numpy as np
import pytest

import orbitdb as orbitdb_
from orbitdb import Catalogue, InputError

orbitdb: Any = orbitdb_  # so that wrong types can be given

REQUIRED = {"k": 5.0, "code": "13", "length": 10.4, "p": 2, "a": 1.6, "name": "lengths",
            "statement": "SELECT 1 AS one", "column": "length", "columns": ["p"],
            "folder": "data", "kappa": 0.05, "target": "nowhere/copy.db", "path": "atlas.html",
            "paths": ["part.db"]}  # fmt: skip
"""Values for the parameters that have no default."""

UNCHECKED = {"self", "coordinates", "classes", "orbits", "window", "fit_radius", "geometric", "legwise",
             "prove", "births", "store", "over_a", "exists", "sweep", "force", "facts",
             "with_levels"}  # fmt: skip
"""True or false; anything is one or the other."""

OF_OBJECTS = {
    "snapshot", "born_with", "certificate", "keep", "search_bounds",
}  # fmt: skip
"""Methods that take a function, or what another method returns; and the iterator behind `prove_bounds`."""

METHODS = sorted(
    name
    for name, value in inspect.getmembers(Catalogue, inspect.isfunction)
    if not name.startswith("_") and name not in OF_OBJECTS
)


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    catalogue = Catalogue.create(tmp_path_factory.mktemp("wrong") / "c.db")
    catalogue.fill("2-4")
    return catalogue


@pytest.mark.parametrize("method", METHODS)
def test_an_argument_of_a_wrong_type_is_an_error_and_stores_nothing(catalogue, method):
    call = getattr(catalogue, method)
    before = catalogue.contents(1.6)
    parameters = inspect.signature(call).parameters
    required = {name: REQUIRED[name] for name, one in parameters.items() if one.default is one.empty}
    for name in parameters.keys() - UNCHECKED - {"progress", "only"}:
        for wrong in (object(), [object()]):
            with pytest.raises(InputError) as refused:
                list(call(**required | {name: wrong}))
            assert "\n" not in str(refused.value)
    assert catalogue.contents(1.6) == before


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda c: c.births("7"), "p = '7': give a whole number"),
        (lambda c: c.births(7.5), r"p = 7\.5: give a whole number"),
        (lambda c: c.scars((1, 2), parity=3), "parity 3: use ee, eo, oe or oo"),
        (lambda c: c.fill(3, jobs=1.5), r"jobs = 1\.5: give a whole number"),
        (lambda c: c.lyapunov(True), "choose a subset by criteria"),
        (lambda c: c.count(parameters=7), "parameters = 7: give a dict"),
        (lambda c: c.simulate(seed=-1), "seed = -1: give a whole number, 0 or more"),
        (lambda c: c.verify(seed="x"), "seed = 'x': give a whole number, 0 or more"),
        (lambda c: c.fill("2", workers=2), "workers = 2: give an open Cluster"),
        (lambda c: c.born_with("13"), "'13' is not an Orbit"),
        (lambda c: c.certificate("13"), "'13' is not an Orbit"),
        (lambda c: c.lyapunov(cut=True), "cut = True: give a number"),
        (lambda c: c.field(None), "kappa = nan: give one number"),
        (lambda c: c.select(a=[1.0, 1.6]), "give one a here; rows, table"),
        (lambda c: c.count(p=3, a="all"), "give one a here; rows, table"),
        (lambda c: c.count(by="a"), "column 'a': it comes first if you ask for several a, such as `a='all'`"),
        (
            lambda c: c.plot("p.png"),
            "figure 'p.png': name a figure, such as 'lengths', and write it with sav",
        ),
        (lambda c: c.assess("x"), "the levels must be numbers"),
        (lambda c: c.spectrum({}), "lengths {}: give a range"),
        (lambda c: c.select().averages(weight="x"), "weight 'x': use exp or det"),
        (lambda c: orbitdb.Catalogue(1.6), r"path = 1\.6: give the path of a file; a half length is a=1\.6"),
        (lambda c: c.levels("30"), "k = '30': give a number"),
        (lambda c: c.lyapunov(cut="9"), "cut = '9': give a number"),
        (lambda c: c.prove_bounds(width="1"), "width = '1': give a number"),
        (lambda c: c.identify(length="10.4"), r"length = '10\.4': give a number"),
        (lambda c: c.select(symmetry=1), "symmetry = 1: give a text such as 'x,T,xT'"),
        (lambda c: orbitdb.levels(1.6, "oo"), "k = 'oo': give a number"),
        (lambda c: orbitdb.solve(7.5, 1.6), "a code is a string"),
        (lambda c: orbitdb.simulate(1.6, 1000, seed=-1), "seed = -1"),
        (lambda c: next(orbitdb.waves(1.6, (1, 2), None)), "waves have one parity"),
    ],
)
def test_a_wrong_value_is_named_as_one_writes_it_in_python(catalogue, call, said):
    with pytest.raises(InputError, match=said):
        call(catalogue)


def test_numbers_and_arrays_of_numpy_are_numbers_and_lists(catalogue):
    assert catalogue.count(p=np.int64(3), exists=np.array([])) == 8
    for two in (np.int64(2), (2, np.uint8(2))):
        assert catalogue.count(walls=two) == catalogue.count(walls=2) > 0
    for eleven in (np.int64(11), np.float32(11)):
        x = {"x": eleven}
        assert catalogue.count(where="length < :x", parameters=x) == 5
        assert len([*catalogue.sql("SELECT p FROM catalogue WHERE length < :x", parameters=x)]) == 5
    assert orbitdb.simulate(1.6, 1e3) == orbitdb.simulate(1.6, 1000)
    assert catalogue.identify(length=np.float32(10.4), limit=np.int64(1))[0].code == "13"
    assert [*catalogue.rows(p=np.array([2]), columns=np.array(["code"]))] == [("13",)]


def test_an_unknown_column_of_a_result_is_named_with_the_known_ones(catalogue):
    with pytest.raises(KeyError, match="no column 'n_c': the columns are p, N_t, N_c"):
        catalogue.table()["n_c"]


def test_masked_values_are_left_out_and_complex_ones_refused(catalogue):
    orbit = orbitdb.solve_word("0123", 1.6)
    points = np.ma.array(np.vstack([orbit.points[:2], [[9.0, 9.0]], orbit.points[2:]]))
    points[2, 0] = np.ma.masked
    assert catalogue.identify(points=points).shadowed[0].orbit == orbit
    assert catalogue.field(np.ma.array([0.05, 0.1], mask=[True, False]), code="0123").kappa.tolist() == [0.1]
    k = np.ma.array([1.0, 2, 3], mask=[False, True, False])
    with pytest.raises(InputError, match="the list has only 2 levels"):
        catalogue.spectrum(levels=k)
    subset = catalogue.select(p="2-3")
    assert subset[np.ma.array([0, 1, 2], mask=[False, True, False])].code.tolist() == [*subset.code[[0, 2]]]
    long = np.ma.array(subset.length > 0, mask=subset.length > 10.5)
    assert subset[long].code.tolist() == ["13"]
    for call in (
        lambda: catalogue.assess(np.arange(1, 20) + 0j),
        lambda: catalogue.field(np.array([0.1 + 0j]), code="0123"),
        lambda: catalogue.identify(points=orbit.points + 0j),
        lambda: catalogue.identify(start=np.array([0, 0.5, 1.2 + 0j])),
    ):
        with pytest.raises(InputError, match="these are complex: give their real parts"):
            call()


def test_a_wave_is_blank_where_a_point_is_masked_and_has_no_complex_points():
    wave = next(orbitdb.waves(1.6, (1, 4), "ee"))
    x = np.ma.array([0.1, 0.2], mask=[False, True])
    assert wave.psi(x, 0.3)[0] == pytest.approx(wave.psi(0.1, 0.3))
    assert np.isnan(wave.psi(x, 0.3)[1])
    with pytest.raises(InputError, match="x and y: give numbers; these are complex"):
        wave.psi(0.1 + 0j, 0.3)


def test_several_half_lengths_can_be_an_array(catalogue):
    found = [*catalogue.search_bounds(3, a=np.array([1.0, 2.0]), jobs=1, store=False)]
    assert [(one.a, one.edges) for one in found] == [(1.0, 2), (1.0, 3), (2.0, 2), (2.0, 3)]


def test_births_that_are_not_stored_say_so_at_the_prompt(catalogue):
    shown = repr(catalogue.births(4))
    assert shown.startswith("[]\nbirths of period 4 are not stored: ")
