"""Orbits: from words to solutions, with error bounds and proofs."""
