"""A catalogue as it is asked: subsets, counts, averages, spectra, and orbits that are looked for."""
