"""Answers to questions about a catalogue: functions that take a `Moment`, and the objects they return."""
