"""Whatever is asked of a catalogue, in any order and form: the rows that a list in plain Python gives."""

import contextlib
import csv
import io
import json
import math
from collections import Counter
from itertools import pairwise

import model
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from orbitdb.cli.main import _run
from orbitdb.filling.births import fill_births
from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.store.asking.conditions import COLUMNS
from orbitdb.store.asking.criteria import choose
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.tallies import histogram, marginal, tally

LONG = ("1" * 20 + "3", "31" * 11 + "30", "13" * 11 + "10", "11" + "02" * 11, "0" * 25 + "1")
"""Words that have no key: three of one period in the wrong order, a small class, one that is pruned."""


def both(test, *names):
    """Return a test of some columns that no row without them passes, as in SQL."""
    return lambda row: None not in [row[name] for name in names] and test(row)


WHERE = {
    # of classes
    "lambda_c < 0.5": both(lambda row: row["lambda_c"] < 0.5, "lambda_c"),
    "length is null": lambda row: row["length"] is None,
    "p % 2 and walls < 3": both(lambda row: row["p"] % 2 and row["walls"] < 3, "walls"),
    "symmetry = 'T' or maslov > 12": lambda row: row["symmetry"] == "T" or (row["maslov"] or 0) > 12,
    "born > 0.5": both(lambda row: row["born"] > 0.5, "born"),
    "status = 'geometric' or rules is not null": lambda row: bool(row["rules"]),
    # patterns
    "code like '%31%'": lambda row: "31" in row["code"],
    "word not glob '*31*' AND length > 9": both(
        lambda row: "31" not in row["code"] and row["length"] > 9, "length"
    ),
    "code like '1_3%'": lambda row: row["code"][0] == "1" and row["code"][2:3] == "3",
    # of single words
    "element = 3": lambda row: row["element"] == 3,
    "element & 1 and length > 9": both(lambda row: row["element"] & 1 and row["length"] > 9, "length"),
    "code > '02' and p in (4, 6)": lambda row: row["code"] > "02" and row["p"] in (4, 6),
    "representative = word": lambda row: row["representative"] == row["word"],
    "code('31', '2312') or code like '0%2'": lambda row: (
        row["code"] in ("13", "1223") or (row["code"][0] == "0" and row["code"][-1] == "2")
    ),
}  # fmt: skip
KEYS = st.sampled_from([name for name in COLUMNS if name not in ("a", "cycle", "solver")])
ORDERS = (
    st.just("p")
    | st.lists(
        st.tuples(st.sampled_from(["-", ""]), KEYS).map("".join), min_size=1, max_size=3, unique=True
    ).map(",".join)
    | st.sampled_from(["code", "-code", "element,-length", "status,code desc", "p,-element"])
)
CRITERIA = st.fixed_dictionaries(
    {},
    optional={
        "a": st.sampled_from([1.6, 1.0]),
        "p": st.sampled_from(["2", "3", "3-5", "5,12", "6", "2-30", "22-99"]),
        "status": st.sampled_from(["orbit", "orbit,dynamical", "geometric", "orbit,geometric", "all"]),
        "time_reversal": st.sampled_from(["self", "pair"]),
        "symmetry": st.sampled_from(["1", "T", "x,T,xT"]),
        "contains": st.sampled_from(["13", "44", "131013", "31202131", "3131313131313131"]),
        "exists": st.sampled_from([(0.8,), (0.3, 2.0)]),
        "not_at": st.just((0.2,)),
        "length": st.sampled_from([(11.0, None), (None, 14.0), (11.0, 14.0)]),
        "born": st.just((0.1, 1.0)),
        "where": st.sampled_from(sorted(WHERE)),
    },
)
LISTS = ("rules", "coordinates")
LIMITS = st.none() | st.integers(0, 40)
OFFSETS = st.just(0) | st.integers(0, 60) | st.just(5000)
NAMES = st.lists(st.sampled_from([*COLUMNS, "coordinates"]), min_size=1, max_size=6, unique=True).map(tuple)


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """Two a, births to p = 4, a part of a period, pruned words and long ones; and all of it as a list."""
    path = tmp_path_factory.mktemp("asked") / "orbits.db"
    catalogue = Catalogue.create(path)
    for a, last in ((1.6, 5), (1.0, 3)):
        for _ in fill_periods(path, a, range(2, last + 1)):
            pass
    for _ in fill_births(path, range(2, 5)):
        pass
    for _ in fill_geometric(path, [3, 4]):
        pass
    for word in ("013023", "131013", *LONG):
        fill_word(path, word, 1.6)
    return catalogue, model.rows_of(path)


def expected(rows, criteria, order="p", limit=None, offset=0):
    found = model.in_order(model.chosen(rows, criteria, WHERE), order)
    return model.cut(found, limit, offset)


@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS, offset=OFFSETS, names=NAMES)
@settings(max_examples=80)
@example({"status": "orbit,geometric,dynamical"}, "p", None, 0, ("code", "rules", "coordinates"))
@example({"contains": "13"}, "-lambda_c", 5, 3, COLUMNS)
@example({"p": "2-5", "where": "element = 3"}, "code", 9, 4, COLUMNS)
@example({"p": "22-99", "status": "all"}, "-code", None, 0, ("code", "element"))
@example({"p": "3", "status": "orbit,geometric"}, "element,-length", None, 0, ("code", "element"))
@example({"p": "3", "status": "orbit,geometric"}, "-element,length", None, 0, ("code", "element"))
def test_rows_and_their_number_are_those_of_a_list(asked, criteria, order, limit, offset, names):
    catalogue, rows = asked
    found = list(catalogue.rows(choose(**criteria), names, order, limit, offset))
    assert found == model.columns_of(expected(rows, criteria, order, limit, offset), names)
    assert catalogue.count(choose(**criteria)) == len(expected(rows, criteria))


@given(criteria=CRITERIA, order=ORDERS)
@example({"p": "2-30", "status": "orbit,geometric"}, "code")
def test_arrays_are_those_of_a_list(asked, criteria, order):
    catalogue, rows = asked
    subset, wanted = catalogue.select(choose(**criteria), order=order, coordinates=True), []
    wanted = expected(rows, criteria, order)
    assert subset.words.tolist() == [row["code"] for row in wanted]
    for name in ("length", "margin", "lambda_c", "born"):
        known = [math.nan if row[name] is None else row[name] for row in wanted]
        np.testing.assert_array_equal(getattr(subset, name), known, err_msg=name)
    for name, none in (("p", 0), ("walls", 0), ("class_size", 0), ("status", ""), ("symmetry", "")):
        assert getattr(subset, name).tolist() == [row[name] or none for row in wanted]
    for n, row in enumerate(wanted):
        places = row["coordinates"] or [math.nan] * row["p"]
        np.testing.assert_array_equal(subset.coordinates_of(n), places)


@given(criteria=CRITERIA.filter(lambda each: each.get("status") in (None, "orbit")))
def test_classes_are_those_of_the_words_of_a_list(asked, criteria):
    catalogue, rows = asked
    wanted = expected(rows, criteria | {"status": "orbit"})
    counts = Counter((row["p"], row["representative"], row["length"]) for row in wanted)
    found = catalogue.classes(choose(**criteria))
    assert found.p.tolist() == [p for p, *_ in counts]
    assert found.length.tolist() == [length for *_, length in counts]
    assert found.chosen.tolist() == list(counts.values())
    assert (found.chosen <= found.class_size).all()


@given(criteria=CRITERIA, names=st.sampled_from([("status", "p"), ("symmetry", "walls"), ("p",)]))
def test_tallies_are_those_of_a_list(asked, criteria, names):
    catalogue, rows = asked
    wanted = model.columns_of(expected(rows, criteria), names)
    found = tally(catalogue, choose(**criteria), names)
    assert found == Counter(wanted)
    assert marginal(found, 0) == Counter(first for first, *_ in wanted)


@given(criteria=CRITERIA, column=st.sampled_from(["length", "lambda_c", "born"]), bins=st.integers(1, 40))
def test_bins_hold_the_rows_of_a_list(asked, criteria, column, bins):
    catalogue, rows = asked
    values = [row[column] for row in expected(rows, criteria)]
    known = [value for value in values if value is not None]
    found = histogram(catalogue, choose(**criteria), column, bins)
    if found is None:
        assert not known
        return
    assert found.counts.tolist() == np.histogram(known, found.edges)[0].tolist()
    assert (found.counts.sum(), found.without) == (len(known), len(values) - len(known))


def options(criteria):
    """Return criteria as a command takes them."""
    spans = {name: criteria[name] for name in model.RANGES if name in criteria}
    texts = {name: ":".join("" if end is None else repr(end) for end in span) for name, span in spans.items()}
    listed = [("--range", f"{name}={text}") for name, text in texts.items()]
    for name, option in (("exists", "--exists"), ("not_at", "--not-at")):
        listed += [(option, str(a)) for a in criteria.get(name, ())]
    named = {"time_reversal": "--reversal"}
    plain = set(criteria) - {*spans, "exists", "not_at"}
    listed += [(named.get(name, f"--{name}"), str(criteria[name])) for name in sorted(plain)]
    return [text for pair in listed for text in pair]


def read_back(path, form, names):
    """Return the rows of a file, as the formats have them."""
    if form == "jsonl":
        return [tuple(json.loads(line).values()) for line in path.read_text().splitlines()]
    if form == "csv":
        return [tuple(row) for row in list(csv.reader(io.StringIO(path.read_text())))[1:]]
    if form == "parquet":
        from pyarrow import parquet

        table = parquet.read_table(path)
        return list(zip(*(table[name].to_pylist() for name in names), strict=True))
    with np.load(path) as archive:
        columns = {name: archive[name].tolist() for name in archive.files}
    for name in {"rules", "coordinates"} & set(names):
        ends = columns[f"{name}_start"]
        columns[name] = [columns[name][low:high] for low, high in pairwise(ends)]
    return list(zip(*(columns[name] for name in names), strict=True))


def as_written(value, name, form):
    """Return a value as a format has it: none, and what stands in a cell."""
    if form == "csv":
        cell = " ".join(map(str, value)) if isinstance(value, list) else value
        return "" if value is None else str(cell)
    if form == "npz" and value is None:
        return (
            "" if name in model.TEXTS else -1 if name in model.INTEGERS else [] if name in LISTS else math.nan
        )
    return value


@pytest.mark.parametrize("form", ["csv", "jsonl", "parquet", "npz"])
@given(criteria=CRITERIA, order=ORDERS, limit=LIMITS, names=NAMES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@example({"p": "2-5", "status": "orbit,geometric"}, "p", None, ("rules", "code", "element", "coordinates"))
def test_files_hold_the_rows_of_a_list(asked, tmp_path, form, criteria, order, limit, names):
    catalogue, rows = asked
    wanted = expected(rows, criteria, order, limit)
    plain = tuple(name for name in names if name != "coordinates") or ("code",)
    names = (*plain, "coordinates") if "coordinates" in names else plain
    target = tmp_path / f"orbits.{form}"
    arguments = ["export", str(target), "--db", str(catalogue.path), "--force", *options(criteria)]
    arguments += ["--order", order, "-c", ",".join(plain), *["--coordinates"] * ("coordinates" in names)]
    arguments += [] if limit is None else ["--limit", str(limit)]
    with contextlib.redirect_stderr(io.StringIO()):
        assert _run(arguments) == (0 if wanted else 1)
    if wanted:
        told = [tuple(as_written(row[name], name, form) for name in names) for row in wanted]
        assert repr(read_back(target, form, names)) == repr(told)
