"""Orbits in ball arithmetic: enclosed with proof, for what doubles cannot decide."""
