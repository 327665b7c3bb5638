"""Reading a catalogue."""
