"""Figures of orbits in a magnetic field."""

from orbitdb.plots.magnetic import actions_in_field, orbit_in_field

__all__ = ["actions_in_field", "orbit_in_field"]
