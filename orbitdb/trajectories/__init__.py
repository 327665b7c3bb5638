"""Trajectories: random ones as a reference for averages over orbits, and single ones as symbol sequences."""
