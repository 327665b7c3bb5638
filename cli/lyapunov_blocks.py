"""The averages of ``orbitdb lyapunov`` as a table: a block of rows for each exponent, all methods beside
each other, no wider than a terminal."""

import sys
from collections.abc import Sequence
from typing import Any

from orbitdb.cli.options import Format
from orbitdb.cli.render import write
from orbitdb.numerals import concise

_METHODS = ("pair", "zeta", "sum_rule")
_EXPONENTS = ("lambda_d", "lambda_c")


def write_blocks(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write averages to stdout, by period, z0 in the first block.

    Parameters
    ----------
    names : sequence of str
        Those of the other formats.
    rows : sequence of sequences
        Theirs; None where an average does not stand.
    """
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    for number, exponent in enumerate(_EXPONENTS):
        block = {name: columns[name] for name in ("a", "p", exponent) if name in columns}
        block |= {method: columns[f"{exponent}_{method}"] for method in _METHODS}
        errors = columns[f"{exponent}_sum_rule_error"]
        block["sum_rule"] = list(map(concise, block["sum_rule"], errors))
        if number:
            sys.stdout.write("\n")
        else:
            block["z0"] = columns["z0"]
        write(list(block), list(zip(*block.values(), strict=True)), Format.TABLE)
