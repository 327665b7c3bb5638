"""Benchmarks: run time against error, stages of a fill, stress tests, and the agreement of methods."""
