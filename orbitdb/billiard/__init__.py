"""The stadium billiard: its boundary, the legs of orbits, their bounces and their stability."""

USUAL_A = 1.6
"""The half length that the paper studies, and the default everywhere."""
