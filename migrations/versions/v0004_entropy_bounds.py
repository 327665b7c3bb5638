"""Proved bounds on the topological entropy, for each a and length of windows."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}


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


def downgrade() -> None:
    op.drop_table("entropy_bound")
