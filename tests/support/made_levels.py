"""Levels spaced according to Weyl's law, stored as if they had been computed."""

from pathlib import Path

import numpy as np

from orbitdb import Stadium
from orbitdb.quantum.exact_levels import LevelWindow
from orbitdb.quantum.weyl import Parity, wavenumber, weyl
from orbitdb.store.storing import keep_levels
from orbitdb.store.writer import Writer

WINDOWS = ((0.0, 5.0), (5.0, 9.0), (10.0, 11.0))
"""Windows of k, with a gap between 9 and 10."""


def keep_made_levels(path: Path, a: float = 1.6) -> dict[str, list[float]]:
    """Store levels of each parity in some windows of k; return those below the gap."""
    writer, found = Writer(path, {"command": "levels"}), {}
    for parity in Parity:
        smooth = weyl(Stadium(a), parity)
        k = np.array([wavenumber(smooth, n - 0.5) for n in range(1, 40)])
        for low, high in WINDOWS:
            own = k[(low <= k) & (k < high)]
            keep_levels(writer, LevelWindow(a, parity, low, high, int((k < low).sum()), own, own * 1e-12))
        found[str(parity)] = k[k < WINDOWS[1][1]].tolist()
    writer.close()
    return found
