"""Split SQL into tokens as SQLite does, to check it before SQLite runs it."""

import re
from typing import NamedTuple

# Characters of a bare name, written as complements: Python takes 10 ms to build large sets.
_BEGIN = r"[^\x00-@\[-^`{-\x7f]"  # letters, _, and everything beyond ASCII
_ON = r"[^\x00-\#%-/:-@\[-^`{-\x7f]"  # the same, and digits and $

_TOKEN = re.compile(
    rf"""
      (?P<blank>   [ \t\n\f\r]+ | --[^\n]* | /\*.*?\*/ )
    | (?P<string>  '(?:[^']|'')*' )
    | (?P<name>    "(?:[^"]|"")*" | `(?:[^`]|``)*` | \[[^\]]*\] )
    | (?P<value>   :[A-Za-z0-9_]+(?![:(]|{_ON}) )
    | (?P<number>  \.?[0-9][0-9A-Za-z_.]* )
    | (?P<word>    {_BEGIN}{_ON}* )
    | (?P<sign>    . )
    """,
    re.VERBOSE | re.DOTALL,
)


class Token(NamedTuple):
    """A piece of SQL: its kind and its text.

    The kinds are ``blank`` (which includes comments), ``string``, ``name`` (in quotes), ``value`` (such as
    ``:name``), ``number``, ``word`` (a keyword or a bare name) and ``sign``.
    """

    kind: str
    text: str

    @property
    def keyword(self) -> str:
        """The text of a word in capitals; empty for tokens of other kinds."""
        return self.text.upper() if self.kind == "word" else ""


def tokens(text: str) -> list[Token]:
    """Split SQL into tokens; joining their texts gives the input again.

    A character that SQLite does not recognise, such as an unpaired quote, becomes a sign.
    """
    return [Token(found.lastgroup or "", found[0]) for found in _TOKEN.finditer(text)]


def meaningful(text: str) -> list[Token]:
    """Split SQL into tokens, leaving out blanks and comments."""
    return [token for token in tokens(text) if token.kind != "blank"]
