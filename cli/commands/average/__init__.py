"""Commands that average over orbits."""
