"""Bounds on the topological entropy, as they are found and as a catalogue has them."""

from dataclasses import dataclass

from orbitdb.numerals import between

DOUBLES, BALLS = "doubles", "balls"
"""What decides windows: doubles with bounds on their errors, or ball arithmetic, too."""


@dataclass(frozen=True)
class EntropyBounds:
    """What windows of one length prove of the topological entropy at one a, per bounce.

    Attributes
    ----------
    a : float
        Half length of a straight wall.
    window : int
        Edges of the longest windows.
    lower, upper : float
        h_top lies between them; rounded outward.
    windows : int
        Windows decided so far, up to mirror and reversal.
    undecided : int
        Windows of this length that are not decided.
    proof : str
        What has decided them, where they are stored: `DOUBLES` or `BALLS`.
    """

    a: float
    window: int
    lower: float
    upper: float
    windows: int
    undecided: int
    proof: str = DOUBLES

    @property
    def width(self) -> float:
        """How far the bounds are apart."""
        return self.upper - self.lower

    @property
    def between(self) -> str:
        """The bounds in words, rounded outward."""
        return between(self.lower, "h", self.upper)

    @property
    def basis(self) -> str:
        """What the bounds rest on, in words."""
        how = "in balls" if self.proof == BALLS else "in doubles with error bounds"
        return f"windows of {self.window} edges {how}"
