"""Schema 6, the baseline: files with an older schema are refused.

There is nothing to do here, because `orbitdb.store.file.migrate` creates catalogues with the latest schema.
"""

revision = "0006"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    pass
