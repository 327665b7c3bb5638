"""Births and deaths: the *a* at which words begin and cease to be orbits, proved to be complete."""
