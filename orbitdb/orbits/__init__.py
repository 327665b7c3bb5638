"""Orbits: from words to solutions, with bounds and proofs."""
