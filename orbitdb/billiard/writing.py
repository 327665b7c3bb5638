"""From points on the boundary to the symbols and coordinates of the catalogue."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium

Floats = NDArray[np.float64]


def written(stadium: Stadium, x: Floats, y: Floats, side: Floats) -> tuple[NDArray[np.uint8], Floats]:
    """Write bounces in the symbols and coordinates of the catalogue, but the first and the last of each row.

    Parameters
    ----------
    stadium : Stadium
    x, y, side : ndarray, shape (N, p + 2)
        The points, and where they are: side -1 left semicircle, +1 right semicircle, 0 a straight wall,
        where y is -1 or 1.

    Returns
    -------
    symbols : ndarray of uint8, shape (N, p)
    coordinates : ndarray, shape (N, p)
    """
    coordinates = np.where(side == 0, x, np.arctan2(y, side * x - stadium.a))
    same = (side[:, 1:] == side[:, :-1]) & (side[:, 1:] != 0)
    falls = same & (coordinates[:, 1:] < coordinates[:, :-1])
    down = falls[:, 1:] | falls[:, :-1]
    here, height = side[:, 1:-1], y[:, 1:-1]
    curved = np.where(here < 0, 1 + 3 * down, 3 + 2 * down)
    return np.where(here == 0, 1 + height, curved).astype(np.uint8), coordinates[:, 1:-1]
