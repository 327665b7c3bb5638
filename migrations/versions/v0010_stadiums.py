"""Schema 10: the id of a deleted stadium is never used again."""

from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    options = {"sqlite_autoincrement": True, "sqlite_strict": True}
    with op.batch_alter_table("stadium", recreate="always", table_kwargs=options):
        pass
