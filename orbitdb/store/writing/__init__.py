"""Write to a catalogue."""
