"""The figures of levels, from what the catalogue holds."""

import numpy as np
from matplotlib.figure import Figure

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.spectrum import read_classes, read_levels
from orbitdb.cli.figures.orbits import short
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.plots.quantum import draw_level_count, draw_spectrum
from orbitdb.plots.style import entitle, explain, figure
from orbitdb.quantum.amplitudes import orbit_terms, weyl
from orbitdb.quantum.lengths import counted, family_count
from orbitdb.store.asking.selection import Selection

_LENGTHS = (1.0, 12.0)
_PLACES = 2000
_LONGEST = 12.0


def draw_length_spectrum(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the length spectrum of the orbits, and that of the levels if there are any."""
    found = catalogue.spectrum(_LENGTHS, points=1000, a=chosen.a)
    for said in found.notes():
        note(said)
    with figure(7.2, 4.8) as made:
        ax = made.add_subplot()
        draw_spectrum(ax, found, short)
        entitle(made, f"length spectrum at a = {chosen.a:g}, k below {found.k_max:.4g}")
        explain(made, ax)
    return made


def draw_levels(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the number of levels, and its fluctuations beside those that the orbits give.

    Raises
    ------
    InputError
        If there are no levels.
    """
    known = read_levels(catalogue, chosen.a, None)
    if known is None:
        raise InputError(f"no levels to draw: 'orbitdb levels --k 0:30 --a {chosen.a:g}' finds them")
    k, end = known
    at, stadium = np.linspace(0.5, end, _PLACES), Stadium(chosen.a)
    classes, _, highest = read_classes(catalogue, chosen)
    smooth, family = weyl(stadium, None)(at), family_count(stadium, at, _LONGEST)
    orbits = counted(orbit_terms(classes, _LONGEST), at)
    note(f"orbits and bouncing balls of lengths up to {_LONGEST:g}: a partial sum")
    with figure(7.2, 6.0) as made:
        above, below = made.subplots(2, 1, sharex=True)
        draw_level_count(above, below, k, at, smooth, family, orbits, highest)
        entitle(made, f"{len(k)} levels at a = {chosen.a:g}, k below {end:.4g}")
        explain(made, above, below)
    return made
