"""orbitdb: a certified catalogue of the unstable periodic orbits of the stadium billiard."""

__version__ = "0.1.0"
