"""Metadata with which Datasette explains a catalogue: titles, columns with units, and canned queries."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orbitdb.answer_columns import OF_BOUNDS, OF_ENSEMBLES, OF_LEVELS, OF_LIVES
from orbitdb.column import Column
from orbitdb.columns import EVERY, IN_CATALOGUE
from orbitdb.store.file.schema import LIFE, OF_CLASS, SHARED, TABLES, comments

_SHOWN: dict[str, tuple[str, str, Sequence[Column]]] = {
    "catalogue": ("Words", "One row for each word and half length a. Filter by a, p and status first.", ()),
    "class": ("Symmetry classes", "One row for each symmetry class and half length a.", ()),
    "life": (
        "Births and deaths",
        "One row for each range of a over which a class is an orbit, from born to dies.",
        OF_LIVES,
    ),
    "level": ("Quantum levels", "", OF_LEVELS),
    "entropy_bound": ("Bounds on the topological entropy", "", OF_BOUNDS),
    "trajectory": ("Averages over random trajectories", "", OF_ENSEMBLES),
}
"""The views and tables with results, each with its title, its description, and the columns whose meaning
differs from that in the view ``catalogue``. Datasette lists all others as hidden."""
_OTHERS = {
    "words": "all words of the class, one after another",
    "coordinates": "coordinates of the representative, little-endian float64",
    "word": EVERY["representative"].means,
    "edges": EVERY["window"].means,
    "id": "number of the row",
    "stadium": "id of the row of the table stadium that gives a",
    "run": "id of the row of the table run that says what wrote this row",
}
"""Meanings of the columns that are in no registry."""
_A = "a = CAST(:a AS REAL)"
_QUERIES = {
    "shortest": (
        "The hundred shortest orbits at a given a",
        f"SELECT code, p, length, length_error, lambda_d, time_reversal FROM catalogue WHERE {_A}"
        " AND status = 'orbit' ORDER BY length, code LIMIT 100",
    ),
    "least_unstable": (
        "The hundred orbits with the smallest lambda per bounce at a given a, up to period p",
        f"SELECT code, p, lambda_d, length, time_reversal FROM catalogue WHERE {_A}"
        " AND p <= CAST(:p AS INTEGER) AND status = 'orbit' ORDER BY lambda_d, code LIMIT 100",
    ),
    "word": (
        "One word, given as its least rotation, at every a",
        "SELECT * FROM catalogue WHERE code = :code AND p = length(:code)",
    ),
    "orbits_by_period": (
        "Orbits and classes by period at a given a; N_c is that of the paper's Table 1 where p is filled",
        "SELECT p, sum(class_size) AS N_c, count(*) AS classes, min(length) AS shortest FROM class"
        f" WHERE {_A} AND status = 'orbit' GROUP BY p ORDER BY p",
    ),
    "born_between": (
        "The classes whose orbits are born between two half lengths",
        "SELECT word, p, class_size, born, born_error, dies FROM life WHERE born"
        " BETWEEN CAST(:low AS REAL) AND CAST(:high AS REAL) ORDER BY born, word LIMIT 1000",
    ),
    "levels": (
        "The stored levels of the quantum stadium at a given a",
        f"SELECT k, error, parity, number FROM level WHERE {_A} ORDER BY k",
    ),
}
"""The canned queries by name: a title, and SQL with parameters that Datasette asks for."""


def datasette_metadata(path: Path) -> dict[str, Any]:
    """Return Datasette's metadata for the catalogue in a file (``datasette FILE -m metadata.json``).

    Parameters
    ----------
    path : Path
        The file; Datasette names the database after its stem.
    """
    tables: dict[str, Any] = {
        name: {"description": text, "hidden": True} for name, text in comments().items()
    }
    for name, (title, text, own) in _SHOWN.items():
        known = {each.name: _explained(each) for each in (*EVERY.values(), *own)} | _OTHERS
        if name == "catalogue":
            known["word"] = _explained(EVERY["word"])
        columns = {each: known[each] for each in _columns(name)}
        tables[name] = {"title": title, "description": text or comments()[name], "columns": columns}
    queries = {name: {"title": title, "sql": sql} for name, (title, sql) in _QUERIES.items()}
    return {
        "title": "Unstable periodic orbits of the stadium billiard",
        "description": "Made by orbitdb, after O. Biham and M. Kvale, Phys. Rev. A 46, 6334 (1992).",
        "license": "CC BY 4.0",
        "license_url": "https://creativecommons.org/licenses/by/4.0/",
        "databases": {path.stem: {"tables": tables, "queries": queries}},
    }


def _columns(name: str) -> list[str]:
    """Return the names of the columns of a table or view."""
    of_view = {"catalogue": [each.name for each in IN_CATALOGUE], "class": [*SHARED, *OF_CLASS], "life": LIFE}
    return list(of_view[name]) if name in of_view else re.findall(r"(?m)^    ([a-z]\w*) ", TABLES[name])


def _explained(column: Column) -> str:
    """Return the meaning of a column, with its unit and the name of the column that bounds its error."""
    unit = f" [{column.unit}]" if column.unit not in ("", "1") else ""
    bound = f"; error in {column.bound}" if column.bound.endswith("_error") else ""
    return f"{column.means}{unit}{bound}"
