"""The figures of `orbitdb plot`. To add one, add an entry here and a function in one of the modules."""

from dataclasses import dataclass
from typing import Literal

from orbitdb.cli.given_levels import OF_FILE
from orbitdb.cli.options import Choice

Kind = Literal[
    "orbit", "reverse", "life", "entropy", "lyapunov", "sheet", "phase-space", "lengths", "births",
    "spectrum", "staircase", "assess", "spacings", "rigidity", "wave", "husimi", "field",
]  # fmt: skip
_OF_WORD = ("words", "code", "a")
_OF_LEVELS = ("a", "levels", "parity", *OF_FILE)
_OF_WAVE = (*_OF_WORD, "k", "parity")
_OF_SUBSET = ("a", *Choice.__dataclass_fields__)


@dataclass(frozen=True)
class Drawing:
    """A figure: the function that draws it (``module.function``), the options it takes, and what it shows.

    The function gets an orbit, a wave, or subsets at one or several a; then the options in `further`.
    """

    draw: str
    takes: tuple[str, ...]
    shows: str = ""
    further: tuple[str, ...] = ()
    several_a: bool = False


DRAWINGS: dict[Kind, Drawing] = {
    "orbit": Drawing("orbits.draw_orbit", _OF_WORD, "the path of WORD in the stadium (Fig. 1 of the paper)"),
    "reverse": Drawing("orbits.draw_reverse", _OF_WORD, "WORD above its time reverse (Fig. 4)"),
    "life": Drawing(
        "orbits.draw_life", ("words", "code"), "WORD at its birth, with its length and lambda against a"
    ),
    "entropy": Drawing(
        "averages.draw_entropy",
        (*_OF_SUBSET, "over_a"),
        "by period (Fig. 5), or with --over-a its proved bounds against a",
    ),
    "lyapunov": Drawing("averages.draw_lyapunov", _OF_SUBSET, "by period (Fig. 6)", several_a=True),
    "sheet": Drawing(
        "orbits.draw_sheet",
        (*_OF_SUBSET, "order", "limit"),
        "each class of a subset, or each given word (- reads stdin)",
        ("limit", "order", "size"),
    ),
    "phase-space": Drawing("orbits.draw_phase_space", _OF_SUBSET, "the bounces in phase space"),
    "lengths": Drawing(
        "orbits.draw_lengths",
        _OF_SUBSET,
        "the number of orbits up to length L, and their density",
        several_a=True,
    ),
    "births": Drawing(
        "averages.draw_births",
        ("p",),
        "the share of words that are orbits, against a (needs births)",
    ),
    "spectrum": Drawing(
        "levels.draw_length_spectrum",
        _OF_LEVELS,
        "the length spectrum of levels, compared with that of the orbits",
        ("given",),
    ),
    "staircase": Drawing(
        "levels.draw_levels",
        _OF_LEVELS,
        "the number of levels below k, from stored levels and from orbits",
        ("given",),
    ),
    "assess": Drawing(
        "levels.draw_assessment",
        _OF_LEVELS,
        "where levels are missing, according to the orbits",
        ("given",),
    ),
    "spacings": Drawing(
        "levels.draw_spacings", _OF_LEVELS, "the level spacings, in units of the mean spacing", ("given",)
    ),
    "rigidity": Drawing(
        "levels.draw_rigidity",
        _OF_LEVELS,
        "Delta_3 and the number variance, compared with random matrices",
        ("given",),
    ),
    "wave": Drawing(
        "levels.draw_wave", _OF_WAVE, "psi^2 of the level nearest to --k, with the orbit of WORD"
    ),
    "husimi": Drawing(
        "levels.draw_husimi",
        _OF_WAVE,
        "the Husimi function of that level, with the bounces of WORD",
    ),
    "field": Drawing(
        "magnetic.actions_in_field",
        (*_OF_WORD, "kappa"),
        "the actions of WORD and its reverse in a magnetic field, against kappa",
    ),
}
"""All figures by name. The help, the options and the drawing follow from these entries."""

ENTROPY_OVER_A = Drawing("averages.draw_over_a", ("p", "over_a", "a"), further=("grid",), several_a=True)
ORBIT_IN_FIELD = Drawing("magnetic.orbit_in_field", (*_OF_WORD, "kappa"))
SHEET_OF_WORDS = Drawing("orbits.sheet_of", _OF_WORD)
