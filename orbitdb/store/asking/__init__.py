"""Describe a subset of a catalogue: selections, SQL conditions, and SQL that users write."""
