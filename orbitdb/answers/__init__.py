"""Answers to questions about a catalogue: functions of a connection, and the objects they return."""
