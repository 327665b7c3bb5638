"""Commands that average over orbits, or compare orbits with quantum levels."""
