"""Benchmarks: run time against error, and hard cases."""
