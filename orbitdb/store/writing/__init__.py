"""Writing into a catalogue."""
