"""Orbits enclosed in ball arithmetic, with proof, if doubles cannot decide."""
