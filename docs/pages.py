"""Find the examples on a page, and tell whether an output agrees with the output that the page shows."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
"""Every page whose examples are run."""

_PYTHON = ("python", "{code-cell}")
_EXAMPLES = ("console", *_PYTHON, "bash", "sh")
_FENCE = re.compile(r"```(\S*)")
_COMMENT = re.compile(r"<!-- (not run: .+|times|varies) -->")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
_TOKEN = re.compile(rf"{_NUMBER.pattern}|[^\s,]+")
_ASIDE = (
    (re.compile(r"\d[\d.e+-]* (?:s|ms|µs|minutes|hours|days)\b"), "TIME"),
    (re.compile(r"\d[\d.e+-]* (?:bytes|kB|MB|GB|TB)\b"), "SIZE"),
    (re.compile(r"\borbitdb \d+\.\d+\S*"), "orbitdb VERSION"),
)
_SMALL = 1e-9
"""Smaller numbers are residuals and error bounds. They depend on rounding, and may differ by a tenth."""

_ROUNDING = 1e-14
"""Still smaller numbers are nothing but rounding, and may differ by any factor."""


@dataclass(frozen=True)
class Block:
    """A fenced block on a page.

    Attributes
    ----------
    start, end : int
        The block without its fences is ``lines[start:end]`` of the page.
    """

    language: str
    start: int
    end: int
    mark: str

    def text(self, lines: list[str]) -> str:
        """Return the text of the block."""
        return "\n".join(lines[self.start : self.end])


@dataclass(frozen=True)
class Example:
    """A command or a piece of Python code, and its output as the page shows it.

    Attributes
    ----------
    start, end : int
        The output is ``lines[start:end]`` of the page.
    line : int
        The line of the command, counted from 1.
    """

    language: str
    source: str
    shown: str
    start: int
    end: int
    line: int
    mark: str

    def holds(self, output: str) -> bool:
        """Tell whether the page shows this output, apart from what may vary."""
        return same(self.shown, output, self.mark)


def blocks(lines: list[str]) -> list[Block]:
    """Find the fenced blocks of a page, each with the mark in the comment before it."""
    found: list[Block] = []
    mark, n = "", 0
    while n < len(lines):
        if comment := _COMMENT.fullmatch(lines[n].strip()):
            mark = comment[1]
        elif fence := _FENCE.match(lines[n]):
            end = next(k for k in range(n + 1, len(lines)) if lines[k].rstrip() == "```")
            found.append(Block(fence[1], n + 1, end, mark))
            mark, n = "", end
        elif lines[n].strip():
            mark = ""
        n += 1
    return found


def examples(page: Path) -> list[Example]:
    """Return the examples on a page that can be run.

    Raises
    ------
    ValueError
        If a block cannot be run and no comment says why.
    """
    lines = page.read_text(encoding="utf-8").splitlines()
    found: list[Example] = []
    parts = blocks(lines)
    for block, behind in zip_longest(parts, parts[1:]):
        if block.language not in _EXAMPLES or block.mark.startswith("not run"):
            continue
        if block.language in _PYTHON:
            found.append(_python(block, behind, lines))
        elif block.language == "console" and lines[block.start].startswith("$ "):
            found += _commands(block, lines)
        else:
            raise ValueError(f"{page.name}:{block.start}: mark this block as not run, and say why")
    return found


def _python(block: Block, behind: Block | None, lines: list[str]) -> Example:
    start = end = block.end
    if behind is not None and behind.language == "text":
        between = lines[block.end + 1 : behind.start - 1]
        if not any(line not in ("", "<!-- shows") for line in between):
            start, end = behind.start, behind.end
    shown = "\n".join(lines[start:end])
    return Example("python", block.text(lines), shown, start, end, block.start + 1, block.mark)


def _commands(block: Block, lines: list[str]) -> Iterator[Example]:
    starts = [n for n in range(block.start, block.end) if lines[n].startswith("$ ")]
    for start, end in zip(starts, [*starts[1:], block.end], strict=True):
        behind = start + 1
        while lines[behind - 1].endswith("\\"):
            behind += 1
        source = "\n".join([lines[start][2:], *lines[start + 1 : behind]])
        shown = "\n".join(lines[behind:end]).rstrip()
        yield Example("console", source, shown, behind, end, start + 1, block.mark)


def same(shown: str, output: str, mark: str = "") -> bool:
    """Tell whether two outputs agree: words exactly, numbers up to their last digits or within their errors.

    If all words and numbers are equal, the blanks between them must agree as well. With the mark ``varies``,
    all numbers may differ; with ``times``, numbers that are not integers may.
    """
    mine, other = _tokens(shown), _tokens(output)
    if mine == other:
        return mark == "times" or _without_asides(shown) == _without_asides(output)
    if len(mine) != len(other):
        return False
    for n, (one, two) in enumerate(zip(mine, other, strict=True)):
        if one == two:
            continue
        if not (_NUMBER.fullmatch(one) and _NUMBER.fullmatch(two)):
            return False
        may_be_any = mark == "varies" or (mark == "times" and not _is_whole(one) and not _is_whole(two))
        if not (may_be_any or _near(one, two, _error(mine, n) + _error(other, n))):
            return False
    return True


def _tokens(text: str) -> list[str]:
    return _TOKEN.findall(_without_asides(text))


def _without_asides(text: str) -> str:
    for pattern, name in _ASIDE:
        text = pattern.sub(name, text)
    return text


def _error(tokens: list[str], n: int) -> float:
    """Return the error given after a number, or 0 if there is none."""
    given = tokens[n + 1 : n + 3]
    return float(given[1]) if len(given) == 2 and given[0] == "+-" and _NUMBER.fullmatch(given[1]) else 0.0


def _is_whole(number: str) -> bool:
    return not any(mark in number for mark in ".e")


def _near(one: str, two: str, error: float) -> bool:
    x, y = float(one), float(two)
    if _is_whole(one):
        return False
    mantissa, _, power = one.partition("e")
    last = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    if max(abs(x), abs(y)) < _SMALL:
        return max(abs(x), abs(y)) < _ROUNDING or abs(x - y) <= max(abs(x) / 10, 1.01 * last)
    return abs(x - y) <= max(2.5 * last, 5e-15 * abs(x), 3 * error)
