"""Verify a catalogue: recompute everything from the words, compare, and prove."""
