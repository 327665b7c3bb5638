"""Random trajectories: the reference for averages over orbits."""
