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

from orbitdb.columns import IN_CATALOGUE, sql_of

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

_TEXT = Path(__file__).with_name("schema.sql").read_text(encoding="utf-8")

TABLES = {
    found[1]: found[0]
    for found in re.finditer(r"^CREATE TABLE (\w+) \(.*?(?=;$)", _TEXT, re.DOTALL | re.MULTILINE)
}
"""The statements that make the tables, by name, those first that others refer to."""


def comments() -> dict[str, str]:
    """Return what each table holds, as the comment above it says."""
    found = re.finditer(r"(?m)((?:^-- .*\n)+)CREATE TABLE (\w+)", _TEXT)
    return {each[2]: " ".join(line[3:] for line in each[1].splitlines()) for each in found}


REVISIONS = """\
CREATE TABLE alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
)"""
"""Where Alembic keeps which migration the schema is of."""

SHARED = {each.name: sql_of(each) for each in IN_CATALOGUE if not each.single}
"""The columns of both views that all words of a class share, and what they are."""

OF_WORD = {each.name: sql_of(each) for each in IN_CATALOGUE if each.single}
"""The columns of `catalogue` that are of single words; only words in `pruned` break rules."""

OF_CLASS = {"words": "cycle.words", "coordinates": "orbit.coordinates"}
"""Further columns of the view `class`."""

_CLASSES = "stadium CROSS JOIN orbit ON orbit.stadium = stadium.id CROSS JOIN cycle ON cycle.id = orbit.cycle"


def _view(name: str, columns: dict[str, str], rows: str) -> str:
    """Return the statement that makes a view; by CROSS JOIN the loops, and so the rows, keep their order."""
    listed = ",\n       ".join(f"{value} AS {column}" for column, value in columns.items())
    return f"CREATE VIEW {name} AS\nSELECT {listed}\nFROM {rows}"


LIFE = ("cycle", "p", "class_size", "word", "born", "born_error", "dies", "dies_error")
"""The columns of the view `life`."""

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
