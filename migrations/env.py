"""Alembic's environment, which runs on the connection that it gets from `orbitdb.store.file`."""

from alembic import context

context.configure(connection=context.config.attributes["connection"])
with context.begin_transaction():
    context.run_migrations()
