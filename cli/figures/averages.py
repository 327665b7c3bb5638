"""Figures of averages by period: the topological entropy and the Lyapunov exponents."""

from dataclasses import replace

import typer
from matplotlib.figure import Figure

from orbitdb.answers.entropy import entropy
from orbitdb.answers.lyapunov import EXPONENTS, lyapunov
from orbitdb.answers.results import Result
from orbitdb.cli.render import note
from orbitdb.plots import curves
from orbitdb.plots.style import figure
from orbitdb.store.asking.selection import Selection, joined_spans
from orbitdb.store.reading.moment import Moment

NOTHING = ": nothing to draw"


def draw_entropy(moment: Moment, chosen: Selection) -> Figure:
    """Draw K_0 and h_zeta by period, as in Fig. 5 of the paper, with the proved bounds."""
    found = entropy(moment, chosen)
    with figure(6.4, 4.2, _title(found, chosen)) as made:
        curves.draw_entropy(made.add_subplot(), found)
    return made


def draw_lyapunov(moment: Moment, chosen: Selection) -> Figure:
    """Draw the Lyapunov exponents by period from every method, as in Fig. 6 of the paper."""
    found = lyapunov(moment, chosen)
    with figure(6.4, 6.4, _title(found, chosen)) as made:
        axes = made.subplots(2, 1, sharex=True)
        for ax, name in zip(axes, EXPONENTS, strict=True):
            curves.draw_exponent(ax, found, name)
        axes[0].set(xlabel="")
    return made


def _title(found: Result, chosen: Selection) -> str:
    """Print the notes of a result, and return a title with its periods; exit if there is nothing to draw."""
    for text in found.notes:
        note(text if len(found) else f"{text}{NOTHING}")
    if not len(found):
        raise typer.Exit(1)
    spans = joined_spans([(p, p) for p in found["p"]])
    drawn = replace(chosen, periods=tuple(spans)) if chosen.periods else chosen
    return drawn.describe()
