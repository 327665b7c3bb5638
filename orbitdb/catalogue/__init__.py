"""`Catalogue` and what it gives: subsets, counts, averages, spectra, and orbits by trajectory or length."""
