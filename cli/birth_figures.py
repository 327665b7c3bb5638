"""The figure of births and deaths, from what the catalogue holds of them."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.errors import InputError
from orbitdb.plots import births
from orbitdb.plots.style import figure
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.catalogue import Catalogue

_MOST = 4
"""Periods drawn, the highest ones."""
_PLACES = 400
_LOW, _WIDER = 0.02, 1.5
_GEOMETRIC = 1.218756
"""The entropy of the geometric rules alone, ln of the inverse root of z^3 + z^2 + 3 z = 1."""


def draw_births(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw over a the share of words that are orbits, the entropy, and where orbits are born."""
    whole = [each.p for each in catalogue.birth_fills() if each.whole]
    periods = [p for p in whole if chosen.includes(p)]
    places = {p: _births(catalogue, p) for p in whole if p <= max(periods, default=0)}
    shown = [p for p in periods if len(places[p].a) > 1][-_MOST:]
    if not shown:
        raise InputError("no births to draw: 'orbitdb births --p 11' finds them")
    a = np.geomspace(_LOW, _WIDER * max(places[p].a[-1] for p in shown), _PLACES)
    entropies = {
        p: _entropies(places, p, a) for p in shown[-2:] if [*range(2, p + 1)] == [q for q in whole if q <= p]
    }
    with figure(6.4, 7.6) as made:
        above, middle, below = made.subplots(3, 1, sharex=True)
        births.draw_shares(above, {p: places[p] for p in shown}, a)
        births.draw_entropies(middle, entropies, a, _GEOMETRIC)
        births.draw_changes(below, {p: places[p].a[places[p].a > 0] for p in shown[-2:]}, a)
        below.set_xlabel("$a$")
    return made


def _births(catalogue: Catalogue, p: int) -> births.Steps:
    """Return how many words of a period are orbits, step by step."""
    lives = catalogue.births(p)
    ended = [life for life in lives if life.dies is not None]
    born, died = (np.array([life.class_size for life in some], dtype=np.int64) for some in (lives, ended))
    births_at = np.array([life.born for life in lives])
    return births.Steps.of(births_at, np.array([life.dies for life in ended], dtype=float), born, died)


def _entropies(places: dict[int, births.Steps], highest: int, a: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the entropy from the zeta function to one period at each a; NaN where it has no usable zero."""
    counts = np.zeros((len(a), highest + 1), dtype=np.int64)
    for p in range(2, highest + 1):
        counts[:, p] = places[p].at(a)
    return np.array([entropy_of_counts(row).h_zeta[-1] for row in counts])


def entropies_from_births(
    catalogue: Catalogue, chosen: Selection, a: NDArray[np.float64]
) -> dict[int, NDArray[np.float64]]:
    """Return by period, for the highest chosen one without a gap below it, the entropy at each a.

    Empty if no births are stored.
    """
    whole = [each.p for each in catalogue.birth_fills() if each.whole]
    periods = [p for p in whole if chosen.includes(p) and [*range(2, p + 1)] == [q for q in whole if q <= p]]
    if not periods:
        return {}
    highest = max(periods)
    places = {p: _births(catalogue, p) for p in range(2, highest + 1)}
    return {highest: _entropies(places, highest, a)}
