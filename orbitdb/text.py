"""Text that people read or write: numbers as one writes them, and messages of one line.

Text from a catalogue that somebody else made can be anything, so it is made harmless for terminals and
spreadsheets. Notations of numbers that only programmers use, such as Python's ``1_6`` for 16, are refused.
Closed forms are recognised numerically, without proof.
"""

import math
import re
import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_UP, Context, Decimal
from enum import StrEnum
from fractions import Fraction
from typing import Any, Self

_FORMULA = tuple("=+-@＝＋－＠")
"""Characters that begin a formula in a spreadsheet, including the full-width ones."""

_LONGEST, _END = 1000, 300


class Phrased(StrEnum):
    """Texts of one word, each with the phrase that explains it: ``NAME = "word", "phrase"``.

    Attributes
    ----------
    sentence : str
        The word as a phrase.
    """

    _value_: str
    sentence: str

    def __new__(cls, word: str, sentence: str = "") -> Self:
        """Return the member with a word; a call such as ``Status("orbit")`` needs no phrase."""
        member = str.__new__(cls, word)
        member._value_ = word
        member.sentence = sentence
        return member


def printable(text: str) -> str:
    """Return a text on one line, with control characters escaped.

    The result cannot move the cursor, change colours, hide anything, or run from right to left.
    """
    if text.isprintable():
        return text
    return "".join(
        symbol if symbol.isprintable() else symbol.encode("unicode_escape").decode("ascii") for symbol in text
    )


def line(text: str) -> str:
    """Shorten a message to one line that fits on a screen, but keep its end, which may say what to do."""
    shown = printable(text)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - _END]} ... {shown[-_END:]}"


def shortened(text: str, most: int = 40) -> str:
    """Return a text, cut to at most `most` characters."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def quoted(value: object) -> str:
    """Return a value as the shell takes it; in double quotes, since messages put commands in single ones."""
    text = str(value)
    if text and not re.search(r"[^\w@%+=:,./~-]", text):
        return text
    return '"' + re.sub(r'([\\"$`])', r"\\\1", text) + '"'


def several(count: int, one: str, many: str | None = None) -> str:
    """Return a count with its noun, such as ``1 orbit`` or ``2 orbits``."""
    return f"{count} {one if count == 1 else many or one + 's'}"


_FEW = 3
_HALF_LENGTH = re.compile(r"(?<=\ba = )[^ ,;:()']+|(?<=\ba=)[^ ,)`]+")


def joined(lines: Iterable[str]) -> Iterator[str]:
    """Yield lines in order; of many that differ only in a half length, only the first, with their number."""
    every = [(text, _HALF_LENGTH.sub("a", text)) for text in lines]
    counts, last = Counter(pattern for _, pattern in every), {pattern: text for text, pattern in every}
    for text, pattern in every:
        if counts[pattern] <= _FEW or text == pattern:
            yield text
        elif pattern in last:
            end = next(iter(_HALF_LENGTH.findall(last.pop(pattern))))
            yield f"{text}; likewise at {counts[pattern] - 1} other values of a, the last {end}"


def cell(value: object) -> object:
    """Return a value as it is written in a cell of a csv or tsv file.

    A text that a spreadsheet would read as a formula gets a leading apostrophe. A list becomes its items
    separated by blanks. Numbers do not change, and None makes an empty cell.
    """
    if isinstance(value, list | tuple):
        return " ".join(str(cell(item)) for item in value)
    if isinstance(value, float):
        return value + 0.0  # -0.0 becomes 0.0
    if not isinstance(value, str):
        return value
    text = printable(value)
    return f"'{text}" if text.startswith(_FORMULA) else text


def guess(name: str, names: Iterable[str]) -> str:
    """Return a question that suggests the name closest to a wrong one; empty if none is similar."""
    from difflib import get_close_matches  # seldom needed

    return "".join(f"did you mean {meant}? " for meant in get_close_matches(name, list(names), 1))


# numbers

_REAL = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf|nan)")
_WHOLE = re.compile(r"[+-]?[0-9]{1,40}(?:\.[0-9]{0,40})?(?:[eE]\+?[0-9]{1,2})?")


def real(text: str) -> float:
    """Read a number such as ``1.6`` or ``1e-6``.

    Raises
    ------
    ValueError
        If the text is not a number.
    """
    if not _REAL.fullmatch(text.strip()):
        raise ValueError(f"{shortened(text)!r} is not a number")
    return float(text)


def real_in_file(text: str) -> float:
    """Read a number in a file: as `real` does, or written by NumPy as a complex one without imaginary part.

    Raises
    ------
    ValueError
        If the text is not a real number.
    """
    if text.strip().endswith("j)") and not (value := complex(text.strip())).imag:
        return value.real
    return real(text)


def parse_int(text: str) -> int:
    """Read a whole number such as ``20000``, ``1e6`` or ``2.5e7``.

    Raises
    ------
    ValueError
        If the text is not a whole number, or is too long.
    """
    if not _WHOLE.fullmatch(text.strip()) or (value := Fraction(text.strip())).denominator > 1:
        raise ValueError(f"{shortened(text)!r} is not a whole number")
    return value.numerator


def format_float(a: float) -> str:
    """Format a number in the shortest form that reads back as the same number."""
    return f"{a:g}" if float(f"{a:g}") == a else repr(a)


def as_options(criteria: Mapping[str, Any]) -> list[str]:
    """Return criteria of `Catalogue.select` as the options of a command."""
    words: list[str] = []
    for name, value in criteria.items():
        option = f"--{name.replace('_', '-')}"
        match value:
            case dict():
                named = (f"{name}={_as_parameter(each)}" for name, each in value.items())
                words += [word for pair in named for word in ("--parameter", pair)]
            case tuple():
                low, high = ("" if bound is None else format_float(bound) for bound in value)
                words += ["--range", f"{name}={low}:{high}"]
            case list():
                words += [word for each in value for word in (option, _as_word(each))]
            case _:
                words += [option, _as_word(value)]
    return words


def _as_parameter(value: str | float) -> str:
    """Return a value as ``--parameter`` reads it: digits alone could be a word or a number."""
    if not isinstance(value, str):
        return f"{value:+}" if isinstance(value, int) else repr(value)
    is_plain = value == value.strip("'\" \t\n") and not _REAL.fullmatch(value)
    return value if is_plain else f"'{value}'"


def _as_word(value: str | float) -> str:
    return value if isinstance(value, str) else format_float(value)


def shell_line(words: Iterable[str]) -> str:
    """Return a command as one types it; double quotes are easier to read around single ones."""
    return " ".join(
        f'"{word}"' if "'" in word and not set(word) & set('"$`\\!') else shlex.quote(word) for word in words
    )


_UPWARDS = Context(prec=2, rounding=ROUND_UP)
"""Two digits, rounded up, whatever context this program's caller has set."""


def between(lower: float, name: str, upper: float) -> str:
    """Format a name between the proved bounds on its value, rounded outward."""
    return f"{outward(lower, ROUND_FLOOR)} < {name} < {outward(upper, ROUND_CEILING)}"


def outward(value: float, rounding: str, places: int = 8) -> str:
    """Format a proved bound with some decimals, rounded in the given direction."""
    own = Context(prec=400)  # whatever precision this program's caller has set
    return f"{Decimal.from_float(value).quantize(Decimal((0, (1,), -places)), rounding, own):f}"


def upwards(bound: float, more: float = 0.0) -> str:
    """Format the sum of a bound and `more` with two digits, rounded up so that it remains a bound."""
    total = _UPWARDS.add(Decimal.from_float(bound), Decimal.from_float(more))
    return f"{float(total):.1e}"


def with_bound(value: float, bound: float, sign: str = "+-") -> str:
    """Format a number with all its digits, and with a bound that includes the rounding of the last digit."""
    return f"{value!r} {sign} {upwards(bound, math.ulp(value) / 2)}"


def with_error(value: float, error: float, sign: str = "+-") -> str:
    """Format a value with its standard error."""
    return f"{as_sure(value, error)} {sign} {upwards(error)}"


def as_sure(value: float, error: float) -> str:
    """Format a value with decimals down to the second digit of its error, but at least six."""
    return f"{value:z.{max(6, 1 - math.floor(math.log10(error)) if 0 < error < math.inf else 6)}f}"


def concise(value: float | None, error: float | None) -> str | None:
    """Format a value with two digits of its error, rounded up, in brackets; 0.88677(22) means +- 0.00022."""
    if value is None or error is None or not 0 < error < math.inf:
        return None if value is None else f"{value:z.6f}"
    digits = _UPWARDS.plus(Decimal.from_float(error))
    decimals = max(0, -int(digits.as_tuple().exponent))
    return f"{value:z.{decimals}f}({round(digits.scaleb(decimals, _UPWARDS))})"


def in_brackets(value: float, bound: float) -> str:
    """Format a number with one digit of its bound in brackets: 22.45(3) means within 0.03 of 22.45.

    The bound includes the rounding of the number that is shown.
    """
    if not 0 < bound < math.inf:
        return repr(value) if bound == 0 else f"{value:.1g}(inf)"
    exact, decimals = Decimal.from_float(value), max(0, -math.floor(math.log10(bound)))
    own = Context(prec=400)  # whatever precision this program's caller has set
    while True:
        shown = exact.quantize(Decimal((0, (1,), -decimals)), context=own)
        off = own.add(Decimal.from_float(bound), own.subtract(exact, shown).copy_abs())
        units = off.scaleb(decimals, own).to_integral_value(ROUND_CEILING)
        if units < 10 or not decimals:
            return f"{shown:f}({units})"
        decimals -= 1


def gigabytes(count: float) -> str:
    """Format a number of bytes in a suitable unit."""
    if count >= 1e11:
        return f"{count / 1e9:.0f} GB"
    for unit, size in (("GB", 1e9), ("MB", 1e6)):
        if count >= size:
            return f"{count / size:.2g} {unit}" if count < 99.5 * size else f"{count / size:.0f} {unit}"
    return f"{max(count / 1e3, 1):.0f} kB"
