"""Figures of the commands. A new one is an entry here and a function in one of the modules."""

from dataclasses import dataclass
from typing import Literal

from orbitdb.cli.choice import Choice

Kind = Literal[
    "orbit", "reverse", "life", "entropy", "lyapunov", "sheet", "phase-space", "lengths", "births",
    "spectrum", "staircase", "assess", "spacings", "rigidity", "wave", "husimi",
]  # fmt: skip
OF_WORD = ("words", "code", "a")
_OF_LEVELS = ("a", "levels", "energies", "parity")
OF_WAVE = (*OF_WORD, "k", "parity")
_OF_SUBSET = ("a", *Choice.__dataclass_fields__)


@dataclass(frozen=True)
class Drawing:
    """A figure: its function in a module here, the options it takes, and what it shows."""

    draw: str
    takes: tuple[str, ...]
    shows: str


DRAWINGS: dict[Kind, Drawing] = {
    "orbit": Drawing("orbits.draw_orbit", OF_WORD, "the path of WORD in the stadium (Fig. 1 of the paper)"),
    "reverse": Drawing("orbits.draw_reverse", OF_WORD, "WORD above its time reverse (Fig. 4)"),
    "life": Drawing(
        "orbits.draw_life", ("words", "code"), "WORD at its birth, its length and its lambda for every a"
    ),
    "entropy": Drawing(
        "averages.draw_entropy",
        (*_OF_SUBSET, "over_a"),
        "by period (Fig. 5); with --over-a the proved bounds for every a",
    ),
    "lyapunov": Drawing("averages.draw_lyapunov", _OF_SUBSET, "by period (Fig. 6)"),
    "sheet": Drawing(
        "subsets.draw_sheet",
        (*_OF_SUBSET, "words", "code", "order", "limit"),
        "the classes of a subset, or words (- reads stdin), each by itself",
    ),
    "phase-space": Drawing("subsets.draw_phase_space", _OF_SUBSET, "the bounces in phase space"),
    "lengths": Drawing(
        "subsets.draw_lengths", _OF_SUBSET, "how many orbits are no longer than L, and their density"
    ),
    "births": Drawing(
        "over_a.draw_births", ("p",), "how many words are orbits at each a (run 'orbitdb births' first)"
    ),
    "spectrum": Drawing(
        "levels.draw_length_spectrum", _OF_LEVELS, "the length spectrum of levels beside that of the orbits"
    ),
    "staircase": Drawing(
        "levels.draw_levels", ("a",), "levels below k, and what the orbits give (run 'orbitdb levels' first)"
    ),
    "assess": Drawing("levels.draw_assessment", _OF_LEVELS, "where levels are missing, by the orbits"),
    "spacings": Drawing("levels.draw_spacings", _OF_LEVELS, "the spacings of levels, in units of their mean"),
    "rigidity": Drawing(
        "levels.draw_rigidity", _OF_LEVELS, "Delta_3 of levels, beside that of random matrices"
    ),
    "wave": Drawing(
        "levels.draw_wave", OF_WAVE, "psi^2 of the level nearest to --k, with the orbit of WORD if named"
    ),
    "husimi": Drawing(
        "levels.draw_husimi",
        OF_WAVE,
        "its Husimi function on the boundary, with the bounces of WORD",
    ),
}
"""Every figure; the help, the options that it takes and the drawing follow."""
