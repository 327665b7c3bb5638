"""Orbits in a magnetic field: their action, how they are followed from kappa = 0, and which of them exist."""
