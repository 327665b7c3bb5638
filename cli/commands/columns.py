"""``orbitdb columns``: explain every column."""

import shutil
import sys
from collections.abc import Sequence
from textwrap import wrap

from orbitdb.cli.output import Output
from orbitdb.columns import GROUPS, IN_CATALOGUE, Column

EXAMPLES = ("columns", "columns --json")

KEYS = ("column", "of", "type", "unit", "bound", "empty", "means")
_LEAST_WIDTH = 24
_GAP = "  "


def columns(*, output: Output) -> None:
    """Explain the columns: their units, the bounds on their errors, and their meanings.

    -c, --order and --where accept the columns of words and orbits, and --bounces writes the columns of
    bounces. query --code adds columns of its own. identify has different columns for a trajectory and for a
    length. The error of a number never exceeds its bound.
    """
    if output.table:
        _write_table([each for _, group in GROUPS for each in group])
        return
    rows = (
        (each.name, of, each.kind, each.unit, each.bound, each.empty, each.means)
        for of, group in GROUPS
        for each in group
    )
    output.write(KEYS, rows)


def _write_table(shown: Sequence[Column]) -> None:
    """Write one line per column, with its meaning wrapped; the columns of the catalogue come first."""
    lines = [("column", "unit", "bounded by", "means")]
    lines += [(each.name, each.unit, each.bound, each.means) for each in shown]
    widths = [max(len(line[k]) for line in lines) for k in range(3)]
    start = sum(widths) + 3 * len(_GAP)
    room = max(shutil.get_terminal_size().columns - start, _LEAST_WIDTH)
    for place, (*cells, means) in enumerate(lines):
        if place == 1 + len(IN_CATALOGUE):
            sys.stdout.write("\n")
        first, *rest = wrap(means, room)
        head = _GAP.join(text.ljust(width) for text, width in zip(cells, widths, strict=True))
        sys.stdout.write("\n".join([f"{head}{_GAP}{first}", *(" " * start + more for more in rest)]) + "\n")
