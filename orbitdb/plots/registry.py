"""The registry of figures: what each one shows, what it is drawn from, and what it takes and needs.

To add a figure, add an entry to `FIGURES`. `orbitdb plot`, its help and its options follow from it, and so do
the names that `Catalogue.plot` and ``.plot("name")`` of a result know.

This module does not import matplotlib.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from orbitdb.errors import InputError
from orbitdb.text import guess

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.selection import Selection

Source = Literal["orbit", "orbits", "word", "wave", "opening", "catalogue", "object"]
"""What a figure is drawn from.

``orbit``, ``orbits`` and ``wave`` figures get orbits, or the wave of a level and perhaps an orbit; ``word``
figures get a word, which need not be an orbit, and a; ``opening`` figures get what escapes;
``catalogue`` figures get a catalogue and a selection, or several of them; those of an ``object`` are drawn
only by the ``.plot()`` of an object.
"""

WORD = ("words", "code", "a")
SUBSET = "subset"
"""Stands for the options that choose a subset of the catalogue."""
LEAST_INCHES, MOST_INCHES = 1, 100
SIZES = f"a width of {LEAST_INCHES} to {MOST_INCHES} inches, and perhaps a height"
LEVELS = ("a", "levels", "parity", "energies", "frequency", "radius", "window")


@dataclass(frozen=True)
class Figure:
    """A figure, or a variant of one.

    Attributes
    ----------
    name : str
        Its name, in which hyphens, underscores and blanks are the same.
    shows : str
        What it shows, in a line of the help.
    whole, axes : str
        The functions in `orbitdb.plots` that draw the whole figure, and on given axes, as
        ``module.function``, or an empty string.
    source : str
        What the first arguments of `whole` are (`Source`).
    takes : tuple of str
        Options of `orbitdb plot`, apart from those for the file.
    passes : tuple of str
        Options that `whole` gets as keyword arguments.
    needs : str
        What the catalogue must hold, unless orbits are enough.
    several_a : bool
        Whether the figure can compare several values of a.
    status : str
        Status of the words of a subset, if none is asked for.
    when : tuple of str
        Options that ask for this variant; empty for the figure itself.
    """

    name: str
    shows: str = ""
    whole: str = ""
    axes: str = ""
    source: Source = "catalogue"
    takes: tuple[str, ...] = ()
    passes: tuple[str, ...] = ()
    needs: str = ""
    several_a: bool = False
    status: str = "orbit"
    when: tuple[str, ...] = ()


FIGURES: list[Figure] = [
    Figure(
        "orbit", "the path of WORD in the stadium (Fig. 1 of the paper)",
        "orbits.orbit", "paths.draw_orbit", source="orbit", takes=(*WORD, "opening"), passes=("opening",),
    ),
    Figure(
        "orbit", whole="magnetic.orbit_in_field", source="word", takes=(*WORD, "kappa"), passes=("kappa",),
        when=("kappa",),
    ),
    Figure("reverse", "WORD above its time reverse (Fig. 4)", "orbits.reverse", source="orbit", takes=WORD),
    Figure(
        "life", "WORD at its birth, with its length and lambda against a",
        "over_a.life", source="orbit", takes=("words", "code"),
    ),
    Figure(
        "entropy", "by period (Fig. 5), or with --over-a its proved bounds against a",
        "averages.entropy", "averages.draw_entropy", takes=("a", SUBSET, "over_a"),
    ),
    Figure(
        "entropy", whole="over_a.entropy_over_a", takes=("p", "over_a", "a"), passes=("grid",),
        needs="proved bounds", several_a=True, when=("over_a",),
    ),
    Figure(
        "lyapunov", "by period (Fig. 6)",
        "averages.lyapunov", "averages.draw_exponent", takes=("a", SUBSET), several_a=True,
    ),
    Figure(
        "sheet", "each class of a subset, or each given word (- reads stdin)",
        "orbits.sheet", "paths.draw_sheet", takes=("a", SUBSET, "order", "limit"),
        passes=("limit", "order"),
    ),
    Figure(
        "sheet", whole="orbits.sheet_of", source="orbits", takes=WORD,
        when=("words", "code"),
    ),
    Figure(
        "phase-space", "the bounces in phase space",
        "phase_space.phase_space", "phase_space.draw_phase_space", takes=("a", SUBSET),
    ),
    Figure(
        "lengths", "the number of orbits up to length L, and their density",
        "lengths.lengths", "lengths.draw_lengths", takes=("a", SUBSET), several_a=True,
    ),
    Figure(
        "symbol-plane", "the future and past of each bounce, and the pruning front",
        "symbol_plane.symbol_plane", "symbol_plane.draw_plane", takes=("a", SUBSET), several_a=True,
        status="orbit,dynamical",
    ),
    Figure(
        "births", "the share of words that are orbits, against a",
        "over_a.births", "over_a.draw_births", takes=("p",), needs="births",
    ),
    Figure(
        "spectrum", "the length spectrum of levels, compared with that of the orbits",
        "length_spectrum.spectrum", "length_spectrum.draw_spectrum",
        takes=(*LEVELS, "lengths", "k"), passes=("levels", "parity", "window", "lengths", "k"),
    ),
    Figure(
        "staircase", "the number of levels below k minus Weyl's law, from levels and from orbits",
        "staircase.staircase", "staircase.draw_staircase",
        takes=LEVELS, passes=("levels", "parity", "window"), needs="levels",
    ),
    Figure(
        "assess", "where levels are missing, according to the orbits",
        "assess.assess", "assess.draw_assess", takes=LEVELS, passes=("levels", "parity", "window"),
        needs="levels",
    ),
    Figure(
        "spacings", "the level spacings, in units of the mean spacing",
        "statistics.spacings", "statistics.draw_spacings", takes=LEVELS, passes=("parts",), needs="levels",
    ),
    Figure(
        "rigidity", "Delta_3 and the number variance, compared with random matrices",
        "statistics.rigidity", "statistics.draw_rigidity", takes=LEVELS, passes=("parts", "window"),
        needs="levels",
    ),
    Figure(
        "wave", "psi^2 of the level nearest to --k, with the orbit of WORD",
        "waves.wave", "waves.draw_wave", source="wave", takes=(*WORD, "k", "parity"),
    ),
    Figure(
        "husimi", "the Husimi function of that level, with the bounces of WORD",
        "waves.husimi", "waves.draw_husimi", source="wave", takes=(*WORD, "k", "parity"),
    ),
    Figure(
        "field", "the actions of WORD and its reverse in a magnetic field, against kappa",
        "magnetic.actions_in_field", "magnetic.draw_actions", source="word", takes=(*WORD, "kappa"),
        passes=("kappa",),
    ),
    Figure(
        "escape", "survival in an open stadium, against bounces and time (--opening, --without)",
        "escape.escape", "escape.draw_escape", source="opening", takes=("a", "opening", "without"),
    ),
    Figure("escape-time", axes="escape.draw_escape_time", source="object"),
    Figure("path", axes="paths.draw_path", source="object"),
]  # fmt: skip
"""All figures, in the order of the help; the variants of a figure come after it."""

NAMES = tuple(figure.name for figure in FIGURES if figure.whole and not figure.when)
"""The figures that `orbitdb plot` draws."""


class EmptyFigureError(InputError):
    """There is nothing to draw; each line says what is missing, and perhaps the command that makes it.

    Attributes
    ----------
    lines : tuple of str
    """

    def __init__(self, lines: Iterable[str]) -> None:
        self.lines = tuple(lines)
        super().__init__("; ".join(self.lines))


def gaps(catalogue: "Catalogue", chosen: "Selection", order: str = "p") -> list[str]:
    """Return one line for each kind of gap in a chosen subset."""
    return [*catalogue.rows(chosen, columns=("code",), order=order).notes]


def nothing(catalogue: "Catalogue", chosen: "Selection") -> EmptyFigureError:
    """Return the error for a subset without anything to draw."""
    listing = catalogue.rows(chosen, columns=("code",))
    absent = listing.absent
    lines = [line for line in listing.notes if line not in absent]
    return EmptyFigureError([*lines, *(f"{line}: nothing to draw" for line in absent)])


def plain_name(name: str) -> str:
    """Return a name as the registry writes it, with hyphens."""
    return name.strip().lower().replace("_", "-").replace(" ", "-")


def figure_of(name: str, given: Collection[str] = ()) -> Figure:
    """Return the figure with a name, or its variant for the given options."""
    own = [figure for figure in FIGURES if figure.name == plain_name(name)]
    return next((figure for figure in own if not {*figure.when}.isdisjoint(given)), own[0])


def whole_figure(name: str, given: Collection[str] = ()) -> Figure:
    """Return the figure that `orbitdb plot` draws under a name, or its variant for the given options."""
    if (asked := plain_name(str(name))) not in NAMES:
        raise InputError(f"figure {name!r:.40}: {guess(asked, NAMES)}use one of {', '.join(NAMES)}")
    return figure_of(asked, given)


def chosen_name(kind: str | None, own: Sequence[str]) -> str:
    """Return the figure of `own` with this name, by default the first.

    Raises
    ------
    InputError
        If no figure of `own` has this name.
    """
    if kind is None:
        return own[0]
    asked = plain_name(str(kind))
    for name in own:
        if asked == plain_name(name):
            return name
    known = any(figure.name == asked for figure in FIGURES)
    elsewhere = f"; {asked} is a figure of another result" if known else ""
    raise InputError(f"kind {kind!r:.40}: use {', '.join(own)}{elsewhere}")


def load_function(path: str) -> Callable[..., Any]:
    """Import a function of `orbitdb.plots`, given as ``module.function``."""
    module, name = path.split(".")
    found: Callable[..., Any] = getattr(import_module(f"orbitdb.plots.{module}"), name)
    return found
