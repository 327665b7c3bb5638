"""Births and deaths: where in a the classes begin and cease to be orbits."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}

VIEW = """\
CREATE VIEW life AS
SELECT change.cycle AS cycle,
       cycle.p AS p,
       cycle.class_size AS class_size,
       cycle.word AS word,
       change.a AS born,
       change.error AS born_error,
       death.a AS dies,
       death.error AS dies_error
FROM change
JOIN cycle ON cycle.id = change.cycle
LEFT JOIN change AS death ON death.cycle = change.cycle AND death.number = change.number + 1
WHERE change.kind = 'born'
"""


def upgrade() -> None:
    op.create_table(
        "change",
        sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id", name="fk_change_cycle"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("a", sa.REAL, nullable=False),
        sa.Column("error", sa.REAL, nullable=False),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("bounce", sa.Integer),
        sa.Column("joint", sa.Text),
        sa.Column("event", sa.Integer),
        sa.Column("slope", sa.REAL),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_change_run"), nullable=False),
        **STRICT_ORDERED,
    )
    op.create_table(
        "birth_fill",
        sa.Column("p", sa.Integer, primary_key=True),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("cursor", sa.Text),
        sa.Column("seconds", sa.REAL, nullable=False),
        sa.Column("words", sa.Integer, nullable=False),
        sa.Column("classes", sa.Integer),
        sa.Column("births", sa.Integer),
        sa.Column("deaths", sa.Integer),
        sa.Column("always", sa.Integer),
        sa.Column("least", sa.REAL),
        sa.Column("largest", sa.REAL),
        **STRICT_ORDERED,
    )
    op.execute(VIEW)


def downgrade() -> None:
    op.execute("DROP VIEW life")
    for table in ("birth_fill", "change"):
        op.drop_table(table)
