"""Benchmarks: run time against error, run times of the stages, stress tests, and agreement of methods."""
