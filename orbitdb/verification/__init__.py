"""Verifying a catalogue: all that it holds computed again from the words, compared, and proved."""
