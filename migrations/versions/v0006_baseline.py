"""The baseline, schema 6; older files are refused.

New catalogues are created with the newest schema (`orbitdb.store.file.migrate`), so there is nothing to do
here.
"""

revision = "0006"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    pass
