"""The schema of a catalogue as SQL: the tables from ``schema.sql``, and the views.

New files are created with it. A change of a table takes a new version, and a migration; the views need none,
because every reading connection makes its own.

`cycle` has one row per symmetry class, with everything that does not depend on a; `orbit` has one row per
class and value of a. All tables are STRICT.

The id of a class is the key of its representative (`orbitdb.symbols.words.key`), so any process can compute
it, and the table is in the order of words. Classes whose words are too long for a key are numbered from
`LONG` up in order of arrival. Ids of geometrically pruned words are made in the same way, but are negative.
"""

import re
import sqlite3
from collections.abc import Sequence
from pathlib import Path

from orbitdb.columns import IN_CATALOGUE
from orbitdb.symbols.words import MAX_KEYED, key

APPLICATION_ID = 0x6F726264
"""'orbd', in the header of every catalogue file."""

SCHEMA_VERSION = 9
"""The version of the latest schema, stored as SQLite's user_version."""

OLDEST_VERSION = 9
"""The oldest schema that can be migrated; files with an older one are refused."""

PAGE_SIZE = 16384
"""Page size of a new file in bytes; SQLite's default is 4096.

Rows arrive in the order of their keys, and filling one large page takes a fifth less time than filling four
small ones."""

DONE, FILLING = "done", "filling"
"""The states of a period in the tables `fill`, `birth_fill` and `sweep`."""

BORN, DIED = "born", "died"
"""The two kinds of change."""

SWEPT = ("words", "n_c", "classes", "boundary", "unresolved")
"""The columns with the counts of a sweep, in the order of `orbitdb.orbits.exponents.Tally`."""


_TEXT = Path(__file__).with_name("schema.sql").read_text(encoding="utf-8")

TABLES = {
    statement[1]: statement[0]
    for statement in re.finditer(r"^CREATE TABLE (\w+) \(.*?(?=;$)", _TEXT, re.DOTALL | re.MULTILINE)
}
"""The CREATE statements of the tables, by name; a table comes after those that it refers to."""


REVISIONS = """\
CREATE TABLE alembic_version (
    version_num VARCHAR(32) NOT NULL,
    CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
)"""
"""The CREATE statement of Alembic's table."""

SHARED = {column.name: column.sql for column in IN_CATALOGUE if not column.single}
"""SQL for the columns that both views have, and whose values all words of a class share."""

OF_WORD = {column.name: column.sql for column in IN_CATALOGUE if column.single}
"""SQL for the columns of `catalogue` whose values differ between the words of a class."""

OF_CLASS = {"words": "cycle.words", "coordinates": "orbit.coordinates", "area": "orbit.area"}
"""SQL for further columns of the view `class`; the area is that of the representative."""

_CLASSES = "stadium CROSS JOIN orbit ON orbit.stadium = stadium.id CROSS JOIN cycle ON cycle.id = orbit.cycle"


def _view(name: str, columns: dict[str, str], rows: str) -> str:
    """Return the CREATE statement of a view; CROSS JOIN fixes the order of the loops, and so of the rows."""
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
"""The CREATE statements of the views.

`class` has one row per class and value of a, `catalogue` one per word and value of a; both are ordered by a,
class and element. `life` has one row per life of a class, from ``born`` (NULL for an orbit from a = 0 on) to
``dies`` (NULL if it never dies)."""


_OWN = {"a": ":0", "p": "p", "code": "word", "words": "word", "status": "'geometric'", "rules": "rules"}

PRUNED_ROWS = "(SELECT id, {} FROM pruned)".format(
    ", ".join(f"{_OWN.get(name, 'NULL')} AS {name}" for name in SHARED | OF_WORD | OF_CLASS)
)
"""A query for the geometrically pruned words at the a named ``:0``, with the columns of both views."""

AT_A = "stadium = (SELECT id FROM stadium WHERE a = ?)"
"""The condition for rows of one value of a, in tables that refer to `stadium`."""


# ids


LONG = 7 << 58
"""The first id for classes whose words are too long for a key.

It is larger than all keys, and four times its value still fits into an SQLite integer."""


def id_of_class(connection: sqlite3.Connection, word: str) -> int:
    """Return the id of the class of a representative; a long word that is not stored gets a new id."""
    if len(word) <= MAX_KEYED:
        return key(word)
    query = "SELECT id FROM cycle WHERE id >= ? AND p = ? AND word = ?"
    stored = connection.execute(query, (LONG, len(word), word)).fetchone()
    (last,) = connection.execute("SELECT max(id) FROM cycle").fetchone()
    return int(stored[0]) if stored else max(LONG, (last or 0) + 1)


def ids_of_pruned(connection: sqlite3.Connection, p: int, words: Sequence[str]) -> list[int]:
    """Return ids for pruned words of period p that are not yet stored."""
    if p <= MAX_KEYED:
        return [-key(word) for word in words]
    (last,) = connection.execute("SELECT min(id) FROM pruned").fetchone()
    first = min(-LONG, (last or 0) - 1)
    return list(range(first, first - len(words), -1))
