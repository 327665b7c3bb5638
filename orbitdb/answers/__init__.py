"""Answers to questions about a catalogue: functions of a `Moment`, and what they return."""
