"""The tables of a catalogue, as SQLAlchemy's `Table`s, and the ids of their rows.

`cycle` has one row per symmetry class, with everything that does not depend on a; `orbit` has one row per
class and value of a. All tables are STRICT. A change of a table takes a revision in ``migrations/`` and a new
`SCHEMA_VERSION`; the views (`orbitdb.store.views`) need none.
"""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from typing import Any

from sqlalchemy import (
    REAL,
    BindParameter,
    Column,
    ColumnElement,
    Connection,
    ForeignKey,
    ForeignKeyConstraint,
    FromClause,
    Integer,
    LargeBinary,
    MetaData,
    PrimaryKeyConstraint,
    RowMapping,
    String,
    Table,
    Text,
    UniqueConstraint,
    func,
    or_,
    select,
    text,
    true,
)

from orbitdb.errors import AlteredError
from orbitdb.symbols.words import MAX_KEYED, key

APPLICATION_ID = 0x6F726264
"""'orbd', in the header of every catalogue file."""

SCHEMA_VERSION = 11
"""The version of the latest schema, stored as SQLite's user_version; the latest revision has its number."""

OLDEST_VERSION = 9
"""The oldest schema that can be upgraded; files with an older one are refused."""

OLDEST_READABLE = 9
"""The oldest schema that can be read without an upgrade, because no table lacks a column.

A reading connection has an empty table for each table that the file does not have yet."""

PAGE_SIZE = 16384
"""Page size of a new file in bytes; SQLite's default is 4096.

Rows arrive in the order of their keys, and filling one large page takes a fifth less time than filling four
small ones."""

DONE, FILLING = "done", "filling"
"""The states of a period in the tables `fill`, `pruned_fill`, `birth_fill` and `sweep`."""

BORN, DIED = "born", "died"
"""The two kinds of change."""

TALLIED = ("words", "n_c", "classes", "boundary", "unresolved")
"""The columns with the counts of a sweep, in the order of `orbitdb.orbits.exponents.Tally`."""

metadata = MetaData(
    naming_convention={
        "fk": "fk_%(table_name)s_%(referred_table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
    }
)
"""All tables of the latest schema; a table comes after the tables that it refers to."""


def _integer(name: str, *more: Any, null: bool = False, **options: Any) -> Column[int]:
    return Column(name, Integer, *more, nullable=null, **options)


def _real(name: str, null: bool = False, **options: Any) -> Column[float]:
    return Column(name, REAL, nullable=null, **options)


def _text(name: str, null: bool = False, **options: Any) -> Column[str]:
    return Column(name, Text, nullable=null, **options)


def _blob(name: str, null: bool = False) -> Column[bytes]:
    return Column(name, LargeBinary, nullable=null)


def _refer(name: str, target: str, null: bool = False, **options: Any) -> Column[int]:
    return Column(name, Integer, ForeignKey(f"{target}.id"), nullable=null, **options)


def _keyed(name: str, *parts: Any, **options: Any) -> Table:
    """Return a STRICT table that is stored in the order of its primary key, without a rowid."""
    return Table(name, metadata, *parts, sqlite_strict=True, sqlite_with_rowid=False, **options)


def _numbered(name: str, *parts: Any, **options: Any) -> Table:
    """Return a STRICT table with an integer ``id`` as its primary key."""
    columns = [Column("id", Integer, primary_key=True, nullable=False), *parts]
    return Table(name, metadata, *columns, sqlite_strict=True, **options)


# The half lengths a for which something is stored. The id of a deleted stadium is never used again, so that
# work begun before the deletion cannot be taken for work on another stadium.
stadium = _numbered("stadium", _real("a"), UniqueConstraint("a"), sqlite_autoincrement=True)

# The run of the program that wrote a row: when it started (UTC), the version, its parameters as JSON, and
# its number of transactions, which tells whether a journal belongs to this file.
run = _numbered(
    "run",
    _text("started"),
    _text("version"),
    _text("parameters"),
    _integer("commits", server_default=text("0")),
)

# One symmetry class: its least word, its number of words, its number of bounces on straight walls, and all
# its words one after another, p symbols each, in the order of the elements that lead to them, beginning with
# the least word. The id is the key of the least word (orbitdb.symbols.words.key); classes of longer words
# are numbered from LONG up.
cycle = _numbered(
    "cycle",
    _integer("p"),
    _text("word"),
    _integer("class_size"),
    _integer("walls"),
    _text("time_reversal"),
    _text("symmetry"),
    _text("words"),
)

# The element that leads to the n-th word of a class with this symmetry, counted from 0. Every file has the
# same rows.
element = _keyed(
    "element", _text("symmetry", primary_key=True), _integer("n", primary_key=True), _integer("element")
)

# Words that break geometric rules, as least rotations (fill --geometric). They have no class. The id is
# minus the key of the word; longer words are numbered from -LONG down.
pruned = _numbered("pruned", _integer("p"), _text("word"), _text("rules"), UniqueConstraint("p", "word"))

# How far the pruned words of a period are stored, the number stored so far, and the elapsed time.
pruned_fill = _keyed(
    "pruned_fill",
    _integer("p", primary_key=True),
    _text("state"),
    _text("cursor", null=True),
    _real("seconds"),
    _integer("words"),
)

# The result for a class at one value of a; the coordinates, in little-endian float64, and the sign of the
# area are those of the least word.
orbit = _keyed(
    "orbit",
    _refer("stadium", "stadium", primary_key=True),
    _refer("cycle", "cycle", primary_key=True),
    _text("status"),
    _blob("coordinates", null=True),
    *(
        _real(name, null=True)
        for name in ("length", "lyapunov", "margin", "residual", "error", "length_error", "lyapunov_error")
    ),
    _real("area", null=True),
    _real("area_error", null=True),
    _integer("iterations"),
    _text("solver"),
    _refer("run", "run"),
)

# How far a period is filled at one value of a, the elapsed time, and the processor time of each stage, in
# seconds. The counts are stored once the state is 'done'.
fill = _keyed(
    "fill",
    _refer("stadium", "stadium", primary_key=True),
    _integer("p", primary_key=True),
    _text("state"),
    _text("cursor", null=True),
    _real("seconds"),
    _integer("primitive", null=True),
    *(_integer(f"rule_{number}", null=True) for number in range(1, 7)),
    *(_integer(name, null=True) for name in ("n_t", "n_c", "classes", "boundary", "unresolved")),
    _integer("words", server_default=text("0")),
    *(_real(name, server_default=text("0")) for name in ("enumerating", "solving", "storing")),
)

# A proof in ball arithmetic that a stored orbit exists: its true coordinates are within the radius of the
# stored ones.
certificate = _keyed(
    "certificate",
    _integer("stadium", primary_key=True),
    _integer("cycle", primary_key=True),
    _real("radius"),
    _integer("bits"),
    _text("version"),
    _refer("run", "run"),
    ForeignKeyConstraint(["stadium", "cycle"], ["orbit.stadium", "orbit.cycle"]),
)

# A value of a at which a class begins or ceases to be an orbit, numbered from 1 as a grows, and the bound on
# its error. The given bounce of the least word, counted from 1, passes through the joint there; slope is
# d slack / d ln a in radians. Changes of the same period with the same event have the same path at this a;
# events are numbered once the period is complete. A class that is an orbit from a = 0 on has a birth at 0,
# without a joint.
change = _keyed(
    "change",
    _refer("cycle", "cycle", primary_key=True),
    _integer("number", primary_key=True),
    _real("a"),
    _real("error"),
    _text("kind"),
    _integer("bounce", null=True),
    _text("joint", null=True),
    _integer("event", null=True),
    _real("slope", null=True),
    _refer("run", "run"),
)

# How far the changes of a period are stored. The counts are stored once the state is 'done'.
birth_fill = _keyed(
    "birth_fill",
    _integer("p", primary_key=True),
    _text("state"),
    _text("cursor", null=True),
    _real("seconds"),
    _integer("words"),
    *(_integer(name, null=True) for name in ("classes", "births", "deaths", "always")),
    _real("least", null=True),
    _real("largest", null=True),
)

# Averages over an ensemble of random trajectories, a reference for averages over orbits.
trajectory = _numbered(
    "trajectory",
    _refer("stadium", "stadium"),
    _integer("bounces"),
    _integer("groups"),
    _text("seed"),
    *(
        _real(name + suffix)
        for name in ("lambda_d", "lambda_c", "mean_free_path")
        for suffix in ("", "_error")
    ),
    _refer("run", "run"),
)

# Bounds on the topological entropy at one value of a, proved with windows of up to this number of edges;
# proof names the arithmetic that decided the windows. No orbits need to be stored at this a.
entropy_bound = _keyed(
    "entropy_bound",
    _real("a", primary_key=True),
    _text("proof", primary_key=True),
    _integer("edges", primary_key=True),
    _real("lower"),
    _real("upper"),
    _integer("windows"),
    _integer("undecided"),
    _refer("run", "run"),
)

# What escapes from the stadium at one value of a through openings, or by patterns, separated by blanks: the
# rates and their errors, empty where they are not defined, and sampled survival with its standard errors by
# bounce, time and leg, in little-endian float64. No orbits need to be stored at this a.
open_stadium = _keyed(
    "open_stadium",
    _real("a", primary_key=True),
    _text("opening", primary_key=True),
    _text("without", primary_key=True),
    _integer("trajectories", primary_key=True),
    _integer("bounces", primary_key=True),
    _text("seed", primary_key=True),
    *(
        _real(name + suffix, null=True)
        for name in ("rate_leg", "rate_time", "rate_bounce")
        for suffix in ("", "_error")
    ),
    _blob("survival"),
    _refer("run", "run"),
)

# A window low <= k < high in which all levels of one parity are stored at one value of a, the number of
# levels below the window, and the processor time in seconds. Windows do not overlap.
level_fill = _keyed(
    "level_fill",
    _real("a", primary_key=True),
    _text("parity", primary_key=True),
    _real("low", primary_key=True),
    _real("high"),
    _integer("below"),
    _real("seconds"),
    _refer("run", "run"),
)

# A level of one parity at one value of a, numbered from 1, with an estimate of its error. No orbits need to
# be stored at this a.
level = _keyed(
    "level",
    _real("a", primary_key=True),
    _text("parity", primary_key=True),
    _integer("number", primary_key=True),
    _real("k"),
    _real("error"),
)

# How far a period is swept at one value of a: the number of blocks, the counts so far, the elapsed time and
# the processor time in seconds. The sums (orbitdb.averages.by_period) are stored once the state is 'done'.
sweep = _keyed(
    "sweep",
    _refer("stadium", "stadium", primary_key=True),
    _integer("p", primary_key=True),
    _text("state"),
    _text("cursor", null=True),
    _integer("blocks"),
    _real("seconds"),
    _real("processor"),
    *(_integer(name) for name in TALLIED),
    _blob("sums", null=True),
    _refer("run", "run", null=True),
)

# The sums of one block, numbered from 0, of a sweep that is not done.
sweep_block = _keyed(
    "sweep_block",
    _integer("stadium", primary_key=True),
    _integer("p", primary_key=True),
    _integer("number", primary_key=True),
    _blob("sums"),
    _refer("run", "run"),
    ForeignKeyConstraint(["stadium", "p"], ["sweep.stadium", "sweep.p"]),
)

TABLES = metadata.tables
"""The tables by name."""

revision = Table(
    "alembic_version",
    MetaData(),  # Alembic's own table, which it would drop if it were among ours
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)
"""The table in which Alembic keeps the revision of the file."""


@contextmanager
def readable(what: str) -> Iterator[None]:
    """Turn the errors that damaged values cause into an `AlteredError` that names what was read."""
    try:
        yield
    except (LookupError, TypeError, ValueError) as error:
        raise AlteredError(what) from error


def checked(table: Table, row: RowMapping) -> dict[str, Any]:
    """Return a row as a dict, after a check that each value has a type that its column allows.

    A flipped bit can make NULL, or a value of another type, of any value. Raises `AlteredError`.
    """
    for name, value in row.items():
        column = table.c[name]
        allowed = column.nullable if value is None else isinstance(value, _TYPES[column.type.__class__])
        if not allowed:
            raise AlteredError(f"{table.name}.{name} is {value!r:.40}")
    return dict(row)


_TYPES: dict[type[Any], tuple[type, ...]] = {
    Integer: (int,), REAL: (int, float), Text: (str,), String: (str,), LargeBinary: (bytes,)
}  # fmt: skip
"""The types of Python's values in a column."""


def at_a(table: FromClause, a: float | BindParameter[float]) -> ColumnElement[bool]:
    """Return the condition for rows of one value of a, in a table that refers to `stadium`."""
    own = select(stadium.c.id).where(stadium.c.a == a).correlate(None).scalar_subquery()
    return table.c.stadium == own


def in_spans(column: ColumnElement[int], spans: Sequence[tuple[int, int]]) -> ColumnElement[bool]:
    """Return the condition that a period is in one of the ranges; without ranges, every period is."""
    return or_(*(column.between(low, high) for low, high in spans)) if spans else true()


# ids


LONG = 7 << 58
"""The first id for classes whose words are too long for a key.

It is larger than all keys, and four times its value still fits into an SQLite integer."""


def class_ids(connection: Connection, words: Sequence[str]) -> dict[str, int]:
    """Return the ids of the classes of representatives; long words that are not stored get new ids."""
    ids = {word: key(word) for word in words if len(word) <= MAX_KEYED}
    if long := [word for word in dict.fromkeys(words) if word not in ids]:
        stored = select(cycle.c.word, cycle.c.id).where(cycle.c.id >= LONG, in_list(cycle.c.word, long))
        ids |= {row.word: row.id for row in connection.execute(stored)}
        next_id = max(LONG, (connection.scalar(select(func.max(cycle.c.id))) or 0) + 1)
        ids |= zip((word for word in long if word not in ids), count(next_id))
    return ids


def in_list(
    column: ColumnElement[Any], values: Sequence[str | int] | BindParameter[str]
) -> ColumnElement[bool]:
    """Return the condition that a column is one of many values, which are passed as a single JSON text."""
    listed = values if isinstance(values, BindParameter) else json.dumps(values)
    return column.in_(select(func.json_each(listed).table_valued("value").c.value))


def pruned_ids(connection: Connection, p: int, words: Sequence[str]) -> list[int]:
    """Return ids for pruned words of period p that are not yet stored."""
    if p <= MAX_KEYED:
        return [-key(word) for word in words]
    first = min(-LONG, (connection.scalar(select(func.min(pruned.c.id))) or 0) - 1)
    return list(range(first, first - len(words), -1))
