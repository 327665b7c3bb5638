"""The database file: its schema, safe access to it, and migrations."""
