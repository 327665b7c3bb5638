"""Proved bounds on the topological entropy, for each a and length of windows; the view tells of lives."""

import sqlalchemy as sa
from alembic import op

from orbitdb.migrations.versions.v0001_catalogue import VIEW

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}

LAST = "       sequence.cycle AS cycle"
ENDS = """,
       (SELECT nullif(change.a, 0.0) FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 1) AS born,
       (SELECT change.a FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 2) AS dies"""


def upgrade() -> None:
    op.create_table(
        "entropy_bound",
        sa.Column("a", sa.REAL, primary_key=True),
        sa.Column("proof", sa.Text, primary_key=True),
        sa.Column("edges", sa.Integer, primary_key=True),
        sa.Column("lower", sa.REAL, nullable=False),
        sa.Column("upper", sa.REAL, nullable=False),
        sa.Column("windows", sa.Integer, nullable=False),
        sa.Column("undecided", sa.Integer, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_entropy_bound_run"), nullable=False),
        **STRICT_ORDERED,
    )
    op.execute("DROP VIEW catalogue")
    op.execute(VIEW.replace(LAST, LAST + ENDS))


def downgrade() -> None:
    op.execute("DROP VIEW catalogue")
    op.execute(VIEW)
    op.drop_table("entropy_bound")
