"""Style and output of figures: colours for the colour-blind, sizes for print, and no need for a display."""

import re
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.textpath import TextPath

from orbitdb.arrays import Floats
from orbitdb.symbols.words import run_notation
from orbitdb.text import shortened

BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
"""Colours of Okabe and Ito. Curves that differ in colour also differ in shape or line style."""
INK, GREY, FAINT = "#333333", "#777777", "#bbbbbb"
SMALL = 7
"""Size of the smallest text, in points: still legible in print."""
INKS = {"one": BLUE, "two": ORANGE, "three": GREEN, "four": PURPLE, "five": INK, "six": GREY}
"""The colour of each ink; the screen uses the same names of inks."""

_KEPT = "\N{NO-BREAK SPACE}"

_LINE, _BESIDE = 0.17, 0.2
"""Height of a line of the title, and the sum of the margins on its left and right, in inches."""

_LOOK: Any = {
    "font.size": 10,
    "axes.labelsize": 11,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "text.usetex": False,  # all formulas are matplotlib's own, so that no figure needs LaTeX
    "mathtext.fontset": "dejavusans",
    "pdf.fonttype": 42,
    "savefig.bbox": None,  # or a figure would not have the size that was asked for
    "svg.hashsalt": "orbitdb",
    "svg.fonttype": "none",  # text stays text
}


_VARIABLES = {"a": "a", "k": "k", "p": "p", "kappa": r"\\kappa"}
"""Variables in titles, and how a formula writes them."""

NARROW = 4.5
"""Narrower figures, in inches, have smaller text: one column of a journal is 3.4 inches (8.6 cm) wide."""
_LOOK_NARROW: Any = _LOOK | {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": SMALL,
    "legend.handlelength": 1.5,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.5,
}

Size = tuple[float, float | None]
"""Width and height of a figure in inches; without a height, the figure chooses one that suits the width."""

_size: ContextVar[Size | None] = ContextVar("size", default=None)


@contextmanager
def sized(size: Size | None) -> Iterator[None]:
    """Give every figure that is made within the context a size, or only a width, unless it is None."""
    token = _size.set(size)
    try:
        yield
    finally:
        _size.reset(token)


def width_or(usual: float) -> float:
    """Return the width, in inches, that `sized` asks for, or else the usual one."""
    asked = _size.get()
    return asked[0] if asked else usual


@contextmanager
def look(width: float = 6.4) -> Iterator[None]:
    """Set the style of figures of a width, in inches, for everything drawn within the context."""
    with rc_context(_LOOK if width >= NARROW else _LOOK_NARROW):
        yield


def inches_wide(ax: Axes) -> float:
    """Return the width of axes in inches."""
    return ax.get_window_extent().width / ax.figure.dpi


def closed(points: Floats) -> Floats:
    """Return the points of a closed path, shape (p, 2), with the first one again at the end."""
    return np.concatenate([points, points[:1]])


class Colours(NamedTuple):
    """What was drawn in colours that stand for numbers, and the name of the number."""

    drawn: ScalarMappable
    name: str

    def add_bar(self, ax: Axes, extend: str = "neither") -> None:
        """Add a bar beside the axes, of the same height, that explains the colours."""
        bar = ax.inset_axes((1.02, 0, 0.025, 1))
        ax.figure.colorbar(self.drawn, cax=bar, label=self.name, extend=extend)


class Picture(Figure):
    """A whole figure, with notes on what it leaves out.

    Attributes
    ----------
    notes : tuple of str
        What is to be said beside the figure, one line each.
    """

    notes: tuple[str, ...] = ()

    def _repr_png_(self) -> bytes:
        """Show the figure in a notebook that has not imported pyplot."""
        return as_bytes(self, "png", str(self.get_label()))


@contextmanager
def figure(width: float, height: float, title: str = "", notes: Iterable[str] = ()) -> Iterator[Picture]:
    """Create a figure of the given size in inches; whatever is drawn within the context has our style.

    `sized` replaces the size, or only the width: the height then changes by the square root of the same
    factor, because texts do not shrink with the width. The title also becomes the figure's label; each line
    after the first adds to the height. Axes without a legend of their own share a legend below them, where
    it covers no points.
    """
    usual, width = width, width_or(width)
    with look(width):
        lines = wrapped(title, width)
        suited = height * (width / usual) ** 0.5 + _LINE * lines.count("\n")
        _, asked = _size.get() or (width, None)
        made = Picture(figsize=(width, asked or suited), layout="constrained", label=title)
        made.notes = tuple(notes)
        if title:
            made.suptitle(titled(lines), fontsize=rcParams["axes.titlesize"])
        yield made
        bare = [ax.get_legend_handles_labels() for ax in made.axes if ax.get_legend() is None]
        named = {label: handle for pair in bare for handle, label in zip(*pair, strict=True)}
        for columns in (2, 1) if named else ():
            legend = made.legend(named.values(), named.keys(), loc="outside lower center", ncols=columns)
            if columns == 1 or legend.get_window_extent().width <= made.bbox.width:
                break
            legend.remove()


def wrapped(text: str, width: float) -> str:
    """Wrap a title into at most three lines, each at most `width` inches wide; keep ``a = 1.6`` together."""
    text = re.sub(r" ([=±]) |(?<=\bP) ", lambda blank: blank[0].replace(" ", _KEPT), text)
    size = rcParams["axes.titlesize"]
    if not isinstance(size, int | float):
        size = _LOOK["axes.titlesize"]  # outside our style
    room = 72 * (width - _BESIDE)
    for length in range(max(int(room / (0.4 * size)), 1), 0, -1):
        lines = textwrap.wrap(text, length, max_lines=3, placeholder=" ...")
        if all(TextPath((0, 0), plain(line), size=size).get_extents().width <= room for line in lines):
            break
    return plain("\n".join(lines).replace(_KEPT, " "))


def titled(text: str) -> str:
    """Return a title in sentence case, with its variables as formulas: ``a = 1.6`` becomes ``$a = 1.6$``."""
    for name, symbol in _VARIABLES.items():
        text = re.sub(rf"\b{name} = (-?[0-9.]*[0-9])(?![0-9.e])", rf"${symbol} = \1$", text)
        text = re.sub(rf"\b{name} (?=below|from)", f"${symbol}$ ", text)
    return text[:1].upper() + text[1:]


def short(code: str, most: int = 30) -> str:
    """Return a code as a label; a long code is written in run notation and, if necessary, shortened."""
    return code if len(code) <= most else shortened(run_notation(code), most)


def plain(text: str) -> str:
    """Escape the dollars and the letters beyond Latin-1 of a text, so that matplotlib draws it literally."""
    return text.encode("latin-1", "backslashreplace").decode("latin-1").replace("$", r"\$")


def entitle(made: Figure, title: str) -> None:
    """Change the title of a figure."""
    with look(made.get_figwidth()):
        lines = wrapped(title, made.get_figwidth())
        if made.get_suptitle() or not made.axes or not made.axes[0].get_title():
            made.suptitle(lines, fontsize=rcParams["axes.titlesize"])
        else:
            made.axes[0].set_title(lines)


def save(made: Figure, path: Path, ending: str, description: str, dpi: int = 200) -> None:
    """Write a figure and a description of its content to a file; the same figure gives the same bytes."""
    path.write_bytes(as_bytes(made, ending, description, dpi))


def as_bytes(made: Figure, ending: str, description: str, dpi: int = 200) -> bytes:
    """Return the bytes that `save` writes to a file."""
    notes = {
        "png": {"Description": description},
        "svg": {"Title": description, "Date": None},
        "pdf": {"Title": description, "CreationDate": None},
    }
    drawn = BytesIO()  # not the file itself: matplotlib fails obscurely if the disk is full
    with look():
        made.savefig(drawn, format=ending, dpi=dpi, metadata=notes[ending])
    return drawn.getvalue()
