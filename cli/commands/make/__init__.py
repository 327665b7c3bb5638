"""Commands that make data: orbits, births, sums, trajectories, bounds and levels."""
