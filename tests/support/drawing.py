"""Figures of chosen subsets by their names, as the command `plot` draws them."""

from typing import Any

from matplotlib.figure import Figure

from orbitdb.cli.figures import subsets


def draw(kind: str, catalogue: Any, chosen: Any, limit: int) -> Figure:
    """Draw a figure of a subset; the limit is of orbits on a sheet."""
    more = {"limit": limit} if kind == "sheet" else {}
    return getattr(subsets, f"draw_{kind.replace('-', '_')}")(catalogue, chosen, **more)
