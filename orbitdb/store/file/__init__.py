"""The database file: its schema, opening it safely, migrations."""
