"""orbitdb: a certified catalogue of the unstable periodic orbits of the stadium billiard."""
