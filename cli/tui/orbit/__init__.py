"""One orbit: its drawing, what is known of it, and where in *a* it exists."""
