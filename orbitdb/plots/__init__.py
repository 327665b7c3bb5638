"""Figures with matplotlib (the extra ``plot``): functions that draw arrays into an Axes."""
