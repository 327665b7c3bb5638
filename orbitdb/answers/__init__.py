"""Answers to questions about a catalogue: functions that take a `Connection`, and the objects they return."""
