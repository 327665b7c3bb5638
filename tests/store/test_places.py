"""Where rows are: the words that are looked up are few, and among them are those that a pass would give."""

import contextlib
import sqlite3

import pytest
from quick import slow_but

from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.criteria import choose
from orbitdb.store.reading import class_first, counted_words, first_rows, fitting_words, places
from orbitdb.store.reading.catalogue import Catalogue

FEW, MOST = 3, 6
SHARED = {"p", "status", "class_size", "walls", "symmetry", "time_reversal", "element"}
"""Columns in which many rows have the same value."""

ORDERS = ("p,code", "-p,length", "-lambda_c", "status,margin desc", "class_size,status,p,word",
          "element,word", "-code", "rules")  # fmt: skip
MORE_ORDERS = ("length,code", "margin,length", "time_reversal desc,length", "status,-p,code", "code",
               "walls desc,p", "-element,margin", "symmetry,class_size,-code")  # fmt: skip
SUBSETS = {
    "p >= 4 AND p <= 6": {"p": "4-6"},
    "p IN (3, 5) AND status IN ('orbit', 'geometric')": {"p": "3,5", "status": "orbit,geometric"},
    "p < 6 AND code LIKE '%31%' AND length > 9": {"p": "2-5", "where": "code like '%31%' and length > 9"},
    "p < 6 AND element = 3 AND length > 9": {"p": "2-5", "where": "element = 3 and length > 9"},
    "p > 3 AND p < 7 AND word || word LIKE '%31%'": {"p": "4-6", "contains": "31"},
    "p > 3 AND p < 7 AND (length IS NULL OR length < 11.2)": {
        "p": "4-6", "where": "length is null or length < 11.2"},
}  # fmt: skip


def in_a_pass(path, condition, order):
    """Return all rows in an order, empty values last, as SQLite alone gives them."""
    keys = [(name.lstrip("-").split()[0], "-" in name or "desc" in name) for name in order.split(",")]
    by = ", ".join(f"{name} IS NULL, {name} {'DESC' if falls else ''}" for name, falls in keys)
    with contextlib.closing(sqlite3.connect(path)) as plain:
        plain.row_factory = sqlite3.Row
        asked = f"SELECT * FROM catalogue WHERE a = 1.6 AND {condition} ORDER BY {by}, p, word"
        return [name for name, _ in keys], plain.execute(asked).fetchall()


def slices(rows, names):
    """Give the first rows, those beside borders between groups and around the end, and none."""
    groups = [tuple(row[name] if name in SHARED else row[name] is None for name in names) for row in rows]
    borders = [k for k in range(1, len(rows)) if groups[k] != groups[k - 1]]
    near = {border - back for border in borders[:1] for back in (0, 1, 2)}
    starts = {1, *near, len(rows) // 2, len(rows) - 2, len(rows)}
    return [(2, start) for start in sorted(starts) if start >= 0] + [(MOST, 1), (0, MOST + 1)]


def told(rows, names, first, last):
    """Tell whether classes say which words rows are: those of one group, or of few numbers in one."""
    for name in names:
        values = [row[name] for row in rows[first:last]]
        if name in SHARED or None in values:
            if len(set(values)) > 1:
                return False
            rows = [row if row[name] == values[0] else dict.fromkeys(names) for row in rows]
        else:
            low, high = min(values), max(values)
            same = [row for row in rows if row[name] is not None and low <= row[name] <= high]
            return len({row["representative"] for row in same}) <= FEW
    return True


def check(path, connection, condition, chosen, orders):
    """Compare where rows are, at every border, with where a pass finds them; tell what was found so."""
    found = set()
    for order in orders:
        names, rows = in_a_pass(path, condition, order)
        for limit, offset in slices(rows, names):
            place = places.place_of(connection, choose(**chosen), order, limit, offset, Patience())
            if place is not None:
                here = [row["word"] for row in rows if row["word"] in set(place.words)]
                start, wanted = offset - place.before, rows[offset : offset + limit]
                assert start >= 0
                assert here[start : start + limit] == [row["word"] for row in wanted], (order, limit, offset)
                assert len(place.words) <= MOST + 8 * FEW, (order, limit, offset)
                assert order != "p,code" or len(place.words) == len(wanted)
                found.add((order, limit, offset))
    return found


@pytest.fixture
def tiny(monkeypatch):
    """Let a small catalogue go the ways of a large one."""
    for module, sizes in (
        (class_first, {"_MANY": 0, "_FEW": FEW}),
        (first_rows, {"_STEPS": (4, 12, 40), "_LOOKUPS": 9, "MOST": MOST}),
        (places, {"MOST": MOST}),
        (counted_words, {"_PIECE": 5}),
        (fitting_words, {"_BATCH": 7}),
    ):
        for name, size in sizes.items():
            monkeypatch.setattr(module, name, size)


@pytest.mark.usefixtures("tiny")
@pytest.mark.parametrize("orders", slow_but([ORDERS], [ORDERS, MORE_ORDERS]), ids=["usual", "more"])
def test_rows_of_whole_classes_need_no_pass(filled_once, orders):
    """But for those across a border between groups; far behind, and first ones, at every border."""
    condition, chosen = next(iter(SUBSETS.items()))
    with Catalogue(filled_once).reading() as connection:
        found = check(filled_once, connection, condition, chosen, orders)
    for order in orders:
        names, rows = in_a_pass(filled_once, condition, order)
        keys = [name for name, _ in first_rows.keys_before_words(order)]
        for limit, offset in slices(rows, names):
            last = offset + limit
            if limit and MOST < last <= len(rows) and not {"code", "rules", "element"} & {*keys}:
                expected = told(rows, keys, offset, last)
                assert ((order, limit, offset) in found) == expected, (order, limit, offset)
    assert {order for order, *which in found if which == [2, 1]} == {*orders} - {"p,code", "rules"}


@pytest.mark.usefixtures("tiny")
@pytest.mark.parametrize(
    ("subset", "orders", "placed"),
    [
        (1, ("status desc,length",), 1),
        (2, ("p,code",), 6),
        (3, ("length",), 1),
        (4, ("-lambda_c",), 1),
        (5, ("-length",), 6),
        pytest.param(1, ORDERS + MORE_ORDERS, 15, marks=pytest.mark.slow),
        pytest.param(2, ORDERS + MORE_ORDERS, 11, marks=pytest.mark.slow),
        pytest.param(3, ORDERS + MORE_ORDERS, 5, marks=pytest.mark.slow),
    ],
)
def test_rows_of_single_words_are_where_a_pass_would_find_them(varied, subset, orders, placed):
    condition, chosen = list(SUBSETS.items())[subset]
    with Catalogue(varied).reading() as connection:
        found = check(varied, connection, condition, chosen, orders)
    assert len(found) == placed


@pytest.mark.usefixtures("tiny")
@pytest.mark.parametrize(("pattern", "count"), [("%04%", MOST), ("%10%", MOST + 1), ("%0101%", 0)])
def test_rows_of_few_words_are_looked_up_in_any_order(varied, pattern, count):
    where = f"code like '{pattern}' and length > 9"
    _, rows = in_a_pass(varied, f"p < 6 AND {where}", "word")
    with Catalogue(varied).reading() as connection:
        for limit, offset in ((None, 0), (2, MOST - 1)):
            asked = choose(p="2-5", where=where)
            place = places.place_of(connection, asked, "length desc,code", limit, offset, Patience())
            assert (place is None) == (count > MOST)
            assert place is None or (sorted(place.words), place.before) == ([row["word"] for row in rows], 0)
    assert len(rows) == count
