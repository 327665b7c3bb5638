"""What is asked of a catalogue: selections, conditions in SQL, and free expressions, confined."""
