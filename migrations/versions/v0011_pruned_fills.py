"""Schema 11: fills of pruned words, and open stadiums; sweeps without moments for sum rules."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "pruned_fill",
        sa.Column("p", sa.Integer(), nullable=False),
        sa.Column("state", sa.Text(), nullable=False),
        sa.Column("cursor", sa.Text(), nullable=True),
        sa.Column("seconds", sa.REAL(), nullable=False),
        sa.Column("words", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("p"),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
    op.create_table(
        "open_stadium",
        sa.Column("a", sa.REAL(), nullable=False),
        sa.Column("opening", sa.Text(), nullable=False),
        sa.Column("without", sa.Text(), nullable=False),
        sa.Column("trajectories", sa.Integer(), nullable=False),
        sa.Column("bounces", sa.Integer(), nullable=False),
        sa.Column("seed", sa.Text(), nullable=False),
        sa.Column("rate_leg", sa.REAL(), nullable=True),
        sa.Column("rate_leg_error", sa.REAL(), nullable=True),
        sa.Column("rate_time", sa.REAL(), nullable=True),
        sa.Column("rate_time_error", sa.REAL(), nullable=True),
        sa.Column("rate_bounce", sa.REAL(), nullable=True),
        sa.Column("rate_bounce_error", sa.REAL(), nullable=True),
        sa.Column("survival", sa.LargeBinary(), nullable=False),
        sa.Column("run", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["run"], ["run.id"], name="fk_open_stadium_run"),
        sa.PrimaryKeyConstraint("a", "opening", "without", "trajectories", "bounces", "seed"),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
    for table in ("sweep", "sweep_block"):
        op.drop_column(table, "moments")
