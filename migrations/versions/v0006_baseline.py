"""The baseline: schema 6, where the history of the schema begins; files of older ones are refused.

New catalogues are made with the newest schema (`orbitdb.store.file.migrate`), so nothing has to be made here.
"""

revision = "0006"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    pass
