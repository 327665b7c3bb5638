"""The billiard: its stadium, the legs of its orbits, where they bounce, and how stable they are."""
