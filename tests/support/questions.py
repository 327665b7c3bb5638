"""Questions to a catalogue, drawn by Hypothesis; `model` gives the answers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import model
from contents import alter, made
from hypothesis import strategies as st

from orbitdb.filling.fill import fill_births, fill_geometric, fill_periods, fill_words
from orbitdb.store.views import VIEWED as COLUMNS

DIED, REBORN, ERROR = 0.75, 1.25, 2.0**-30
"""The a at which every third class with stored births dies, the a at which it is reborn, and their error."""

EDGES = [at + times * ERROR for at in (DIED, REBORN) for times in (-3, -2, -1, 0, 1, 2, 3)]
"""Values of a at and near the death and the rebirth; questions can tell them apart from two errors on."""
LONG = ("1" * 20 + "3", "31" * 11 + "30", "13" * 11 + "10", "11" + "02" * 11, "0" * 25 + "1",
        "13" * 10 + "0", "1232131" * 3 + "131", "13" * 11 + "31", "0103" * 6 + "13")  # fmt: skip
"""Words too long for a key, of several periods, unsorted: pruned words, large and small classes."""


def both(test: Callable[[model.Row], Any], *names: str) -> Callable[[model.Row], Any]:
    """Return a test that also fails for rows in which one of the columns is empty, as in SQL."""
    return lambda row: None not in [row[name] for name in names] and test(row)


WHERE: dict[str, Callable[[model.Row], Any]] = {
    # of classes
    "lambda_c < 0.5": both(lambda row: row["lambda_c"] < 0.5, "lambda_c"),
    "length is null": lambda row: row["length"] is None,
    "p % 2 and walls < 3": both(lambda row: row["p"] % 2 and row["walls"] < 3, "walls"),
    "symmetry = 'T' or maslov > 12": lambda row: row["symmetry"] == "T" or (row["maslov"] or 0) > 12,
    "born > 0.5": both(lambda row: row["born"] > 0.5, "born"),
    "dies < 1 or born is null": lambda row: row["born"] is None or (row["dies"] or 9) < 1,
    "status = 'geometric' or rules is not null": lambda row: bool(row["rules"]),
    "status <> 'orbit' and p < 5": lambda row: row["status"] != "orbit" and row["p"] < 5,
    # patterns
    "code like '%31%'": lambda row: "31" in row["code"],
    "code not glob '*31*' AND length > 9": both(
        lambda row: "31" not in row["code"] and row["length"] > 9, "length"
    ),
    "code like '1_3%'": lambda row: row["code"][0] == "1" and row["code"][2:3] == "3",
    "contains(code, '131')": lambda row: "131" in row["code"] * 3,
    "not contains(code, '02') and p > 2": lambda row: row["p"] > 2 and "02" not in row["code"] * 2,
    "contains(representative, '31')": lambda row: "31" in (row["representative"] or "") * 2,
    # of single words
    "area > 0 and p > 3": both(lambda row: row["area"] > 0 and row["p"] > 3, "area"),
    "element = 3": lambda row: row["element"] == 3,
    "element & 1 and length > 9": both(lambda row: row["element"] & 1 and row["length"] > 9, "length"),
    "code > '02' and p in (4, 6)": lambda row: row["code"] > "02" and row["p"] in (4, 6),
    "representative = code": lambda row: row["representative"] == row["code"],
    "code in (code('31'), code('2312')) or code like '0%2'": lambda row: (
        row["code"] in ("13", "1223") or (row["code"][0] == "0" and row["code"][-1] == "2")
    ),
}  # fmt: skip
KEYS = st.sampled_from([name for name in COLUMNS if name not in ("a", "cycle", "solver")])
ORDERS = (
    st.just("p")
    | st.lists(
        st.tuples(st.sampled_from(["-", ""]), KEYS).map("".join), min_size=1, max_size=3, unique=True
    ).map(",".join)
    | st.sampled_from(["code", "-code", "element,-length", "status,code desc", "p,-element", "-area"])
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
        "opening": st.sampled_from([["top:-0.3:0.3"], ["left:0.2:1"], ["bottom::0", "right:-0.1:0.1"]]),
        "without": st.sampled_from([["13"], ["02", "44"], ["31202131"], ["3131313131313131"]]),
        "exists": st.sampled_from([(0.8,), (0.3, 2.0)]),
        "not_at": st.just((0.2,)),
        "length": st.sampled_from([(11.0, None), (None, 14.0), (11.0, 14.0), (99.0, None)]),
        "margin": st.sampled_from([(None, 0.0), (0.05, 0.3)]),
        "lambda_c": st.just((0.38, 0.45)),
        "born": st.sampled_from([(0.1, 1.0), (None, 0.5)]),
        "walls": st.sampled_from([0, 2, (1, None), (2, 3)]),
        "quarter_length": st.sampled_from([(None, 6.0), (5.5, 12.0)]),
        "where": st.sampled_from(sorted(WHERE)),
    },
)
LIMITS = st.none() | st.integers(0, 40)
OFFSETS = st.just(0) | st.integers(0, 60) | st.just(5000)
NAMES = st.lists(st.sampled_from([*COLUMNS, "coordinates"]), min_size=1, max_size=6, unique=True).map(tuple)


def make_catalogue_to_ask(path: Path) -> None:
    """Make a catalogue with two a, births and deaths up to p = 5, part of a period, pruned and long words."""
    known = fill_periods(path, 1.6, range(2, 6)), fill_periods(path, 1.0, range(2, 4))
    made(path, *known, fill_births(path, range(2, 6)), fill_geometric(path, [3, 4]))
    for number, a, kind in ((2, DIED, "died"), (3, REBORN, "born")):
        alter(
            path,
            f"INSERT INTO change SELECT cycle, {number}, {a!r}, {ERROR!r}, '{kind}', 1, 'top left', NULL,"
            f" 1.0, run FROM change WHERE number = 1 AND a < {DIED!r} AND cycle % 3 = 0",
        )
    for word in ("013023", "131013", *LONG):
        fill_words(path, [word], 1.6)


def expected(
    rows: list[model.Row],
    criteria: dict[str, Any],
    order: str = "p",
    limit: int | None = None,
    offset: int = 0,
) -> list[model.Row]:
    """Return the rows that answer a question."""
    found = model.in_order(model.chosen(rows, criteria, WHERE), order)
    return model.cut(found, limit, offset)
