"""Schema 9, the baseline: the first that was released. Older files are refused.

There is nothing to do here, because `orbitdb.store.file` creates catalogues with the latest schema.
"""

revision = "0009"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    pass
