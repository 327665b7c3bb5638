"""Commands that ask for single orbits or for rows of the catalogue."""
