"""The terminal UI: look at orbits, choose subsets, compute."""
