"""Benchmarks: run time against error, stages of a fill, stress, and the agreement of methods."""
