"""The catalogue on disk: its file and schema, questions as SQL, reading and writing."""
