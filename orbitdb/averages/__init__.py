"""Averages over orbits: entropies and Lyapunov exponents, from arrays."""
