"""Read a catalogue."""
