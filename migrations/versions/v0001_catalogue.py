"""The first schema: cycles, sequences, stadiums, orbits, fills, runs, trajectories, certificates."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

STRICT = {"sqlite_strict": True}
STRICT_ORDERED = {"sqlite_strict": True, "sqlite_with_rowid": False}

VIEW = """\
CREATE VIEW catalogue AS
SELECT stadium.a AS a,
       sequence.p AS p,
       sequence.word AS code,
       sequence.word AS word,
       cycle.word AS representative,
       coalesce(orbit.status, 'geometric') AS status,
       sequence.rules AS rules,
       orbit.length AS length,
       orbit.lyapunov AS lyapunov,
       orbit.lyapunov / sequence.p AS lambda_d,
       orbit.lyapunov / orbit.length AS lambda_c,
       cycle.time_reversal AS time_reversal,
       cycle.symmetry AS symmetry,
       cycle.class_size AS class_size,
       cycle.walls AS walls,
       orbit.margin AS margin,
       orbit.residual AS residual,
       orbit.error AS error,
       orbit.length_error AS length_error,
       orbit.lyapunov_error AS lyapunov_error,
       orbit.iterations AS iterations,
       orbit.solver AS solver,
       sequence.element AS element,
       sequence.cycle AS cycle
FROM sequence
JOIN stadium
LEFT JOIN cycle ON cycle.id = sequence.cycle
LEFT JOIN orbit ON orbit.stadium = stadium.id AND orbit.cycle = sequence.cycle
WHERE orbit.status IS NOT NULL OR sequence.rules IS NOT NULL
"""


def upgrade() -> None:
    op.create_table(
        "cycle",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("p", sa.Integer, nullable=False),
        sa.Column("word", sa.Text, nullable=False),
        sa.Column("class_size", sa.Integer, nullable=False),
        sa.Column("walls", sa.Integer, nullable=False),
        sa.Column("time_reversal", sa.Text, nullable=False),
        sa.Column("symmetry", sa.Text, nullable=False),
        sa.UniqueConstraint("p", "word", name="uq_cycle_p"),
        **STRICT,
    )
    op.create_table(
        "sequence",
        sa.Column("p", sa.Integer, primary_key=True),
        sa.Column("word", sa.Text, primary_key=True),
        sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id", name="fk_sequence_cycle")),
        sa.Column("element", sa.Integer),
        sa.Column("rules", sa.Text),
        **STRICT_ORDERED,
    )
    op.create_table(
        "stadium",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("a", sa.REAL, nullable=False),
        sa.UniqueConstraint("a", name="uq_stadium_a"),
        **STRICT,
    )
    op.create_table(
        "run",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("started", sa.Text, nullable=False),
        sa.Column("version", sa.Text, nullable=False),
        sa.Column("parameters", sa.Text, nullable=False),
        **STRICT,
    )
    op.create_table(
        "orbit",
        sa.Column(
            "stadium", sa.Integer, sa.ForeignKey("stadium.id", name="fk_orbit_stadium"), primary_key=True
        ),
        sa.Column("cycle", sa.Integer, sa.ForeignKey("cycle.id", name="fk_orbit_cycle"), primary_key=True),
        sa.Column("status", sa.Text, nullable=False),
        sa.Column("coordinates", sa.LargeBinary),
        sa.Column("length", sa.REAL),
        sa.Column("lyapunov", sa.REAL),
        sa.Column("margin", sa.REAL),
        sa.Column("residual", sa.REAL),
        sa.Column("error", sa.REAL),
        sa.Column("length_error", sa.REAL),
        sa.Column("lyapunov_error", sa.REAL),
        sa.Column("iterations", sa.Integer, nullable=False),
        sa.Column("solver", sa.Text, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_orbit_run"), nullable=False),
        **STRICT_ORDERED,
    )
    op.create_table(
        "fill",
        sa.Column(
            "stadium", sa.Integer, sa.ForeignKey("stadium.id", name="fk_fill_stadium"), primary_key=True
        ),
        sa.Column("p", sa.Integer, primary_key=True),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("cursor", sa.Text),
        sa.Column("seconds", sa.REAL, nullable=False),
        sa.Column("primitive", sa.Integer),
        *(sa.Column(f"rule_{number}", sa.Integer) for number in range(1, 7)),
        sa.Column("n_t", sa.Integer),
        sa.Column("n_c", sa.Integer),
        sa.Column("classes", sa.Integer),
        sa.Column("boundary", sa.Integer),
        sa.Column("unresolved", sa.Integer),
        **STRICT_ORDERED,
    )
    op.create_table(
        "trajectory",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column(
            "stadium", sa.Integer, sa.ForeignKey("stadium.id", name="fk_trajectory_stadium"), nullable=False
        ),
        sa.Column("bounces", sa.Integer, nullable=False),
        sa.Column("groups", sa.Integer, nullable=False),
        sa.Column("seed", sa.Text, nullable=False),
        sa.Column("lambda_d", sa.REAL, nullable=False),
        sa.Column("lambda_d_error", sa.REAL, nullable=False),
        sa.Column("lambda_c", sa.REAL, nullable=False),
        sa.Column("lambda_c_error", sa.REAL, nullable=False),
        sa.Column("mean_free_path", sa.REAL, nullable=False),
        sa.Column("mean_free_path_error", sa.REAL, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_trajectory_run"), nullable=False),
        **STRICT,
    )
    op.create_table(
        "certificate",
        sa.Column("stadium", sa.Integer, primary_key=True),
        sa.Column("cycle", sa.Integer, primary_key=True),
        sa.Column("radius", sa.REAL, nullable=False),
        sa.Column("bits", sa.Integer, nullable=False),
        sa.Column("version", sa.Text, nullable=False),
        sa.Column("run", sa.Integer, sa.ForeignKey("run.id", name="fk_certificate_run"), nullable=False),
        sa.ForeignKeyConstraint(
            ["stadium", "cycle"], ["orbit.stadium", "orbit.cycle"], name="fk_certificate_orbit"
        ),
        **STRICT_ORDERED,
    )
    op.execute(VIEW)


def downgrade() -> None:
    op.execute("DROP VIEW catalogue")
    for table in ("certificate", "trajectory", "fill", "orbit", "run", "stadium", "sequence", "cycle"):
        op.drop_table(table)
