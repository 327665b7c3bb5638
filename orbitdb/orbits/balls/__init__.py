"""Orbits enclosed in ball arithmetic, with proof, for words that doubles cannot decide."""
