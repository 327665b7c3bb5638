"""Filling a catalogue: periods or single words, here, in processes or on a cluster."""
