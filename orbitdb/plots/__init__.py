"""Figures with matplotlib (the extra ``plot``): functions that draw results and arrays on given axes."""
