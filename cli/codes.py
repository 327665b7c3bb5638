"""Codes as they are given on the command line."""

import sys
from collections.abc import Iterable, Iterator
from itertools import chain

from orbitdb.cli.render import note, repeats
from orbitdb.errors import InputError

_AROUND = " \t\r\n\ufeff"
"""What may stand around a code; Windows begins files with a mark of the order of bytes."""


def given_codes(*given: Iterable[str] | None) -> Iterator[str]:
    """Return the codes given, the lines of stdin in the place of ``-``, without checking them.

    Parameters
    ----------
    *given : iterable of str, optional
        The words, and those behind ``--code``; None where there are none.
    """
    try:
        for code in chain.from_iterable(codes or () for codes in given):
            if code == "-":
                yield from (code for line in sys.stdin or () if (code := line.strip(_AROUND)))
            else:
                yield code
    except UnicodeDecodeError:
        raise InputError("stdin is not text: write one code a line") from None


def primitive(code: str) -> str:
    """Read a code; where it repeats a shorter word, say so and return that."""
    from orbitdb.symbols.words import parse, primitive_root

    word = parse(code)
    root = primitive_root(word)
    if root != word:
        note(repeats(word, root))
    return root
