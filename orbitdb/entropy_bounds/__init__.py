"""Proved bounds on the topological entropy, from edge words, windows, their verdicts, and growth rates."""
