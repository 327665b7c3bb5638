"""The shell, Python and the screen answer alike: the same default a, periods and statuses."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from screens import browsing

from orbitdb import Catalogue, InputError
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.snapshots import given_a

STORED = {"none": [], "one": [1.0], "levels": [], "several": [1.0, 1.6], "without 1.6": [1.0, 2.0]}
"""The values of a with periods 2 to 4 in each catalogue."""

DEFAULT = {"none": 1.6, "one": 1.0, "levels": 0.7, "several": 1.6, "without 1.6": None}
NOTES = {
    "one": "a = 1, the only value in orbits.db",
    "levels": "a = 0.7, the only value in orbits.db",
    "several": "a = 1.6, of 2 values in orbits.db",
}

NAMES = ("code", "a", "p", "status", "length")


def of_result(found: Any) -> list[dict[str, Any]]:
    return [dict(zip(found.columns, row, strict=True)) for row in found.rows()]


def of_rows(catalogue: Catalogue, **asked: Any) -> list[dict[str, Any]]:
    return [dict(zip(NAMES, row, strict=True)) for row in catalogue.rows(columns=NAMES, **asked)]


def of_births(fills: Any) -> list[dict[str, Any]]:
    names = ("p", "classes", "births", "deaths", "always", "least", "largest")
    return [{name: getattr(fill, name) for name in names} for fill in fills]


QUESTIONS: dict[str, Callable[[Catalogue], list[dict[str, Any]]]] = {
    "query --p 4 -c code,a,p,status,length": lambda c: of_rows(c, p=4),
    "query -p 2-4 -c code,a,p,status,length --status all": lambda c: of_rows(c, p="2-4", status="all"),
    "query --where rules=1 -c code,a,p,status,length": lambda c: of_rows(c, where="rules=1"),
    "query --p 4 --exists 0.5 -c code,a,p,status,length": lambda c: of_rows(c, p=4, exists=0.5),
    "export - --format json --code 310 -c code,a,p,status,length": lambda c: of_rows(c, code="310"),
    "query --a all --p 3 -c code,a,p,status,length": lambda c: of_rows(c, p=3, a="all"),
    "count --p 2-4": lambda c: of_result(c.count(p="2-4", by=[])),
    "count --p 4 --by status": lambda c: of_result(c.count(p=4, by="status")),
    "table --p 3-4": lambda c: of_result(c.table(p="3-4")),
    "table --a all": lambda c: of_result(c.table(a="all")),
    "entropy --p 2-4": lambda c: of_result(c.entropy(p="2-4")),
    "lyapunov --p 2-4 --where status='dynamical'": lambda c: of_result(
        c.lyapunov(p="2-4", where="status='dynamical'")
    ),
    "field --kappa 0.05 --p 4": lambda c: of_result(c.field(0.05, p=4)),
    "births --p 4": lambda c: of_births(c.fill_births(4)),
    "sweep --p 5": lambda c: [row.row() for row in c.sweep(5)],
    "simulate --bounces 2000 --no-store": lambda c: [c.simulate(2000, store=False).row()],
    "bounds --edges 4 --no-store": lambda c: [one.row() for one in c.search_bounds(4, store=False)],
}
"""What a command asks, and the same question in Python."""

WITHOUT_A = {"births --p 4", "table --a all", "query --a all --p 3 -c code,a,p,status,length"}


@pytest.fixture(params=STORED)
def stored(request, made_once):
    """A catalogue with no, one or several values of a, or with levels alone."""

    def make(path):
        catalogue = Catalogue.create(path)
        for a in STORED[request.param]:
            catalogue.fill(4, a=a)
        if request.param == "levels":
            catalogue.fill_levels(2, parity="ee", a=0.7)

    return request.param, made_once(f"stored-{request.param}", make)


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_shell_and_python_give_the_same_rows(question, stored, tmp_path, cli):
    kind, path = stored
    own = tmp_path / "orbits.db"
    own.write_bytes(path.read_bytes())
    form = () if "--format" in question else ("--json",)
    done = cli(*question.split(), *form)
    ask = QUESTIONS[question]
    if DEFAULT[kind] is None and question not in WITHOUT_A:
        assert done.says(2, "a = 1, 2", "--a")
        with pytest.raises(InputError, match="a = 1, 2"):
            ask(Catalogue(own))
        return
    assert done.code in (0, 1), done.err
    expected = ask(Catalogue(own))
    shown = json.loads(done.out or "[]")
    assert json.loads(json.dumps(expected)) == shown
    assert (done.code == 1) == (not shown)
    if question not in WITHOUT_A:
        assert {row["a"] for row in shown if "a" in row} <= {DEFAULT[kind]}
        assert (NOTES.get(kind) in done.err.splitlines()) == (kind in NOTES)
    if question == "query --p 4 -c code,a,p,status,length":
        assert cli(*question.split(), *form, "-q").err == (f"{NOTES[kind]}\n" if kind in NOTES else "")


@pytest.mark.parametrize("asked", [{}, {"status": "all"}, {"where": "status = 'dynamical'"}])
async def test_the_screen_shows_the_rows_of_the_shell(stored, asked, cli):
    kind, path = stored
    if DEFAULT[kind] is None or not STORED[kind]:
        return
    chosen = SelectionOptions(p="4", **asked).at(given_a(path, None)[0])
    options = [text for name, value in asked.items() for text in (f"--{name}", value)]
    done = cli("query", "--p", "4", *options, "-c", "code", "--format", "csv", "--db", str(path))
    async with browsing(path, selection=chosen) as (app, pilot):
        await app.workers.wait_for_complete()
        await pilot.pause()
        source = app.screen_stack[0].rows.table.source
        assert [source.row(place)[0] for place in range(len(source))] == done.out.split()[1:]


def test_a_result_in_python_says_which_a_it_took(stored):
    kind, path = stored
    if DEFAULT[kind] is None:
        return
    catalogue = Catalogue(path)
    for found in (catalogue.table(), catalogue.entropy(), catalogue.rows()):
        assert (NOTES.get(kind) in found.notes) == (kind in NOTES)
    assert not any(note.startswith("a = ") for note in Catalogue(path, DEFAULT[kind]).rows().notes)


def test_a_subset_and_a_list_of_one_are_verified_with_the_same_notes(filled):
    from orbitdb import Selection

    catalogue, chosen = Catalogue(filled), Selection(1.6, periods=((8, 9),))
    assert catalogue.verify([chosen]).notes == catalogue.verify(chosen).notes != ()
