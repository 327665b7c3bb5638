"""The figure of the topological entropy over a, from what the catalogue holds of it."""

import numpy as np
from matplotlib.figure import Figure

from orbitdb.cli.birth_figures import entropies_from_births
from orbitdb.entropy.letters import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.plots.enclosures import draw_entropy_over_a
from orbitdb.plots.style import explain, figure
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.catalogue import Catalogue

_PLACES = 200
_ROOM = 1.1


def draw_over_a(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the proved bounds at every a that has some, and the entropy from births where these are filled.

    Raises
    ------
    InputError
        If there are no bounds.
    """
    known = catalogue.entropy_curve()
    if not known:
        raise InputError("no proved bounds to draw: 'orbitdb bounds --a 0.3:10:40' finds them")
    a, lower, upper = (np.array([getattr(each, name) for each in known]) for name in ("a", "lower", "upper"))
    places = np.geomspace(a[0] / _ROOM, a[-1] * _ROOM, _PLACES)
    curves = {p: (places, found) for p, found in entropies_from_births(catalogue, chosen, places).items()}
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        draw_entropy_over_a(ax, a, lower, upper, curves, geometric_entropy())
        explain(made, ax)
    return made
