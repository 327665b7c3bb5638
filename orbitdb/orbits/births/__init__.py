"""Births and deaths: where in *a* words begin and cease to be orbits, with proof that none is missing."""
