"""Describe a subset of a catalogue: selections, SQL conditions, and SQL expressions within limits."""
