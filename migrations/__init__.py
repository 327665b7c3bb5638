"""The history of the database schema: the Alembic environment and one migration for each version."""
