"""Sweeps: counts and sums over periods of which no rows are kept."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}
COUNTS = ("words", "n_c", "classes", "boundary", "unresolved")


def upgrade() -> None:
    op.create_table(
        "sweep",
        sa.Column(
            "stadium", sa.Integer, sa.ForeignKey("stadium.id", name="fk_sweep_stadium"), primary_key=True
        ),
        sa.Column("p", sa.Integer, primary_key=True),
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
    op.create_table(
        "sweep_block",
        sa.Column("stadium", sa.Integer, primary_key=True),
        sa.Column("p", sa.Integer, primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("sums", sa.LargeBinary, nullable=False),
        sa.Column("moments", sa.LargeBinary, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_sweep_block_run"), nullable=False),
        sa.ForeignKeyConstraint(["stadium", "p"], ["sweep.stadium", "sweep.p"], name="fk_sweep_block_sweep"),
        **STRICT_ORDERED,
    )


def downgrade() -> None:
    for table in ("sweep_block", "sweep"):
        op.drop_table(table)
