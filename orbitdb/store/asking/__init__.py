"""Questions to a catalogue: selections, conditions in SQL, and confined SQL expressions."""
