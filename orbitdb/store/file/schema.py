"""The schema of a catalogue as SQLite's own text: the tables, from ``schema.sql``, and the views.

It makes a new file, every file is compared with it (`orbitdb.store.file.guard`), and
`orbitdb.store.file.tables` makes SQLAlchemy's tables from it. Nothing here needs SQLAlchemy, which takes a
quarter of a second to load.

`cycle` has one row a symmetry class, with what does not depend on a; `orbit` has one row a class
and a. Two views join them: `class`, one row a class and a, and `catalogue`, one row a word
and a. All tables are STRICT.
"""

import re
from pathlib import Path

APPLICATION_ID = 0x6F726264
"""'orbd', in the header of every catalogue file."""

SCHEMA_VERSION = 7
"""The number of the newest migration; kept as SQLite's user_version."""

OLDEST_VERSION = 6
"""The first migration: older files are refused."""

PAGE_SIZE = 16384
"""Bytes of a page of a new file, four times what SQLite takes by itself.

Rows come in the order of their keys, and filling one such page is a fifth less work than four small ones."""

DONE, FILLING = "done", "filling"
"""The states of a period in the tables `fill`, `birth_fill` and `sweep`."""

BORN, DIED = "born", "died"
"""The kinds of a change."""

SWEPT = ("words", "n_c", "classes", "boundary", "unresolved")
"""What a sweep counts (`orbitdb.orbits.sums.Tally`)."""

LONG = 7 << 58
"""The id of the first class of words that have no key; the others follow.

It is above all keys, and four times as much is still an integer of SQLite."""

TABLES = {
    found[1]: found[0]
    for found in re.finditer(
        r"^CREATE TABLE (\w+) \(.*?(?=;$)",
        Path(__file__).with_name("schema.sql").read_text(encoding="utf-8"),
        re.DOTALL | re.MULTILINE,
    )
}
"""The statements that make the tables, by name, those first that others refer to."""

REVISIONS = """\
CREATE TABLE alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
)"""
"""Where Alembic keeps which migration the schema is of."""

_END = "(SELECT {value} FROM change WHERE change.cycle = orbit.cycle AND change.number = {number})"

SHARED = {
    "a": "stadium.a",
    "p": "cycle.p",
    "representative": "cycle.word",
    "status": "orbit.status",
    "length": "orbit.length",
    "lyapunov": "orbit.lyapunov",
    "lambda_d": "orbit.lyapunov / cycle.p",
    "lambda_c": "orbit.lyapunov / orbit.length",
    "time_reversal": "cycle.time_reversal",
    "symmetry": "cycle.symmetry",
    "class_size": "cycle.class_size",
    "walls": "cycle.walls",
    "maslov": "3 * cycle.p - cycle.walls",
    "margin": "orbit.margin",
    "residual": "orbit.residual",
    "error": "orbit.error",
    "length_error": "orbit.length_error",
    "lyapunov_error": "orbit.lyapunov_error",
    "iterations": "orbit.iterations",
    "solver": "orbit.solver",
    "cycle": "orbit.cycle",
    "born": _END.format(value="nullif(change.a, 0.0)", number=1),
    "dies": _END.format(value="change.a", number=2),
}
"""The columns of both views that all words of a class share, and what they are."""

_CODE = "substr(cycle.words, 1 + cycle.p * element.n, cycle.p)"
OF_WORD = {"code": _CODE, "word": _CODE, "rules": "NULL", "element": "element.element"}
"""The columns of `catalogue` that are of single words; only words in `pruned` break rules."""

OF_CLASS = {"words": "cycle.words", "coordinates": "orbit.coordinates"}
"""Further columns of the view `class`."""

_CLASSES = "stadium CROSS JOIN orbit ON orbit.stadium = stadium.id CROSS JOIN cycle ON cycle.id = orbit.cycle"


def _view(name: str, columns: dict[str, str], rows: str) -> str:
    """Return the statement that makes a view; by CROSS JOIN the loops, and so the rows, keep their order."""
    listed = ",\n       ".join(f"{value} AS {column}" for column, value in columns.items())
    return f"CREATE VIEW {name} AS\nSELECT {listed}\nFROM {rows}"


VIEWS = {
    "class": _view("class", SHARED | OF_CLASS, _CLASSES),
    "catalogue": _view(
        "catalogue",
        SHARED | OF_WORD,
        f"{_CLASSES} CROSS JOIN element ON element.symmetry = cycle.symmetry",
    ),
    "life": """\
CREATE VIEW life AS
SELECT change.cycle AS cycle,
       cycle.p AS p,
       cycle.class_size AS class_size,
       cycle.word AS word,
       nullif(change.a, 0.0) AS born,
       change.error AS born_error,
       death.a AS dies,
       death.error AS dies_error
FROM change
JOIN cycle ON cycle.id = change.cycle
LEFT JOIN change AS death ON death.cycle = change.cycle AND death.number = change.number + 1
WHERE change.kind = 'born'""",
}
"""The statements that make the views.

`class` has one row a class and a, `catalogue` one row a word and a, both by a, class and element; `life` has
one row a life of a class, from ``born`` (NULL: from a = 0 on) to ``dies`` (NULL: no end)."""
