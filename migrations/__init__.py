"""The database schema's history: the Alembic environment and its versions."""
