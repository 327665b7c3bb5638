"""The terminal UI: look at orbits, choose subsets, fill the catalogue, and see statistics."""
