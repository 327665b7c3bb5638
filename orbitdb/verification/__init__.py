"""Verify a catalogue: recompute all its contents from the words, compare, and prove."""
