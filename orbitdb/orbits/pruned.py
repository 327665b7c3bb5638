"""What is known of a word without solving it: that the rules prune it, or that it is the family 02."""

from orbitdb.orbits.orbit import Orbit, Status
from orbitdb.symbols.pruning import FAMILY, rules_of
from orbitdb.symbols.words import least_rotation


def pruned_word(word: str, a: float) -> Orbit | None:
    """Return what a primitive word is that no orbit can have: pruned, or the family 02; else None."""
    least = least_rotation(word)
    if least == FAMILY:
        return Orbit(word, least, a, Status.FAMILY)
    rules = tuple(rules_of(word))
    return Orbit(word, least, a, Status.GEOMETRIC, rules) if rules else None
