"""Fill a catalogue with periods or single words, in one process, in several processes or on a cluster."""
