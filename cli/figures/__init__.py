"""The figures of the command `plot`."""
