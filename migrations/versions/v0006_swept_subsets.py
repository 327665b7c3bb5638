"""Sweeps of chosen subsets: which orbits are counted and added up is a key of a sweep, empty for all."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}
COUNTS = ("words", "n_c", "classes", "boundary", "unresolved")
SWEEP = ("state", "cursor", "blocks", "seconds", "processor", *COUNTS, "sums", "moments", "run")
BLOCK = ("number", "sums", "moments", "run")


def upgrade() -> None:
    _remake(["selection"])
    for table, columns in (("sweep", SWEEP), ("sweep_block", BLOCK)):
        names, to = ", ".join(columns), f"INSERT INTO {table} (stadium, p, selection"
        op.execute(f"{to}, {names}) SELECT stadium, p, '', {names} FROM old_{table}")
    _drop_old()


def downgrade() -> None:
    _remake([])
    for table, columns in (("sweep", SWEEP), ("sweep_block", BLOCK)):
        names = ", ".join(("stadium", "p", *columns))
        op.execute(f"INSERT INTO {table} ({names}) SELECT {names} FROM old_{table} WHERE selection = ''")
    _drop_old()


def _remake(further: list[str]) -> None:
    """Make the tables anew, with further texts among their keys, and leave what they were as ``old_``."""
    for table in ("sweep_block", "sweep"):
        op.rename_table(table, f"old_{table}")
    op.create_table(
        "sweep",
        sa.Column(
            "stadium", sa.Integer, sa.ForeignKey("stadium.id", name="fk_sweep_stadium"), primary_key=True
        ),
        sa.Column("p", sa.Integer, primary_key=True),
        *(sa.Column(name, sa.Text, primary_key=True) for name in further),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("cursor", sa.Text),
        sa.Column("blocks", sa.Integer, nullable=False),
        sa.Column("seconds", sa.REAL, nullable=False),
        sa.Column("processor", sa.REAL, nullable=False),
        *(sa.Column(name, sa.Integer, nullable=False) for name in COUNTS),
        sa.Column("sums", sa.LargeBinary),
        sa.Column("moments", sa.LargeBinary, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_sweep_run")),
        **STRICT_ORDERED,
    )
    key = ["stadium", "p", *further]
    op.create_table(
        "sweep_block",
        sa.Column("stadium", sa.Integer, primary_key=True),
        sa.Column("p", sa.Integer, primary_key=True),
        *(sa.Column(name, sa.Text, primary_key=True) for name in further),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("sums", sa.LargeBinary, nullable=False),
        sa.Column("moments", sa.LargeBinary, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_sweep_block_run"), nullable=False),
        sa.ForeignKeyConstraint(key, [f"sweep.{name}" for name in key], name="fk_sweep_block_sweep"),
        **STRICT_ORDERED,
    )


def _drop_old() -> None:
    for table in ("sweep_block", "sweep"):
        op.drop_table(f"old_{table}")
