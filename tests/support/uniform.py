"""Whether numbers are spread evenly over a range."""

import math

import numpy as np


def is_uniform(values: np.ndarray, low: float, high: float) -> bool:
    """Kolmogorov's and Smirnov's test at the level 1e-3, for many values."""
    shares = np.sort((values - low) / (high - low))
    count = len(shares)
    distance = np.abs(shares - (np.arange(count) + 0.5) / count).max() + 0.5 / count
    return bool(distance < math.sqrt(math.log(2 / 1e-3) / 2 / count))
