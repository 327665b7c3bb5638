"""Growth rates of paths in a graph, enclosed: Collatz and Wielandt, rounded outward.

For a matrix A >= 0 and any v > 0 the spectral radius is at most max (Av)_i / v_i; for any v >= 0, v != 0, at
least min (Av)_i / v_i over v_i > 0. The power iteration makes v; the bounds hold for whatever it gives.

Source: Collatz, Math. Z. 48 (1942) 221; Wielandt, Math. Z. 52 (1950) 642.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from orbitdb.billiard.legs import Floats

_ROUNDING = 2.0**-48
"""A row adds at most 9 numbers and is divided: 10 half units of rounding, less than 2^-49."""

MAX_STEPS = 5000
