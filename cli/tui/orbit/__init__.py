"""One orbit: its drawing, the facts about it, and the values of *a* at which it exists."""
