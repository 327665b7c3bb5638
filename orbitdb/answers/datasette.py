"""What Datasette needs to explain a catalogue: titles, columns with units, and canned queries."""

import re
from pathlib import Path
from typing import Any

from orbitdb.columns import IN_CATALOGUE, OF_LEVELS, OF_ORBITS, Column
from orbitdb.store.file.schema import LIFE, OF_CLASS, SHARED, TABLES, comments

_VIEWS = {
    "catalogue": "One row for each word and half length a. Filter by a, p and status first.",
    "class": "One row for each symmetry class and half length a.",
    "life": "One row for each stretch of a over which a class is an orbit, from born to dies.",
}
_A = "a = CAST(:a AS REAL)"
_QUERIES = {
    "shortest": (
        "The hundred shortest orbits at one a",
        f"SELECT code, p, length, length_error, lambda_d, time_reversal FROM catalogue WHERE {_A}"
        " AND status = 'orbit' ORDER BY length, code LIMIT 100",
    ),
    "least_unstable": (
        "The hundred orbits with the least lambda per bounce at one a, up to a period",
        f"SELECT code, p, lambda_d, length, time_reversal FROM catalogue WHERE {_A}"
        " AND p <= CAST(:p AS INTEGER) AND status = 'orbit' ORDER BY lambda_d, code LIMIT 100",
    ),
    "word": (
        "What became of one word (its least rotation) at every a",
        "SELECT * FROM catalogue WHERE code = :code AND p = length(:code)",
    ),
    "orbits_by_period": (
        "Orbits and classes by period at one a; N_c is that of the paper's Table 1 where p is filled",
        "SELECT p, sum(class_size) AS N_c, count(*) AS classes, min(length) AS shortest FROM class"
        f" WHERE {_A} AND status = 'orbit' GROUP BY p ORDER BY p",
    ),
    "born_between": (
        "The classes whose orbits are born between two half lengths",
        "SELECT word, p, class_size, born, born_error, dies FROM life WHERE born"
        " BETWEEN CAST(:low AS REAL) AND CAST(:high AS REAL) ORDER BY born, word LIMIT 1000",
    ),
    "levels": (
        "The stored levels of the quantum stadium at one a",
        f"SELECT k, error, parity, number FROM level WHERE {_A} ORDER BY k",
    ),
}
"""By name: a title, and SQL whose parameters Datasette asks for."""


def datasette_metadata(path: Path) -> dict[str, Any]:
    """Return Datasette's metadata for the catalogue in a file (``datasette FILE -m metadata.json``).

    Parameters
    ----------
    path : Path
        Its stem is the name of the database.
    """
    known = {column.name: _explained(column) for column in (*OF_LEVELS, *IN_CATALOGUE)}
    tables: dict[str, Any] = {name: {"description": text} for name, text in comments().items()}
    tables |= {name: {"description": text} for name, text in _VIEWS.items()}
    for name, listed in _columns().items():
        word = known["code" if name == "catalogue" else "representative"]
        own = known | {"word": word}
        tables[name]["columns"] = {each: own[each] for each in listed if each in own}
    queries = {name: {"title": title, "sql": sql} for name, (title, sql) in _QUERIES.items()}
    return {
        "title": "Unstable periodic orbits of the stadium billiard",
        "description": "Made by orbitdb, after O. Biham and M. Kvale, Phys. Rev. A 46, 6334 (1992).",
        "license": "CC BY 4.0",
        "license_url": "https://creativecommons.org/licenses/by/4.0/",
        "databases": {path.stem: {"tables": tables, "queries": queries}},
    }


def _columns() -> dict[str, list[str]]:
    """Return the columns of every table and view."""
    tables = {name: re.findall(r"(?m)^    ([a-z]\w*) ", text) for name, text in TABLES.items()}
    of_class = [*SHARED, *OF_CLASS]
    return tables | {"catalogue": [each.name for each in IN_CATALOGUE], "class": of_class, "life": list(LIFE)}


def _explained(column: Column) -> str:
    """Return the meaning of a column, with its unit and the bound on its error."""
    unit = f" [{column.unit}]" if column.unit not in ("", "1") else ""
    names = {each.name for each in OF_ORBITS}
    bound = f"; error bounded by {column.bound}" if column.bound in names else ""
    return f"{column.means}{unit}{bound}"
