"""Fill a catalogue with periods or single words, in one process, in several or on a cluster."""
