"""The billiard: its stadium, the legs of its orbits, where they bounce, and how stable they are."""

USUAL_A = 1.6
"""The half length that the paper studies, and the default everywhere."""
