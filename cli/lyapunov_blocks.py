"""The averages of ``orbitdb lyapunov`` as a table: a block of rows for each exponent, all methods beside
each other, no wider than a terminal."""

import sys
from collections.abc import Iterable
from typing import Any

from orbitdb.cli.options import Format
from orbitdb.cli.render import concise, write

_METHODS = ("pair", "zeta", "sum_rule")
_EXPONENTS = ("lambda_d", "lambda_c")


def write_blocks(columns: dict[str, list[Any]], periods: Iterable[int]) -> None:
    """Write averages to stdout, by period, z0 in the first block.

    Parameters
    ----------
    columns : dict of str to list
        Those that the other formats have; None where an average does not stand.
    periods : iterable of int
        Those to write.
    """
    places = [columns["p"].index(p) for p in periods]
    for number, exponent in enumerate(_EXPONENTS):
        block = {"p": columns["p"], exponent: columns[exponent]}
        block |= {method: columns[f"{exponent}_{method}"] for method in _METHODS}
        errors = columns[f"{exponent}_sum_rule_error"]
        block["sum_rule"] = list(map(concise, block["sum_rule"], errors))
        if number:
            sys.stdout.write("\n")
        else:
            block["z0"] = columns["z0"]
        write(list(block), [[values[place] for values in block.values()] for place in places], Format.TABLE)
