"""Figures over a: births and deaths of all that the catalogue holds, and the entropy."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.entropy.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.plots import births
from orbitdb.plots.style import explain, figure
from orbitdb.store.asking.selection import Selection

_MOST = 4
"""Periods drawn, the highest ones."""
PLACES = 400
PLACES_OF_BOUNDS, _ROOM = 200, 1.1
_LOW, _WIDER = 0.02, 1.5


def draw_births(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw over a the share of words that are orbits, the entropy, and where orbits are born."""
    steps = _steps(catalogue, chosen)
    shown = [p for p in steps if chosen.includes(p) and steps[p].a[-1] > 0][-_MOST:]
    if not shown:
        raise InputError("no births to draw: 'orbitdb births --p 11' finds them")
    a = np.geomspace(_LOW, _WIDER * max(steps[p].a[-1] for p in shown), PLACES)
    entropies = {p: _entropies(steps, p, a) for p in shown[-2:] if _gapless(steps, p)}
    with figure(6.4, 7.6) as made:
        above, middle, below = made.subplots(3, 1, sharex=True)
        births.draw_shares(above, {p: steps[p] for p in shown}, a)
        births.draw_entropies(middle, entropies, a, geometric_entropy())
        births.draw_changes(below, {p: steps[p].a[steps[p].a > 0] for p in shown[-2:]}, a)
        below.set_xlabel("$a$")
        made.set_label("births and deaths of orbits")
    return made


def _steps(catalogue: Catalogue, chosen: Selection) -> dict[int, births.Steps]:
    """Return how many words are orbits, step by step, of whole periods up to the highest that is chosen."""
    whole = [each.p for each in catalogue.birth_fills() if each.whole]
    highest = max((p for p in whole if chosen.includes(p)), default=0)
    return {p: _of_period(catalogue, p) for p in whole if p <= highest}


def _of_period(catalogue: Catalogue, p: int) -> births.Steps:
    lives = catalogue.births(p)
    ended = [life for life in lives if life.dies is not None]
    born, died = (np.array([life.class_size for life in some], dtype=np.int64) for some in (lives, ended))
    births_at = np.array([life.born for life in lives])
    return births.Steps.of(births_at, np.array([life.dies for life in ended], dtype=float), born, died)


def _gapless(steps: dict[int, births.Steps], highest: int) -> bool:
    return all(p in steps for p in range(2, highest + 1))


def _entropies(steps: dict[int, births.Steps], highest: int, a: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the entropy from the zeta function to one period at each a; NaN where it has no usable zero."""
    counts = np.zeros((len(a), highest + 1), dtype=np.int64)
    for p in range(2, highest + 1):
        counts[:, p] = steps[p].at(a)
    return np.array([entropy_of_counts(row).h_zeta[-1] for row in counts])


def draw_over_a(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the proved bounds at every a that has some, and the entropy from births where these are filled."""
    known = catalogue.entropy_curve()
    if not known:
        raise InputError("no proved bounds to draw: 'orbitdb bounds --a 0.3:10:40' finds them")
    a, lower, upper = (np.array([getattr(each, name) for each in known]) for name in ("a", "lower", "upper"))
    places = np.geomspace(a[0] / _ROOM, a[-1] * _ROOM, PLACES_OF_BOUNDS)
    steps = _steps(catalogue, chosen)
    highest = [p for p in steps if chosen.includes(p) and _gapless(steps, p)][-1:]
    curves = {p: (places, _entropies(steps, p, places)) for p in highest}
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        made.set_label("topological entropy over a")
        births.draw_entropy_over_a(ax, a, lower, upper, curves, geometric_entropy())
        explain(made, ax)
    return made
