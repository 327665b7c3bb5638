"""Every command writes what the library says, column by column, in each format.

One table pairs a command line with a library call that gives the same columns. Each pair runs as JSON and in
one of the other formats in turn; numbers are equal to the last bit. `test_sessions` covers tables, and
`tests/store/test_questions.py` the rows of `query` and `export`.
"""

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import made

from orbitdb import Catalogue, Stadium, existence, simulate, solve, solve_word
from orbitdb.answers.field import FIELD_COLUMNS as COLUMNS_IN_FIELD
from orbitdb.averages.exact_means import exact_means
from orbitdb.benchmarks import stress
from orbitdb.benchmarks import work_precision as methods
from orbitdb.entropy_bounds.bounds import search
from orbitdb.filling.fill import fill_births
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.storing import keep_reference
from orbitdb.store.writer import Writer
from orbitdb.trajectories.ensemble import Reference
from orbitdb.trajectories.legwise import simulate_legs
from orbitdb.verification.verify import report, verify

Columns = dict[str, list[Any]]
OTHERS = ("csv", "tsv", "jsonl")
"""Besides JSON, each command writes only one of these formats, because all come from the same rows."""
TRAJECTORY = simulate(Stadium(1.6), 20_000, seed=89)


@pytest.fixture(scope="module")
def stored(varied, tmp_path_factory) -> Path:
    """The varied catalogue with births up to p = 5 and a trajectory at a = 1.6."""
    path = tmp_path_factory.mktemp("outputs") / "orbits.db"
    path.write_bytes(varied.read_bytes())
    made(path, fill_births(path, range(2, 6)))
    parameters = {"command": "simulate", "a": 1.6, "bounces": TRAJECTORY.bounces, "seed": TRAJECTORY.seed}
    writer = Writer(path, parameters)
    keep_reference(writer, TRAJECTORY)
    writer.close()
    return path


def plain(values: Any) -> list[Any]:
    """Values as plain Python, None for NaN and empty texts."""
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    return [None if value != value or value == "" else value for value in listed]


KEYS = ("code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
        "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
        "length_error", "lyapunov_error", "symmetry", "solver", "half", "quarter_maslov",
        "quarter_length", "quarter_lyapunov",
        "lambda_c_error", "area", "area_error", "area_slope")  # fmt: skip


def words_of(*words: str) -> Callable[[Catalogue], Columns]:
    """Return a call that computes the columns of ``query --code``."""

    def call(catalogue: Catalogue) -> Columns:
        orbits = [solve_word(word, 1.6) for word in words]
        columns: Columns = {name: [getattr(orbit, name) for orbit in orbits] for name in KEYS}
        columns["rules"] = [list(o.rules) for o in orbits]
        columns["walls"] = [sum(map(o.code.count, "02")) for o in orbits]
        columns["maslov"] = [3 * o.p - walls for o, walls in zip(orbits, columns["walls"], strict=True)]
        columns["coordinates"] = [None if o.coordinates is None else o.coordinates.tolist() for o in orbits]
        columns["stored"] = [word in catalogue for word in words]
        columns["exists"] = [[list(life) for life in existence(word)] for word in words]
        return columns

    return call


def in_field(found: Any) -> Columns:
    return {name: plain(getattr(found, name)) for name in COLUMNS_IN_FIELD}


EXPONENTS = ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error")


def born(catalogue: Catalogue) -> Columns:
    names = ("p", "classes", "births", "deaths", "always", "least", "largest")
    return records(catalogue.birth_fills(), {name: name for name in names})


def filled(catalogue: Catalogue) -> Columns:
    fills = [(a, fill) for a in (1.0, 1.6) for fill in catalogue.fills(a=a)]
    names = ("state", "stored", "N_t", "N_c", "boundary", "unresolved",
             "seconds", "enumerating", "solving", "storing")  # fmt: skip
    values = {
        name: [getattr(fill, "words" if name == "stored" else name.lower()) for _, fill in fills]
        for name in ("p", *names)
    }
    return {"a": [a for a, _ in fills], **values}


def records(found: Any, names: dict[str, str] | None = None) -> Columns:
    """Return columns from dataclasses, renamed if names are given."""
    listed = list(found)
    shown = names or {field.name: field.name for field in fields(listed[0]) if field.name != "on_a"}
    return {name: plain([getattr(each, field) for each in listed]) for name, field in shown.items()}


def bounds(_: Catalogue) -> Columns:
    """The bounds, and their middle."""
    rows = [each.row() for each in search(Stadium(3), 6)]
    return {name: plain([row[name] for row in rows]) for name in rows[0]}


def legwise() -> list[Reference]:
    return [simulate_legs(Stadium(0.7), 20_000, exact_means(0.7).growth, 3)]


def checked(catalogue: Catalogue) -> Columns:
    with reading(catalogue.path) as connection:
        found = report(verify(connection, [Selection.from_criteria(a=1.6, p="2-4")], None, 2, 7))
    names = ("rows", "failures", "worst", "share", "first")
    return records(found, {"check": "name"} | {name: name for name in names})


def measured(found: Callable[[], Any]) -> Callable[[Catalogue], Columns]:
    return lambda _: records(found())


def shadowed(catalogue: Catalogue) -> Columns:
    """The columns of ``identify`` for a trajectory, in the order of its keys."""
    found = catalogue.identify(start=(0.0, 0.001, 0.0), bounces=9, limit=4)
    names = ("code", "p", "status", "first", "last", "bounces", "turns", "distance", "length", "lambda_d",
             "lyapunov", "representative", "class_size", "a", "stored")  # fmt: skip
    count, own = len(found.shadowed), ("first", "last", "bounces", "turns", "distance")
    columns = {
        name: [getattr(each if name in own else each.orbit, name) for each in found.shadowed]
        for name in names
    }
    return columns | {"sequence": [found.sequence] * count, "sequence_first": [found.first] * count}


def with_length(catalogue: Catalogue) -> Columns:
    found = catalogue.identify(length=22.0, tolerance=0.4)
    names = ("code", "p", "class_size", "repetitions", "length", "total", "difference", "lyapunov",
             "length_error")  # fmt: skip
    return records(found, {name: name for name in names}) | {"a": [1.6] * len(found)}


@dataclass(frozen=True)
class Case:
    """A command line and the library call that gives the same."""

    line: str
    call: Callable[[Catalogue], Mapping[str, Sequence[Any]]]
    reads: bool = True
    slow: bool = False


CASES = [
    Case("query --code 1232131 --code 01132", words_of("1232131", "01132")),
    Case("identify --start 0,0.001,0 --bounces 9 --limit 4", shadowed, slow=True),
    Case("identify --length 22 --tolerance 0.4", with_length),
    Case("table", lambda c: c.table().columns),
    Case("entropy", lambda c: c.entropy().columns, slow=True),
    Case("entropy --p 3,5-6", lambda c: c.entropy(p="3,5-6").columns),
    Case("lyapunov --p 2-6", lambda c: c.lyapunov(p="2-6").columns),
    Case("lyapunov --p 3,5-6", lambda c: c.lyapunov(p="3,5-6").columns),
    Case("lyapunov --weight det --p 2-6", lambda c: c.lyapunov(p="2-6", weight="det").columns, slow=True),
    Case("lyapunov --cut 7 --p 2-6", lambda c: c.lyapunov(p="2-6", cut=7.0).columns),
    Case("lyapunov --cut 6.5 --weight det --p 2-6",
         lambda c: c.lyapunov(p="2-6", cut=6.5, weight="det").columns, slow=True),
    Case("simulate --a 0.7 --bounces 20000 --seed 3 --no-store",
         measured(lambda: [simulate(Stadium(0.7), 20_000, 3)]), reads=False),
    Case("simulate --a 0.7 --bounces 20000 --seed 3 --legwise --no-store", measured(legwise),
         reads=False, slow=True),
    Case("field --kappa 0.1 --p 2-5", lambda c: in_field(c.field(0.1, p="2-5"))),
    Case("field --kappa 0.1 --kappa 0.2 --p 4,6 --counts",
         lambda c: c.field([0.1, 0.2], p="4,6").counts().columns),
    Case("births", born),
    Case("bounds --a 3 --edges 6", bounds, reads=False),
    Case("info", filled),
    Case("verify --a 1.6 --p 2-4 --restarts 2 --seed 7", checked, slow=True),
    Case("bench --p 3", measured(lambda: methods.work_precision(methods.sample(3, Stadium(1.6)))),
         reads=False, slow=True),
    Case("bench --kind stress", measured(stress.stress), reads=False),
]  # fmt: skip


def of_csv(text: str, delimiter: str = ",") -> list[dict[str, Any]]:
    return list(csv.DictReader(io.StringIO(text), delimiter=delimiter))


READERS: dict[str, Callable[[str], list[dict[str, Any]]]] = {
    "csv": of_csv,
    "tsv": lambda text: of_csv(text, "\t"),
    "json": json.loads,
    "jsonl": lambda text: [json.loads(line) for line in text.splitlines()],
}


def same(shown: Any, value: Any, form: str, name: str) -> bool:
    """Tell whether the output shows the value in full."""
    if form in ("json", "jsonl"):
        return shown == value and isinstance(shown, bool) == isinstance(value, bool)
    if value is None:
        return shown == ""
    if isinstance(value, list):
        parts = [part for part in shown.split(" ") if part] if not any(map(nested, value)) else [shown]
        return nested(value[:1]) or all(same(*each, form, name) for each in zip(parts, value, strict=True))
    if isinstance(value, float):
        return float(shown) == value
    return shown == str(value)


def nested(value: Any) -> bool:
    return isinstance(value, list) and bool(value)


@pytest.fixture
def same_clock(monkeypatch) -> Callable[[], None]:
    """Give benchmarks a clock whose steps grow; calling the fixture restarts it."""
    ticks = [0]

    def tick() -> float:
        ticks[0] += 1
        return ticks[0] ** 2 / 64

    for module in (stress, methods):
        monkeypatch.setattr(module, "perf_counter", tick)
    monkeypatch.setattr(stress, "CASES", {"long runs": lambda: stress.long_runs(1)})
    return lambda: ticks.__setitem__(0, 0)


def pairs() -> list[Any]:
    """Pair every case with the formats it is written in."""
    return [
        pytest.param(case, ("json", other), id=f"{case.line} ({other})",
                     marks=[pytest.mark.slow] if case.slow else [])
        for case, other in zip(CASES, cycle(OTHERS))
    ]  # fmt: skip


@pytest.mark.parametrize(("case", "forms"), pairs())
def test_a_command_writes_what_the_library_says(case, forms, stored, cli, same_clock):
    same_clock()
    expected = case.call(Catalogue(stored, 1.6))
    count = len(next(iter(expected.values())))
    assert count
    place = ("--db", str(stored)) if case.reads else ()
    for form in forms:
        same_clock()
        done = cli(*case.line.split(), "--format", form, *place)
        assert done.code == 0, done.err
        rows = READERS[form](done.out)
        assert [list(row) for row in rows] == [list(expected)] * count, form
        for i, row in enumerate(rows):
            for name, shown in row.items():
                assert same(shown, expected[name][i], form, name), (form, name, i, shown, expected[name][i])


def test_a_hard_case_beyond_its_bound_exits_with_1(cli, monkeypatch):
    """Here every length is altered by a millionth after solving."""

    def altered(words, stadium):
        found = solve(words, stadium)
        return replace(found, length=found.length * (1 + 1e-6))

    monkeypatch.setattr(stress, "CASES", {"joint": lambda: stress.joint_words((4,))})
    assert cli("bench", "--kind", "stress", "--json").code == 0
    monkeypatch.setattr(stress, "solve", altered)
    done = cli("bench", "--kind", "stress", "--json")
    assert done.code == 1
    assert all(row["share"] > 1 for row in json.loads(done.out))


@pytest.mark.slow
def test_the_figure_of_methods_is_written(cli, tmp_path, monkeypatch):
    monkeypatch.setattr(methods, "REPEATS", 1)
    figure = tmp_path / "methods.svg"
    drawn = cli("bench", "--p", "3", "-o", str(figure))
    assert "Run time against error, $p = 3$ at $a = 1.6$" in figure.read_text()
    assert f"p = 3 at a = 1.6, in {figure}" in drawn.err
