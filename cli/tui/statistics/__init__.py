"""The statistics of the chosen subset: averages and counts, each on a screen of its own."""
