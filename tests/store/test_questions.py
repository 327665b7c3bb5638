"""Any query of a catalogue, in any order and format, gives the same rows as a plain Python list."""

import contextlib
import csv
import io
import itertools
import json
import math
from collections import Counter, defaultdict
from functools import partial

import model
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from questions import CRITERIA, EDGES, LIMITS, NAMES, OFFSETS, ORDERS, expected, make_catalogue_to_ask
from quick import slow_but

from orbitdb.catalogue import Catalogue
from orbitdb.cli.main import execute
from orbitdb.selection import Selection
from orbitdb.store import where as limits
from orbitdb.store.file import reading
from orbitdb.store.select import Words, count, rows_of
from orbitdb.store.sqlite import driver_of
from orbitdb.store.views import VIEWED as COLUMNS
from orbitdb.store.where import CancelledError

LISTS = ("rules", "coordinates")


AT_A_TIME = 50
"""A small number of rows, so that everything is read in several parts."""


@pytest.fixture(scope="module")
def asked(made_once):
    """Return a catalogue, and all its rows as a list."""
    path = made_once("asked", make_catalogue_to_ask)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("orbitdb.store.select.ROWS", AT_A_TIME)
        yield Catalogue(path), model.rows_of(path)


@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS, offset=OFFSETS, names=NAMES)
@example({"status": "orbit,geometric,dynamical"}, "p", None, 0, ("code", "rules", "coordinates"))
@example({"length": (10.4, 10.4)}, "p", None, 0, ("code",))  # exactly the length of 13
@example({"contains": "13"}, "-lambda_c", 5, 3, COLUMNS)
@example({"p": "2-5", "where": "element = 3"}, "code", 9, 4, COLUMNS)
@example({"p": "22-99", "status": "all"}, "-code", None, 0, ("code", "element"))
@example({"status": "all"}, "length", 10**30, 1, ("code",))
@example({"status": "orbit,geometric"}, "rules", None, 0, ("code",))  # orbits have none
@example({"p": "3-5", "status": "orbit,geometric"}, "element,-length", None, 0, ("code", "element"))
@example({"p": "3-5", "status": "orbit,geometric"}, "-element,length", None, 0, ("code", "element"))
def test_rows_and_counts_agree_with_a_list(asked, criteria, order, limit, offset, names):
    catalogue, rows = asked
    found = list(
        catalogue.rows(
            Selection.from_criteria(**criteria), columns=names, order=order, limit=limit, offset=offset
        )
    )
    assert found == model.columns_of(expected(rows, criteria, order, limit, offset), names)
    assert catalogue.count(Selection.from_criteria(**criteria)) == len(expected(rows, criteria))


@pytest.mark.parametrize("kind", ["exists", "not_at"])
def test_counts_around_births_and_deaths_agree_with_a_list(asked, kind):
    catalogue, rows = asked
    asks = [
        Selection.from_criteria(exists=at) if kind == "exists" else Selection.from_criteria(not_at=at)
        for at in EDGES
    ]
    found = [catalogue.count(each) for each in asks]
    assert found == [len(expected(rows, {kind: (at,)})) for at in EDGES]
    assert len(set(found)) > 2


@pytest.mark.slow
@given(criteria=CRITERIA, order=ORDERS)
@example({"p": "2-30", "status": "orbit,geometric"}, "code")
def test_arrays_agree_with_a_list(asked, criteria, order):
    catalogue, rows = asked
    subset = catalogue.select(Selection.from_criteria(**criteria), order=order, coordinates=True)
    wanted = expected(rows, criteria, order)
    assert subset.code.tolist() == [row["code"] for row in wanted]
    for name in ("length", "margin", "lambda_c", "born", "area", "area_error"):
        known = [math.nan if row[name] is None else row[name] for row in wanted]
        np.testing.assert_array_equal(getattr(subset, name), known, err_msg=name)
    for name, none in (("p", 0), ("walls", 0), ("class_size", 0), ("status", ""), ("symmetry", "")):
        assert getattr(subset, name).tolist() == [row[name] or none for row in wanted]
    for n, row in enumerate(wanted):
        places = row["coordinates"] or [math.nan] * row["p"]
        np.testing.assert_array_equal(subset.coordinates_of(n), places)


OF_CLASSES = ("p", "class_size", "walls", "length", "lyapunov")


@given(criteria=CRITERIA.filter(lambda each: each.get("status") in (None, "orbit")))
def test_classes_agree_with_a_list(asked, criteria):
    catalogue, rows = asked
    wanted = expected(rows, criteria | {"status": "orbit"})
    counts = Counter((row["representative"], *(row[name] for name in OF_CLASSES)) for row in wanted)
    found = catalogue.classes(**criteria)
    for place, name in enumerate(OF_CLASSES, 1):
        assert getattr(found, name).tolist() == [known[place] for known in counts], name
    assert found.words.tolist() == list(counts.values())
    assert (found.negative == found.walls % 2).all()


@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS, offset=OFFSETS)
@example({"where": "area > 0 and p > 3"}, "area", None, 0)
@example({"p": "3-5", "without": ["13"]}, "element,code", 9, 2)
@example({"p": "3-4", "status": "all"}, "-code", None, 0)
def test_classes_are_shown_by_the_least_of_their_chosen_words(asked, criteria, order, limit, offset):
    catalogue, rows = asked
    classes = model.in_order(model.by_class(expected(rows, criteria)), order)
    names = ("code", "element", "area", "representative", "length", "words", "coordinates")
    question = partial(catalogue.rows, Selection.from_criteria(**criteria), order=order, classes=True)
    found = list(question(columns=names, limit=limit, offset=offset))
    assert found == model.columns_of(model.cut(classes, limit, offset), names)
    assert question().total == len(classes)


@given(criteria=CRITERIA, names=st.sampled_from([("status", "p"), ("symmetry", "walls"), ("p",)]))
def test_counts_agree_with_a_list(asked, criteria, names):
    catalogue, rows = asked
    wanted = expected(rows, ({"status": "all"} if "status" in names else {}) | criteria)
    values = model.columns_of(wanted, names)
    words, classes = Counter(values), defaultdict(set)
    for row, of_row in zip(wanted, values, strict=True):
        classes[of_row].add(row["representative"] or row["code"])
    found = list(catalogue.count(by=names, **criteria).rows())
    assert found == sorted(
        ((*value, words[value], len(classes[value])) for value in words),
        key=lambda row: [(value is None, value) for value in row],
    )
    wanted = expected(rows, criteria)
    every = {row["representative"] or row["code"] for row in wanted}
    assert [*catalogue.count(by=[], **criteria).rows()] == [(len(wanted), len(every))] * bool(wanted)


@given(criteria=CRITERIA, column=st.sampled_from(["length", "lambda_c", "born"]), bins=st.integers(1, 40))
@example({"a": 1.6, "margin": (None, 0.0)}, "born", 2)
def test_histograms_agree_with_a_list(asked, criteria, column, bins):
    catalogue, rows = asked
    values = [row[column] for row in expected(rows, criteria)]
    known = [value for value in values if value is not None]
    found = catalogue.histogram(column, bins=bins, **criteria)
    if not known:
        assert (found.edges.size, found.counts.size, found.without) == (0, 0, len(values))
        return
    assert found.counts.tolist() == np.histogram(known, found.edges)[0].tolist()
    assert (found.counts.sum(), found.without) == (len(known), len(values) - len(known))
    widths = [factor * 10.0**power for power in range(-9, 6) for factor in (1.0, 2.0, 2.5, 5.0)]
    spans = [(math.floor(min(known) / width), math.floor(max(known) / width) + 1) for width in widths]
    finest = next(n for n, (low, high) in enumerate(spans) if high - low <= bins)
    low, high = spans[finest]
    if min(known) < max(known) and bins > 1:
        assert found.edges == pytest.approx(widths[finest] * np.arange(low, high + 1))


def options(criteria):
    """Return criteria as options of a command."""
    spans = {name: criteria[name] for name in model.RANGES if name in criteria}
    texts = {
        name: str(span)
        if isinstance(span, int)
        else ":".join("" if end is None else repr(end) for end in span)
        for name, span in spans.items()
    }
    listed = [("--range", f"{name}={text}") for name, text in texts.items()]
    for name, option in (("exists", "--exists"), ("not_at", "--not-at")):
        listed += [(option, str(a)) for a in criteria.get(name, ())]
    listed += [(f"--{name}", text) for name in ("without", "opening") for text in criteria.get(name, ())]
    named = {"time_reversal": "--time-reversal"}
    plain = set(criteria) - {*spans, "exists", "not_at", "without", "opening"}
    listed += [(named.get(name, f"--{name}"), str(criteria[name])) for name in sorted(plain)]
    return [text for pair in listed for text in pair]


def read_back(path, form, names):
    """Return the rows of a file, read according to its format."""
    if form == "jsonl":
        return [tuple(json.loads(line).values()) for line in path.read_text().splitlines()]
    if form == "csv":
        return [tuple(row) for row in list(csv.reader(io.StringIO(path.read_text())))[1:]]
    from pyarrow import parquet

    table = parquet.read_table(path)
    return list(zip(*(table[name].to_pylist() for name in names), strict=True))


def as_written(value, name, form):
    """Return a value as it is read back from a file in a format, including missing values."""
    if form == "csv":
        if isinstance(value, list):
            return " ".join(as_written(item, name, form) for item in value)
        return "" if value is None else str(value + 0.0 if isinstance(value, float) else value)  # no -0.0
    return value


@pytest.mark.parametrize("form", slow_but(["csv"], ["csv", "jsonl", "parquet"]))
@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS.filter(lambda limit: limit != 0), names=NAMES)
@settings(
    max_examples=settings().max_examples // 2, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@example({"p": "2-5", "status": "orbit,geometric"}, "p", None, ("rules", "code", "element", "coordinates"))
def test_exported_files_agree_with_a_list(asked, tmp_path, form, criteria, order, limit, names):
    catalogue, rows = asked
    wanted = expected(rows, criteria, order, limit)
    target = tmp_path / f"orbits.{form}"
    arguments = ["export", str(target), "--db", str(catalogue.path), "--force", *options(criteria)]
    arguments += ["--order", order, "-c", ",".join(names)]
    arguments += [] if limit is None else ["--limit", str(limit)]
    with contextlib.redirect_stderr(io.StringIO()):
        assert execute(arguments) == (0 if wanted else 1)
    if wanted:
        told = [tuple(as_written(row[name], name, form) for name in names) for row in wanted]
        assert repr(read_back(target, form, names)) == repr(told)


FORMS = st.sampled_from(["json", "jsonl", "csv", "tsv"])


@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS, offset=OFFSETS, names=NAMES, form=FORMS)
@example({"status": "all", "p": "2-30"}, "p", None, 0, COLUMNS, "tsv")
def test_queries_agree_with_a_list(asked, criteria, order, limit, offset, names, form):
    catalogue, rows = asked
    wanted = expected(rows, criteria, order, limit, offset)
    names = tuple(name for name in names if name != "coordinates") or ("code",)
    arguments = ["query", "--db", str(catalogue.path), *options(criteria), "--order", order]
    arguments += ["-c", ",".join(names), "--offset", str(offset), "--format", form]
    arguments += [] if limit is None else ["--limit", str(limit)]
    cells = [[str(as_written(row[name], name, "csv")) for name in names] for row in wanted]
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()) as out:
        assert execute(arguments) == (0 if wanted or (limit == 0 and expected(rows, criteria)) else 1)
    lines = out.getvalue().splitlines()
    if form in ("csv", "tsv"):
        assert list(csv.reader(lines, delimiter="\t" if form == "tsv" else ",")) == [list(names), *cells]
    else:
        found = [json.loads(line) for line in lines] if form == "jsonl" else json.loads(out.getvalue())
        assert found == [{name: row[name] for name in names} for row in wanted]


CANCELLED = [
    ({"where": "length > 9"}, "p"),
    ({"where": "code like '%13%'"}, "p"),
    ({"contains": "13"}, "code"),
    ({"where": "code like '%13%' or p = 4"}, "p"),
    ({"where": "element = 3"}, "-element,length"),
]


@pytest.mark.parametrize(("criteria", "order"), slow_but(CANCELLED[3:], CANCELLED))
def test_a_question_can_be_cancelled_at_any_point(filled_once, criteria, order, monkeypatch):
    monkeypatch.setattr(limits, "STEPS_BETWEEN_LOOKS", 5_000)
    with reading(filled_once) as connection:
        selection, looks = Selection.from_criteria(**criteria), itertools.count()
        size = count(connection, selection)  # makes SQLite read the schema
        driver_of(connection).cancelled = lambda: next(looks) < 0
        words = Words(selection, order)
        whole = list(rows_of(connection, words, ("code",)))
        asked = next(looks)
        assert asked > 0
        assert len(whole) == size
        ended = 0
        for n in range(asked):
            looks_until = itertools.chain(itertools.repeat(False, n), itertools.repeat(True))
            try:
                driver_of(connection).cancelled = looks_until.__next__
                found = list(rows_of(connection, words, ("code",)))
            except CancelledError:
                ended += 1
            else:
                assert found == whole  # nothing was left to do
        assert ended >= max(1, asked - 2)
