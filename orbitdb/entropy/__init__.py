"""Proved bounds on the topological entropy: edge words, windows, their verdicts, and growth rates."""
