"""The database file: its schema, safe access, migrations."""
