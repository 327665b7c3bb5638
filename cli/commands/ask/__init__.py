"""Commands that ask for single orbits, or rows of the catalogue."""
