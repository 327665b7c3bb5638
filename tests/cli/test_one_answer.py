"""The shell, Python and the screen answer alike: the same default a, periods and statuses."""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import typer
from quick import slow_but
from screens import browsing, press, write
from textual.pilot import Pilot
from textual.widgets import Label

from orbitdb import Catalogue, InputError
from orbitdb.answers.subset import Subset
from orbitdb.cli.advice import completed
from orbitdb.cli.app import program
from orbitdb.cli.commands.assess import COLUMNS as ASSESSED
from orbitdb.cli.commands.identify import LENGTH_KEYS
from orbitdb.cli.commands.verify import COLUMNS as CHECKED
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.snapshots import given_a
from orbitdb.cli.tui.app import BrowseApp
from orbitdb.cli.tui.counts_screen import CountsList
from orbitdb.errors import NotStoredError
from orbitdb.open_stadium import rates
from orbitdb.output_files import metadata_path
from orbitdb.text import as_options, format_float

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
    return of_named(found.columns, found.rows())


def of_rows(catalogue: Catalogue, **asked: Any) -> list[dict[str, Any]]:
    return of_named(NAMES, catalogue.rows(columns=NAMES, **asked))


def of_named(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[dict[str, Any]]:
    return [dict(zip(names, row, strict=True)) for row in rows]


def of_columns(columns: dict[str, list[Any]]) -> list[dict[str, Any]]:
    return of_named([*columns], zip(*columns.values(), strict=True))


def of_levels(levels: Any) -> list[dict[str, Any]]:
    columns = levels.k.tolist(), levels.error.tolist(), levels.parity.tolist()
    return of_named(("k", "error", "parity"), zip(*columns, strict=True))


def of_candidates(catalogue: Catalogue, found: Any) -> list[dict[str, Any]]:
    names = [name for name in LENGTH_KEYS if name != "a"]
    return [{name: getattr(each, name) for name in names} | {"a": catalogue.a} for each in found]


def of_fills(fills: Any) -> str:
    words, orbits = (sum(getattr(fill, name) for fill in fills) for name in ("n_t", "n_c"))
    return f"{words} words, {orbits} orbits"


def of_subset(found: Subset) -> str:
    return found.unfilled or found.selection.describe()


def of_births(fills: Any) -> list[dict[str, Any]]:
    names = ("p", "classes", "births", "deaths", "always", "least", "largest")
    return [{name: getattr(fill, name) for name in names} for fill in fills]


QUESTIONS: dict[str, Callable[[Catalogue], list[dict[str, Any]] | str]] = {
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
    "escape --opening top:-0.3:0.3 --trajectories 500 --bounces 3 --no-store --jobs 1": lambda c: of_columns(
        c.escape("top:-0.3:0.3", trajectories=500, bounces=3, store=False).columns()
    ),
    "levels --k 0:2 --parity ee --no-store": lambda c: of_levels(c.fill_levels(2, parity="ee", store=False)),
    "levels --method orbits": lambda c: of_levels(c.levels(method="orbits")),
    "spectrum --lengths 3:20 --resolution 3": lambda c: of_named(
        ("length", "quantum_re", "quantum_im", "orbits_re", "orbits_im"),
        c.spectrum((3, 20), resolution=3).rows(),
    ),
    "assess": lambda c: of_named(ASSESSED, c.assess().gaps),
    "scars 13 --k 2:2.3 --parity ee": lambda c: [
        scar._asdict() for scar in c.scars((2, 2.3), code="13", parity="ee")
    ],
    "identify --start 0,0.1,0.5 --limit 3": lambda c: of_result(c.identify(start=(0, 0.1, 0.5), limit=3)),
    "identify --length 11.2 --tolerance 0.2": lambda c: of_candidates(
        c, c.identify(length=11.2, tolerance=0.2)
    ),
    "verify --p 3": lambda c: of_named(CHECKED, map(astuple, c.verify(p=3).checks)),
    "fill --p 5": lambda c: of_fills(c.fill(5)),
    "plot phase-space --p 3 -o drawn.svg -f": lambda c: of_subset(c.select(p=3)),
}
"""What a command asks, and the same question in Python: its rows, or a text in the notes of the command."""

WITHOUT_A = {
    "births --p 4",
    "table --a all",
    "query --a all --p 3 -c code,a,p,status,length",
    "verify --p 3",
}

TOLD_APART = {
    "browse": "it is the screen, which the next tests ask",
    "delete": "it has no default a",
    "bench": "it has no catalogue",
}
"""Commands with --a, --p or --status that ask no question of `QUESTIONS`, and why."""


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


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """Use small transfer matrices for `escape`, which are quick."""
    monkeypatch.setattr(rates, "GRIDS", (40, 60))


def answer(question: str, catalogue: Catalogue) -> list[dict[str, Any]] | str | InputError:
    """Return what Python answers to a question, or its error."""
    try:
        return QUESTIONS[question](catalogue)
    except InputError as error:
        return error


def without_times(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if "seconds" not in name} for row in rows]


@pytest.fixture(scope="module")
def command() -> Any:
    return typer.main.get_command(program())


def test_each_command_that_takes_an_a_or_chooses_words_is_asked(command):
    chosen = {
        name
        for name, each in command.commands.items()
        if {"--a", "--p", "--status"} & {option for taken in each.params for option in taken.opts}
    }
    assert chosen == {question.split()[0] for question in QUESTIONS} | TOLD_APART.keys()


LONG = ("births", "escape", "levels --k", "plot", "scars")
"""What takes longest is asked of one kind of catalogue in the default run."""

CASES = [*product(STORED, QUESTIONS)]


@pytest.mark.parametrize(
    ("stored", "question"),
    slow_but([each for each in CASES if each[0] == "one" or not each[1].startswith(LONG)], CASES),
    indirect=["stored"],
)
def test_the_shell_and_python_give_the_same_rows(question, stored, tmp_path, cli, monkeypatch, command):
    kind, path = stored
    monkeypatch.chdir(tmp_path)
    Path("python").mkdir()
    own = Path("python", "orbits.db")
    for copy in (Path("orbits.db"), own):
        copy.write_bytes(path.read_bytes())
    name, *options = question.split()
    takes = [option for taken in command.commands[name].params for option in taken.opts]
    form = ["--json"] if "--json" in takes and "--format" not in options else []
    done = cli(name, *options, *form)
    expected = answer(question, Catalogue(own))
    if isinstance(expected, InputError):
        assert done.err == f"orbitdb: {completed(str(expected))}\n"
        assert done.code == (1 if isinstance(expected, NotStoredError) else 2)
        a = DEFAULT[kind]
        assert f"at a = {'1, 2' if a is None else format_float(a)}" in done.err
        return
    assert done.code in (0, 1), done.err
    assert DEFAULT[kind] is not None or question in WITHOUT_A
    shown = json.loads(done.out or "[]")
    if isinstance(expected, str):
        assert completed(expected) in done.err
    else:
        assert without_times(json.loads(json.dumps(expected))) == without_times(shown)
        assert (done.code == 1) == (not shown) or name == "verify"
    if question not in WITHOUT_A:
        assert {row["a"] for row in shown if "a" in row} <= {DEFAULT[kind]}
        assert (NOTES.get(kind) in done.err.splitlines()) == (kind in NOTES)
    if question == "query --p 4 -c code,a,p,status,length":
        assert cli(*question.split(), *form, "-q").err == (f"{NOTES[kind]}\n" if kind in NOTES else "")


TABLES = [
    question
    for question in QUESTIONS
    if question.split()[0] not in ("births", "fill", "plot", "export") and "-c " not in question
]


@pytest.mark.parametrize(
    "question",
    slow_but(
        [each for each in TABLES if "--a all" not in each and not each.startswith(("escape", "scars"))],
        [each for each in TABLES if "--a all" not in each],
    ),
)
def test_a_table_for_people_names_its_a(question, made_once, tmp_path, cli):
    """The a that was asked for stands in a column or a fact, or on stderr."""
    path = made_once("named", lambda path: [Catalogue.create(path).fill(4, a=a) for a in (0.9, 1.6)])
    (tmp_path / "orbits.db").write_bytes(path.read_bytes())
    done = cli(*question.split(), "--a", "0.9")
    if done.out:
        heading, *rows = [line.split() for line in done.out.splitlines()]
        in_column = "a" in heading and rows[0][heading.index("a")] == "0.9"
        assert in_column or heading == ["a", "0.9"] or "a = 0.9" in done.err, done


TALLIES = ("status", "p", "symmetry", "time_reversal")
AVERAGES = ("entropy", "lyapunov")


def of_shell(cli: Callable[..., Any], options: Sequence[str], file: Path) -> dict[str, Any]:
    """Return what the shell counts, averages and exports of a subset, and would fill up to period 7."""

    def rows(*command: str) -> list[dict[str, Any]]:
        return json.loads(cli(*command, *options, "--json").out or "[]")

    def tally(name: str) -> list[tuple[str, str]]:
        return [(str(row[name] or "without"), f"{row['words']:,}") for row in rows("count", "--by", name)]

    dry = cli("fill", "--p", "7", *options[-2:], "--dry-run").err
    cli("export", str(file), *options)
    return {
        "query": [row["code"] for row in rows("query", "-c", "code")],
        "count": sum(row["words"] for row in rows("count")),
        **{name: tally(name) for name in TALLIES},
        **{name: rows(name) for name in AVERAGES},
        "fill": re.findall(r"at a = (\S+): (\d+) words to solve, (.*?), in", dry.replace(" and", ",")),
        "export": file.read_text() if file.exists() else "",
    }


async def of_screen(app: BrowseApp, pilot: Pilot[Any], file: Path) -> dict[str, Any]:
    """Return the same from the screen, in the same form, but with all columns of the averages."""
    main: Any = app.screen
    source = main.rows.table.source
    found: dict[str, Any] = {"query": [source.row(place)[0] for place in range(len(source))]}
    found["count"] = int(main.rows.report.partition(" ")[0].replace(",", "") or 0)
    await press(pilot, "e")
    if app.screen is not main:
        await write(pilot, str(file), "enter")
    found["export"] = file.read_text() if file.exists() else ""
    await press(pilot, "d")
    if app.screen is not main:
        box = app.screen.query_one("#tallies", CountsList)
        options = [box.get_option_at_index(place) for place in range(box.option_count)]
        for name in TALLIES:
            grids: list[Any] = [each.prompt for each in options if (each.id or "").startswith(name)]
            found[name] = [tuple(next(iter(part.cells)) for part in grid.columns[:2]) for grid in grids]
        await press(pilot, "escape", "S")
        statistics: Any = app.screen
        for name in AVERAGES:
            found[name] = [] if statistics.result is None else of_columns(statistics.result.columns)
        await press(pilot, "escape")
    await press(pilot, "f")
    await write(pilot, "7", field="#periods")
    cost = str(app.screen.query_one("#cost", Label).render())
    words, a, takes = re.findall(r"(\S+) words to fill at a = (\S+): (.*)", cost)[0]
    found["fill"] = [(a, words.replace(",", ""), takes)]
    return found


CHOSEN = [
    {"p": "2-5,12"},
    {"p": "2-5,12", "status": "all"},
    {"where": "status = 'dynamical'"},
    {"p": "3", "where": "rules is null or p = 3"},
    {"time_reversal": "self", "without": ["02"]},
]


async def screen_agrees(path: Path, folder: Path, cli: Callable[..., Any], asked: dict[str, Any]) -> None:
    """Compare what the screen says of a subset with what the shell says."""
    chosen = SelectionOptions(**asked).at(given_a(path, None)[0])
    shell = of_shell(cli, [*as_options(asked), "--db", str(path)], folder / "shell.csv")
    async with browsing(path, selection=chosen) as (app, pilot):
        screen = await of_screen(app, pilot, folder / "screen.csv")
    for name in AVERAGES:
        screen[name] = [{key: row[key] for key in (shell[name] or [{}])[0]} for row in screen.get(name, ())]
    assert screen == shell


async def test_the_screen_counts_averages_fills_and_exports_as_the_shell_does(stored, tmp_path, cli):
    kind, path = stored
    if DEFAULT[kind] is not None:
        await screen_agrees(path, tmp_path, cli, {"p": "2-4"})


@pytest.mark.parametrize("asked", CHOSEN)
async def test_the_screen_agrees_on_every_kind_of_subset(asked, varied, tmp_path, cli):
    await screen_agrees(varied, tmp_path, cli, asked)


async def test_an_export_has_the_rows_and_the_provenance_of_the_shell(varied, tmp_path, cli):
    """Of classes and in the order of the screen."""
    shell, screen = tmp_path / "shell.csv", tmp_path / "screen.csv"
    cli("export", str(shell), "--p", "3", "--classes", "--order", "code", "--db", str(varied))
    chosen = SelectionOptions(p="3").at(1.6)
    async with browsing(varied, selection=chosen) as (_, pilot):
        await press(pilot, "K", "s", "e")
        await write(pilot, str(screen), "enter")
    assert screen.read_text() == shell.read_text()
    beside = [json.loads(metadata_path(file).read_text()) for file in (shell, screen)]
    assert beside[0] | {"date": ""} == beside[1] | {"date": ""}


@pytest.mark.parametrize("status", ["dynamical", "geometric", "orbit"])
def test_a_table_of_a_status_has_the_same_columns_however_it_is_chosen(status, varied, cli):
    """No column is empty: words that are no orbits have a margin, but no length."""
    asked = ("query", "--p", "3,5", "--a", "1.6", "--db", str(varied), "--limit", "9")
    chosen = cli(*asked, "--status", status), cli(*asked, "--where", f"status = '{status}'")
    assert chosen[0].out == chosen[1].out
    assert ("length" in chosen[0].out) == (status == "orbit")


@pytest.mark.slow
def test_a_result_in_python_says_which_a_it_took(stored):
    kind, path = stored
    if DEFAULT[kind] is None:
        return

    def notes_of(catalogue: Catalogue) -> Iterator[Sequence[str]]:
        """Yield the notes of each method whose results have some."""
        for found in (
            catalogue.table(), catalogue.entropy(), catalogue.rows(), catalogue.field(0.1, code="13"),
            catalogue.identify(start=(0, 0.1, 0.5)), catalogue.identify(length=10.4), catalogue.count(by="p"),
            catalogue.fill_levels(1, parity="oo", store=False), catalogue.pruning_front(),
            catalogue.escape("top:-0.3:0.3", trajectories=0, store=False), catalogue.select(p=3),
        ):  # fmt: skip
            yield found.notes
        yield [*catalogue.simulate(2000, store=False).notes()]
        if STORED[kind]:
            yield catalogue.spectrum((3, 20)).notes()
        if kind == "levels":
            yield catalogue.levels(parity="ee").notes

    for notes in notes_of(Catalogue(path)):
        assert (NOTES.get(kind) in notes) == (kind in NOTES)
    assert not any(note.startswith("a = ") for note in Catalogue(path, DEFAULT[kind]).rows().notes)


def test_a_subset_and_a_list_of_one_are_verified_with_the_same_notes(filled):
    from orbitdb import Selection

    catalogue, chosen = Catalogue(filled), Selection(1.6, periods=((8, 9),))
    assert catalogue.verify([chosen]).notes == catalogue.verify(chosen).notes != ()
