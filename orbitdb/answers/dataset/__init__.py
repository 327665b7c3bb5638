"""A catalogue as a dataset: a folder of tables for any tool, described by the Frictionless standard."""
