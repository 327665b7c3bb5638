"""The tables of a catalogue.

What does not depend on a is stored once (`cycle`, `sequence`); what does is one row a symmetry class
(`orbit`). The view `catalogue` shows one row a symbol sequence and a. All tables are STRICT; numbers
that must survive bit by bit as arrays are BLOBs of little-endian float64.
"""

from typing import Any

import sqlalchemy as sa

from orbitdb.columns import IN_CATALOGUE

DONE, FILLING = "done", "filling"
"""The states of a period in the tables `fill` and `birth_fill`."""

BORN, DIED = "born", "died"
"""The kinds of a change."""

DOUBLES, BALLS = "doubles", "balls"
"""What proves a bound on the entropy: doubles with bounds on their errors, or ball arithmetic, too."""

metadata = sa.MetaData(
    naming_convention={
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
    }
)

STRICT: dict[str, Any] = {"sqlite_strict": True}
STRICT_ORDERED: dict[str, Any] = {"sqlite_strict": True, "sqlite_with_rowid": False}


def _required(
    name: str, kind: type[sa.types.TypeEngine[Any]], *more: sa.schema.SchemaItem, **options: Any
) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)


cycle = sa.Table(
    "cycle",
    metadata,
    sa.Column("id", sa.Integer, primary_key=True),
    _required("p", sa.Integer),
    _required("word", sa.Text),
    _required("class_size", sa.Integer),
    _required("walls", sa.Integer),
    _required("time_reversal", sa.Text),
    _required("symmetry", sa.Text),
    sa.UniqueConstraint("p", "word"),
    **STRICT,
)
"""One symmetry class: its least word, how many words it has, and its straight bounces (`walls`).

Its number is the word's key (`orbitdb.symbols.words.key`), negative for words that are too long for one."""

sequence = sa.Table(
    "sequence",
    metadata,
    sa.Column("p", sa.Integer, primary_key=True),
    sa.Column("word", sa.Text, primary_key=True),
    sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id")),
    sa.Column("element", sa.Integer),
    sa.Column("rules", sa.Text),
    **STRICT_ORDERED,
)
"""One cyclic word, as its least rotation: its class and the element that leads to it, or, for a word
that is geometrically pruned, the rules it breaks."""

stadium = sa.Table(
    "stadium",
    metadata,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("a", sa.REAL, nullable=False, unique=True),
    **STRICT,
)

run = sa.Table(
    "run",
    metadata,
    sa.Column("id", sa.Integer, primary_key=True),
    _required("started", sa.Text),
    _required("version", sa.Text),
    _required("parameters", sa.Text),
    **STRICT,
)
"""Who wrote a row: the program's version, its parameters as JSON, and when (UTC)."""

orbit = sa.Table(
    "orbit",
    metadata,
    sa.Column("stadium", sa.Integer, sa.ForeignKey("stadium.id"), primary_key=True),
    sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id"), primary_key=True),
    _required("status", sa.Text),
    sa.Column("coordinates", sa.LargeBinary),
    sa.Column("length", sa.REAL),
    sa.Column("lyapunov", sa.REAL),
    sa.Column("margin", sa.REAL),
    sa.Column("residual", sa.REAL),
    sa.Column("error", sa.REAL),
    sa.Column("length_error", sa.REAL),
    sa.Column("lyapunov_error", sa.REAL),
    _required("iterations", sa.Integer),
    _required("solver", sa.Text),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    **STRICT_ORDERED,
)
"""What became of a class at one a; the coordinates are those of the class's least word."""

fill = sa.Table(
    "fill",
    metadata,
    sa.Column("stadium", sa.Integer, sa.ForeignKey("stadium.id"), primary_key=True),
    sa.Column("p", sa.Integer, primary_key=True),
    _required("state", sa.Text),
    sa.Column("cursor", sa.Text),
    _required("seconds", sa.REAL),
    sa.Column("primitive", sa.Integer),
    *(sa.Column(f"rule_{number}", sa.Integer) for number in range(1, 7)),
    sa.Column("n_t", sa.Integer),
    sa.Column("n_c", sa.Integer),
    sa.Column("classes", sa.Integer),
    sa.Column("boundary", sa.Integer),
    sa.Column("unresolved", sa.Integer),
    _required("words", sa.Integer, server_default="0"),
    *(_required(name, sa.REAL, server_default="0") for name in ("enumerating", "solving", "storing")),
    **STRICT_ORDERED,
)
"""How far a period is filled at one a, what it took in seconds as they pass and seconds of processors
by stage; the counts are there once the state is ``done``."""

trajectory = sa.Table(
    "trajectory",
    metadata,
    sa.Column("id", sa.Integer, primary_key=True),
    _required("stadium", sa.Integer, sa.ForeignKey("stadium.id")),
    _required("bounces", sa.Integer),
    _required("groups", sa.Integer),
    _required("seed", sa.Text),
    _required("lambda_d", sa.REAL),
    _required("lambda_d_error", sa.REAL),
    _required("lambda_c", sa.REAL),
    _required("lambda_c_error", sa.REAL),
    _required("mean_free_path", sa.REAL),
    _required("mean_free_path_error", sa.REAL),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    **STRICT,
)
"""An ensemble of random trajectories: the reference beside averages over orbits."""

certificate = sa.Table(
    "certificate",
    metadata,
    sa.Column("stadium", sa.Integer, primary_key=True),
    sa.Column("cycle", sa.Integer, primary_key=True),
    _required("radius", sa.REAL),
    _required("bits", sa.Integer),
    _required("version", sa.Text),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    sa.ForeignKeyConstraint(
        ["stadium", "cycle"], ["orbit.stadium", "orbit.cycle"], name="fk_certificate_orbit"
    ),
    **STRICT_ORDERED,
)
"""A proof by ball arithmetic that the stored orbit exists: its coordinates lie within the radius."""

change = sa.Table(
    "change",
    metadata,
    sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id"), primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True),
    _required("a", sa.REAL),
    _required("error", sa.REAL),
    _required("kind", sa.Text),
    sa.Column("bounce", sa.Integer),
    sa.Column("joint", sa.Text),
    sa.Column("event", sa.Integer),
    sa.Column("slope", sa.REAL),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    **STRICT_ORDERED,
)
"""A value of a at which a class begins or ceases to be an orbit, counted from 1 for each class as a grows.

The true value is no farther away than ``error``. ``bounce``, of the class's least word and counted from 1,
comes through ``joint``, ``slope`` is how fast: d slack / d ln a in radians. Changes of one period with one
``event`` are one path at this a; events are numbered when the whole period is there. A class that is an
orbit from a = 0 on is born there, with nothing said of a joint."""

birth_fill = sa.Table(
    "birth_fill",
    metadata,
    sa.Column("p", sa.Integer, primary_key=True),
    _required("state", sa.Text),
    sa.Column("cursor", sa.Text),
    _required("seconds", sa.REAL),
    _required("words", sa.Integer),
    sa.Column("classes", sa.Integer),
    sa.Column("births", sa.Integer),
    sa.Column("deaths", sa.Integer),
    sa.Column("always", sa.Integer),
    sa.Column("least", sa.REAL),
    sa.Column("largest", sa.REAL),
    **STRICT_ORDERED,
)
"""How far the changes of a period are stored; the counts are there once the state is ``done``."""

entropy_bound = sa.Table(
    "entropy_bound",
    metadata,
    sa.Column("a", sa.REAL, primary_key=True),
    sa.Column("proof", sa.Text, primary_key=True),
    sa.Column("edges", sa.Integer, primary_key=True),
    _required("lower", sa.REAL),
    _required("upper", sa.REAL),
    _required("windows", sa.Integer),
    _required("undecided", sa.Integer),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    **STRICT_ORDERED,
)
"""What windows of up to so many edges prove of the topological entropy at one a, which need not be a stadium
with orbits. ``proof`` says what has decided all windows: `DOUBLES`, or `BALLS`, too."""

SWEPT = ("words", "n_c", "classes", "boundary", "unresolved")
"""What a sweep counts (`orbitdb.orbits.tally.Tally`)."""

sweep = sa.Table(
    "sweep",
    metadata,
    sa.Column("stadium", sa.Integer, sa.ForeignKey("stadium.id"), primary_key=True),
    sa.Column("p", sa.Integer, primary_key=True),
    sa.Column("selection", sa.Text, primary_key=True),
    _required("state", sa.Text),
    sa.Column("cursor", sa.Text),
    _required("blocks", sa.Integer),
    _required("seconds", sa.REAL),
    _required("processor", sa.REAL),
    *(_required(name, sa.Integer) for name in SWEPT),
    sa.Column("sums", sa.LargeBinary),
    _required("moments", sa.LargeBinary),
    sa.Column("run", sa.Integer, sa.ForeignKey("run.id")),
    **STRICT_ORDERED,
)
"""How far a period is swept at one a, and what has been counted on the way, in so many blocks; the seconds
are as they passed, and of the processors that solved. The sums, as `orbitdb.averages.period_sums.PeriodSums`
gives their bytes, are there once the state is ``done``, as the moments are (`orbitdb.averages.tilt_moments`),
which begin as those of no orbit. All of it is of a subset of the orbits, by its canonical text
(`orbitdb.store.asking.sweepable.swept_text`), which is empty for all orbits."""

sweep_block = sa.Table(
    "sweep_block",
    metadata,
    sa.Column("stadium", sa.Integer, primary_key=True),
    sa.Column("p", sa.Integer, primary_key=True),
    sa.Column("selection", sa.Text, primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True),
    _required("sums", sa.LargeBinary),
    _required("moments", sa.LargeBinary),
    _required("run", sa.Integer, sa.ForeignKey("run.id")),
    sa.ForeignKeyConstraint(
        ["stadium", "p", "selection"],
        ["sweep.stadium", "sweep.p", "sweep.selection"],
        name="fk_sweep_block_sweep",
    ),
    **STRICT_ORDERED,
)
"""The sums of a block of a sweep that is not done, counted from 0."""

_TYPES: dict[str, type[sa.types.TypeEngine[Any]]] = {
    "text": sa.Text,
    "integers": sa.Text,
    "integer": sa.Integer,
    "number": sa.REAL,
}

catalogue = sa.table("catalogue", *(sa.column(each.name, _TYPES[each.kind]) for each in IN_CATALOGUE))
"""The view: one row a symbol sequence and a."""

ENDS = ("born", "dies")
"""The first birth and the first death of a word, as the view has them.

No `born` for a word that is an orbit from a = 0 on, as for one of which no births are stored."""

life = sa.table(
    "life",
    *(sa.column(name, sa.Integer) for name in ("cycle", "p", "class_size")),
    sa.column("word", sa.Text),
    *(sa.column(name, sa.REAL) for name in ("born", "born_error", "dies", "dies_error")),
)
"""The view of the lives of classes: from ``born`` to ``dies`` in a; NULL where that has no end."""
