"""Measure the contrasts of what the screen shows, cell by cell."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from textual.color import Color

from orbitdb.cli.tui.colours import contrast


class Cells(NamedTuple):
    """Neighbouring cells of the same style: their line, column and text, and their two colours."""

    y: int
    x: int
    text: str
    ink: Color
    ground: Color

    @property
    def contrast(self) -> float:
        return contrast(self.ink, self.ground)


def cells_of(app: Any) -> Iterator[Cells]:
    """Yield the cells of the screen that are not blank."""
    for y, strip in enumerate(app.screen._compositor.render_strips()):
        x = 0
        for segment in strip:
            style = segment.style
            if segment.text.strip():
                assert style is not None
                assert style.color is not None
                assert style.bgcolor is not None
                ink, ground = Color.from_rich_color(style.color), Color.from_rich_color(style.bgcolor)
                if style.reverse:
                    ink, ground = ground, ink
                yield Cells(y, x, segment.text, ground.blend(ink, ink.a), ground)
            x += segment.cell_length


_DRAWN = {*map(chr, range(0x2500, 0x25A0)), *map(chr, range(0x2800, 0x2900)), " "} - {"─"}
"""Lines, blocks and dots, which are not text."""


def texts_of(app: Any) -> Iterator[Cells]:
    """Yield the cells with text: at least one letter, digit or sign that is not a line or a block."""
    return (cells for cells in cells_of(app) if not set(cells.text) <= _DRAWN | {"─"})
